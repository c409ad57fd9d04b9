# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 1, match the camera: lines of the photograph give it before there is a model, pairs of points and pixels once
there is one, with an error per pair."""

import os
import re
import warnings

import bpy
import numpy as np
import unrender
from bpy.props import BoolProperty, FloatVectorProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from . import frames, model, pictures
from .properties import UNKNOWN

LINES = "unrender lines"
"""The name of the picture of the lines that were found."""

LEAST = 5
"""The least number of pairs for pose and focal length; one fewer for a known lens, one more for a
shift."""


def least(settings):
    """The number of pairs that the camera needs."""
    return LEAST - settings.held_fov + settings.principal_point


class UNRENDER_OT_load_photo(bpy.types.Operator, ImportHelper):
    """Load the photograph, and show it behind the scene through the camera"""

    bl_idname = "unrender.load_photo"
    bl_label = "Load photograph"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: StringProperty(default="*.png;*.jpg;*.jpeg;*.tif;*.tiff;*.exr;*.hdr", options={"HIDDEN"})

    def execute(self, context):
        scene, settings = context.scene, context.scene.unrender
        if not os.path.isfile(self.filepath):
            self.report({"ERROR"}, f"{self.filepath}: there is no such file")
            return {"CANCELLED"}
        image = pictures.load(self.filepath, pictures.PHOTO)
        width, height = image.size
        if width * height == 0:
            self.report({"ERROR"}, f"{self.filepath}: Blender cannot read this picture")
            return {"CANCELLED"}
        settings.photo, settings.size = self.filepath, (width, height)
        is_linear = os.path.splitext(self.filepath)[1].lower() in {".exr", ".hdr"}
        settings.response = "linear" if is_linear else "srgb"
        if scene.camera is None:
            thing = bpy.data.objects.new("photo", bpy.data.cameras.new("photo"))
            thing.matrix_world = frames.Matrix.Translation((0.0, -5.0, 1.6)) @ frames.LEVEL
            scene.collection.objects.link(thing)
            scene.camera = thing
        pictures.through(scene, image, (width, height))
        return {"FINISHED"}


class UNRENDER_OT_add_pair(bpy.types.Operator):
    """Add a point of the scene with its place in the photograph"""

    bl_idname = "unrender.add_pair"
    bl_label = "Add pair"
    bl_options = {"REGISTER", "UNDO"}

    point: FloatVectorProperty(name="Point", size=3, subtype="XYZ")
    pixel: FloatVectorProperty(name="Pixel", size=2)

    def execute(self, context):
        settings = context.scene.unrender
        pair = settings.pairs.add()
        pair.point, pair.pixel = self.point, self.pixel
        pair.name = f"point {len(settings.pairs)}"
        settings.pair = len(settings.pairs) - 1
        return {"FINISHED"}


class UNRENDER_OT_remove_pair(bpy.types.Operator):
    """Remove the pair"""

    bl_idname = "unrender.remove_pair"
    bl_label = "Remove pair"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(default=-1)

    def execute(self, context):
        settings = context.scene.unrender
        index = self.index if self.index >= 0 else settings.pair
        if not 0 <= index < len(settings.pairs):
            return {"CANCELLED"}
        settings.pairs.remove(index)
        settings.pair = max(0, min(settings.pair, len(settings.pairs) - 1))
        return {"FINISHED"}


class UNRENDER_OT_match_camera(bpy.types.Operator):
    """Find the camera of the photograph from the pairs"""

    bl_idname = "unrender.match_camera"
    bl_label = "Match camera"
    bl_options = {"REGISTER", "UNDO"}

    keep: BoolProperty(name="Keep the camera", description="Only measure how far the pairs are off")

    @classmethod
    def poll(cls, context):
        return bool(context.scene.unrender.photo)

    def execute(self, context):
        settings = context.scene.unrender
        if len(settings.pairs) < least(settings) and not self.keep:
            self.report({"ERROR"}, f"{least(settings)} pairs at least; twice as many also show which are wrong")
            return {"CANCELLED"}
        try:
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always", unrender.UnrenderWarning)
                if not self.keep:
                    calibrate(context)
            measure(context)
        except (unrender.Error, model.Missing) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for warning in told:
            self.report({"WARNING"}, str(warning.message))
        self.report({"INFO"}, settings.focal)
        return {"FINISHED"}


class UNRENDER_OT_lines_camera(bpy.types.Operator):
    """Find the camera from straight lines of the photograph, before anything is modelled: look whether the
    coloured lines run along the room's axes, and model over the photograph"""

    bl_idname = "unrender.lines_camera"
    bl_label = "Camera from lines"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return bool(context.scene.unrender.photo)

    def execute(self, context):
        scene, settings = context.scene, context.scene.unrender
        drawn = os.path.join(model.folder_of(scene), "lines.png")
        try:
            photo, _ = model.photo_of(scene)
            os.makedirs(os.path.dirname(drawn), exist_ok=True)
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always", unrender.UnrenderWarning)
                found = unrender.calibrate(
                    photo, lines="auto", camera_height=settings.camera_height, show_lines=drawn
                )
        except (unrender.Error, model.Missing) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for warning in told:
            self.report({"WARNING"}, str(warning.message))
        frames.place_camera(scene.camera, found.camera)
        pictures.show(pictures.load(drawn, LINES))
        settings.calibration = found.summary
        settings.focal = focal_length(found.summary)
        self.report({"INFO"}, settings.focal)
        return {"FINISHED"}


