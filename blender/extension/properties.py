# SPDX-License-Identifier: GPL-3.0-or-later
"""The properties that the panel shows, which are saved with the scene in the file."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

UNKNOWN = -1.0


class UnrenderPair(bpy.types.PropertyGroup):
    """A point of the scene and its place in the photograph."""

    point: FloatVectorProperty(name="Point", size=3, subtype="XYZ", unit="LENGTH")
    pixel: FloatVectorProperty(name="Pixel", size=2, description="From the photograph's top left corner")
    error: FloatProperty(name="Error", default=UNKNOWN, description="Distance in the photograph, pixels")
    rejected: BoolProperty(name="Wrong", description="This pair was not used to find the camera")


class UnrenderGroup(bpy.types.PropertyGroup):
    """A material of the scene: all surfaces that have it reflect in the same way."""

    material: PointerProperty(type=bpy.types.Material)
    known: BoolProperty(name="Known", description="Keep this material as it is in Blender")
    ignored: BoolProperty(name="Ignore", description="Leave out surfaces with this material")
    emits: BoolProperty(name="Emits")
    pixels: IntProperty(name="Pixels", description="Pixels of the photograph that show it")


class UnrenderShot(bpy.types.PropertyGroup):
    """A photograph that is kept beside the one of step 1."""

    photo: StringProperty(name="Photograph", subtype="FILE_PATH")
    size: bpy.props.IntVectorProperty(name="Size", size=2)
    response: StringProperty()
    camera: PointerProperty(type=bpy.types.Object)
    image: PointerProperty(type=bpy.types.Image)


class UnrenderResult(bpy.types.PropertyGroup):
    """The result for a material."""

    material: PointerProperty(type=bpy.types.Material)
    made: PointerProperty(type=bpy.types.Material)
    hypothesis: StringProperty()
    status: StringProperty()
    note: StringProperty()
    numbers: StringProperty(description="Parameters with their standard deviations, a line each")


class UnrenderSettings(bpy.types.PropertyGroup):
    """The state of the five steps."""

    photo: StringProperty(name="Photograph", subtype="FILE_PATH")
    size: bpy.props.IntVectorProperty(name="Size", size=2)
    shots: CollectionProperty(type=UnrenderShot)
    shot: IntProperty(name="Photograph")
    folder: StringProperty(
        name="Folder",
        subtype="DIR_PATH",
        description="The folder of project and results; by default beside the .blend file",
    )
    pairs: CollectionProperty(type=UnrenderPair)
    pair: IntProperty(name="Pair")
    held_fov: BoolProperty(name="Known lens", description="Keep the camera's field of view")
    principal_point: BoolProperty(name="Find the shift", description="For cropped photographs")
    camera_height: FloatProperty(
        name="Height",
        default=1.6,
        min=1e-3,
        unit="LENGTH",
        description="The camera's height above the floor, which the size of the room follows from",
    )
    calibration: StringProperty(name="Calibration")
    focal: StringProperty(name="Focal length")

    groups: CollectionProperty(type=UnrenderGroup)
    group: IntProperty(name="Material")
    messages: StringProperty(name="Messages", description="A line each")

    response: EnumProperty(
        name="Response",
        items=[
            ("srgb", "sRGB", "JPEG or PNG as cameras write them"),
            ("linear", "Linear", "EXR or HDR"),
            ("auto", "Find", "Find the camera's curve"),
        ],
        default="srgb",
    )
    exposure: FloatProperty(
        name="Exposure", default=1.0, min=1e-9, description="Scene radiance of a linear pixel value of one"
    )
    is_anchored: BoolProperty(
        name="Unknown exposure", description="A known material, the anchor, determines it"
    )
    anchor: StringProperty(name="Anchor", description="A diffuse material whose colour is known")
    max_rung: EnumProperty(
        name="Up to",
        items=[
            ("all", "All", "All hypotheses"),
            ("isotropic", "Gloss", "No anisotropy and no textures"),
            ("diffuse", "Diffuse", "Diffuse reflectance only"),
        ],
        default="all",
    )
    spp: IntProperty(name="Samples", default=64, min=1, description="Samples per pixel of the pictures")
    running: StringProperty(name="Running")
    progress: FloatProperty(name="Progress", min=0.0, max=1.0, subtype="FACTOR")
    message: StringProperty(name="Message")
    results: CollectionProperty(type=UnrenderResult)
    result: IntProperty(name="Result")
    is_applied: BoolProperty(name="Applied")
    grain: BoolProperty(name="Grain", description="Add the photograph's noise to inserted objects")


CLASSES = (UnrenderPair, UnrenderGroup, UnrenderShot, UnrenderResult, UnrenderSettings)


@bpy.app.handlers.persistent
def forget_work(*_):
    """Clears running work when a file is loaded: it does not continue there, but a file that was
    saved meanwhile still shows it."""
    for scene in bpy.data.scenes:
        scene.unrender.running = ""


def register():
    for made in CLASSES:
        bpy.utils.register_class(made)
    bpy.types.Scene.unrender = PointerProperty(type=UnrenderSettings)
    bpy.app.handlers.load_post.append(forget_work)


def unregister():
    bpy.app.handlers.load_post.remove(forget_work)
    del bpy.types.Scene.unrender
    for made in reversed(CLASSES):
        bpy.utils.unregister_class(made)
