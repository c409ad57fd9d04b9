# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 2, prepare: materials as groups, and a check for problems that would spoil a recovery."""

import os
from collections import Counter

import bpy
import unrender

from . import geometry, job, model, pictures, shaders

CHECK = "unrender check"


class UNRENDER_OT_list_groups(bpy.types.Operator):
    """List the materials of rendered objects; ticks stay"""

    bl_idname = "unrender.list_groups"
    bl_label = "List materials"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        refresh(context)
        return {"FINISHED"}


def refresh(context):
    """Updates the list of materials from the scene."""
    settings = context.scene.unrender
    ticks = {geometry.group_name(g.material): (g.known, g.ignored) for g in settings.groups}
    _, materials = geometry.meshes(context.evaluated_depsgraph_get())
    settings.groups.clear()
    for name, material in sorted(materials.items()):
        item = settings.groups.add()
        item.name = name
        item.material = geometry.first(material.original) if material else None
        item.known, item.ignored = ticks.get(name, (False, False))
        item.emits = shaders.brightness(shaders.group_of(material, []).emission) > 0.0


class UNRENDER_OT_check(bpy.types.Operator):
    """Look for problems that would spoil a recovery, and draw the model's edges over the photograph: green
    where it has them too; red where it has them elsewhere, which is yellow; blue where it shows none"""

    bl_idname = "unrender.check"
    bl_label = "Check"

    wait: bpy.props.BoolProperty(default=False, options={"SKIP_SAVE", "HIDDEN"})

    @classmethod
    def poll(cls, context):
        settings = context.scene.unrender
        return bool(settings.photo or settings.shots) and not job.is_running()

    def execute(self, context):
        refresh(context)
        try:
            path, _, doubts = model.project_of(context)
        except (unrender.Error, model.Missing) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        picture = os.path.join(os.path.dirname(path), "check.png")

        def work(progress, token):
            return unrender.check(path, out=picture)

        started = job.start("Check", context.scene, work, lambda ended: show(ended, picture, doubts))
        return job.finish(self, started, self.wait)


def show(ended, picture, doubts):
    """The result of a check in the panel and over the view through the camera."""
    scene = bpy.data.scenes[ended.scene]
    settings, document = scene.unrender, ended.result.document
    further = document.get("further", [])
    pixels = Counter()
    for of_photo in (document, *further):
        pixels.update({group["name"]: group.get("pixels", 0) for group in of_photo["groups"]})
    for item in settings.groups:
        item.pixels = pixels[item.name]
    told = [*doubts, *(w for of_photo in (document, *further) for w in of_photo.get("warnings", []))]
    if further:
        # Of several the last: that of step 1, if there is one.
        stem, kind = os.path.splitext(picture)
        picture = f"{stem}_{1 + len(further)}{kind}"
    settings.messages = "\n".join(dict.fromkeys(told))
    settings.message = f"Check: {len(told)} warnings" if told else "Check: nothing to mend"
    image = pictures.load(picture, CHECK)
    camera = scene.camera or settings.shots[-1].camera
    pictures.behind(camera.data, image, "FRONT", 0.8)
    pictures.show(image)


class UNRENDER_OT_toggle_overlay(bpy.types.Operator):
    """Show or hide the check's picture over the view through the camera"""

    bl_idname = "unrender.toggle_overlay"
    bl_label = "Overlay"

    @classmethod
    def poll(cls, context):
        return context.scene.camera is not None and CHECK in bpy.data.images

    def execute(self, context):
        for entry in context.scene.camera.data.background_images:
            if entry.image is not None and entry.image.name == CHECK:
                entry.show_background_image = not entry.show_background_image
        return {"FINISHED"}


CLASSES = (UNRENDER_OT_list_groups, UNRENDER_OT_check, UNRENDER_OT_toggle_overlay)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