def calibrate(context):
    """Moves the scene's camera to the place that the pairs give."""
    scene, settings = context.scene, context.scene.unrender
    photo, size = model.photo_of(scene)
    folder = model.folder_of(scene)
    shapes, *_ = model.scene_of(context)
    shapes.save(os.path.join(folder, "model.glb"))
    camera = scene.camera
    seen = frames.camera_of(camera, context.evaluated_depsgraph_get(), size)
    found = unrender.calibrate(
        photo,
        scene=os.path.join(folder, "model.glb"),
        points=([pair.pixel[:] for pair in settings.pairs], frames.y_up([p.point[:] for p in settings.pairs])),
        fov_y_deg=seen.fov_y_deg if settings.held_fov else None,
        principal_point=settings.principal_point,
    )
    frames.place_camera(camera, found.camera)
    context.view_layer.update()
    settings.calibration = found.summary
    settings.focal = focal_length(found.summary)
    thrown_out = set(re.findall(r"^thrown out: point (\d+),", found.summary, re.MULTILINE))
    for number, pair in enumerate(settings.pairs, 1):
        pair.rejected = str(number) in thrown_out


def measure(context):
    """The distance of every pair's point from its pixel, for the present camera."""
    scene, settings = context.scene, context.scene.unrender
    _, size = model.photo_of(scene)
    camera = frames.camera_of(scene.camera, context.evaluated_depsgraph_get(), size)
    points = frames.y_up([pair.point[:] for pair in settings.pairs])
    for pair, seen in zip(settings.pairs, camera.project(points, *size)):
        off = float(np.linalg.norm(seen - np.array(pair.pixel[:])))
        pair.error = off if np.isfinite(off) else UNKNOWN


def focal_length(summary):
    """The line of the summary about the focal length, with its standard deviation."""
    row = re.search(r"^focal length\s+(\S+)\s+(\S+)", summary, re.MULTILINE)
    if row is None:
        return ""
    value, std = row.groups()
    return f"focal length {value} px, " + ("held" if std == "held" else f"standard deviation {std} px")


CLASSES = (
    UNRENDER_OT_load_photo,
    UNRENDER_OT_add_pair,
    UNRENDER_OT_remove_pair,
    UNRENDER_OT_match_camera,
    UNRENDER_OT_lines_camera,
)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
