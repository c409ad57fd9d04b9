"""Photographs of a room by Cycles, and what is true in each of their pixels."""

import math
import pathlib
from collections.abc import Callable
from typing import Any

import bpy
import numpy as np
from mathutils import Vector
from numpy.typing import NDArray

from materials import Paint

Pixels = NDArray[np.float32]

FORWARD = Vector((0.0, 0.0, -1.0))
"""Where a camera or a light without rotation looks."""
BOUNCES = 32
"""Reflections along a path. Twelve, Blender's default, lose 0.3 % of a white room; 64 gain nothing that shows."""
TRUTH_SAMPLES = 64
"""Samples per pixel of the pictures of truth: a pixel is pure if all show one group. With 16, one pixel of a
hundred that are named pure has a tenth of another group."""


def settings(size: tuple[int, int], samples: int, threads: int) -> None:
    """Cycles without what biases its pictures: no clamping, no blurred caustics, no dropped lights."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.threads_mode, scene.render.threads = "FIXED", threads
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    cycles = scene.cycles
    cycles.device, cycles.samples = "CPU", samples
    cycles.use_denoising = cycles.use_adaptive_sampling = cycles.use_light_tree = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.light_sampling_threshold = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = BOUNCES
    cycles.transparent_max_bounces = 64
    # A pixel is the mean over its area, as unrender has it.
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0


def take(path: pathlib.Path, camera: str, seed: int) -> None:
    """Renders into ``path`` (.exr, linear), and beside it the same picture as 8-bit sRGB."""
    scene = bpy.context.scene
    scene.camera, scene.cycles.seed = bpy.data.objects[camera], seed
    save = scene.render.image_settings
    save.file_format, save.color_depth, save.color_mode = "OPEN_EXR", "32", "RGB"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    save.file_format, save.color_depth = "PNG", "8"
    bpy.data.images["Render Result"].save_render(str(path.with_suffix(".png")))


def pixels_of(path: pathlib.Path) -> Pixels:
    """The pixels of an EXR file, (rows, columns, 3), top row first."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    values = np.empty(width * height * image.channels, dtype=np.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    return values.reshape(height, width, -1)[::-1, :, :3]


def write(path: pathlib.Path, pixels: Pixels) -> None:
    """An EXR file of 32-bit floats."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(path.stem, width, height, float_buffer=True, is_data=True)
    full = np.dstack([pixels, np.ones((height, width))])
    image.pixels.foreach_set(np.ascontiguousarray(full[::-1], dtype=np.float32).ravel())
    save = bpy.context.scene.render.image_settings
    save.file_format, save.color_depth, save.color_mode = "OPEN_EXR", "32", "RGB"
    image.save_render(str(path))
    bpy.data.images.remove(image)


def switch(name: str, on: bool) -> None:
    """Switches a lamp on or off: a light of this name, or a material that emits."""
    light = bpy.data.objects.get(name)
    if light is not None and light.type == "LIGHT":
        light.hide_render = not on
        return
    shader = bpy.data.materials[name].node_tree.nodes["Principled BSDF"]
    strength = shader.inputs["Emission Strength"]
    shader["strength"] = shader.get("strength", strength.default_value)
    strength.default_value = shader["strength"] if on else 0.0


def shows(material: bpy.types.Material, value: tuple[float, float, float] | None) -> None:
    """Makes a material emit ``value`` whatever shines on it, or its base colour; cut-outs stay cut out."""
    tree = material.node_tree
    shader = tree.nodes["Principled BSDF"]
    plain = tree.nodes.get("truth") or tree.nodes.new("ShaderNodeEmission")
    plain.name = "truth"
    for link in list(plain.inputs["Color"].links):
        tree.links.remove(link)
    base = shader.inputs["Base Color"]
    if value is not None:
        plain.inputs["Color"].default_value = (*value, 1.0)
    elif base.is_linked:
        tree.links.new(base.links[0].from_socket, plain.inputs["Color"])
    else:
        plain.inputs["Color"].default_value = base.default_value
    shown = plain.outputs[0]
    coverage = shader.inputs["Alpha"]
    if coverage.is_linked:
        mix = tree.nodes.get("truth mix") or tree.nodes.new("ShaderNodeMixShader")
        mix.name = "truth mix"
        clear = tree.nodes.get("truth clear") or tree.nodes.new("ShaderNodeBsdfTransparent")
        clear.name = "truth clear"
        tree.links.new(coverage.links[0].from_socket, mix.inputs[0])
        tree.links.new(clear.outputs[0], mix.inputs[1])
        tree.links.new(plain.outputs[0], mix.inputs[2])
        shown = mix.outputs[0]
    tree.links.new(shown, tree.nodes["Material Output"].inputs["Surface"])


def truths(folder: pathlib.Path, suffix: str, camera: str, groups: dict[str, Any], paints: dict[str, Paint]) -> None:
    """albedo, roughness and group.exr: the base colour; roughness, metallic and transmission; and the group's
    number at the pixel's centre, the number of the purest part, and 1 where all of the pixel is one group.

    After it the materials emit: no photograph can be taken any more.
    """
    scene = bpy.context.scene
    for thing in scene.objects:
        if thing.type == "LIGHT":
            thing.hide_render = True
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
    scene.cycles.max_bounces, scene.cycles.samples = 0, TRUTH_SAMPLES
    scene.camera = bpy.data.objects[camera]

    def picture(value: Callable[[str], tuple[float, float, float] | None]) -> Pixels:
        for name in groups:
            shows(bpy.data.materials[name], value(name))
        path = folder / "truth.tmp.exr"
        save = scene.render.image_settings
        save.file_format, save.color_depth, save.color_mode = "OPEN_EXR", "32", "RGB"
        scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        found = pixels_of(path).copy()
        path.unlink()
        return found

    def number(name: str) -> tuple[float, float, float]:
        index = groups[name]["index"] / len(groups)
        return (index, index * index, 1.0)

    write(folder / f"albedo{suffix}.exr", picture(lambda name: None))
    write(folder / f"roughness{suffix}.exr", picture(lambda name: (
        paints[name].roughness, paints[name].metallic, paints[name].transmission)))
    moments = picture(number).astype(np.float64)
    scene.cycles.samples, scene.cycles.filter_width = 1, 0.01
    middle = picture(number)[..., 0]
    scene.cycles.filter_width = 1.0
    spread = (moments[..., 1] - moments[..., 0] ** 2) * len(groups) ** 2
    pure = (spread < 1e-3) & (np.abs(moments[..., 2] - np.round(moments[..., 2])) < 1e-3)
    centre = np.round(middle * len(groups))
    mean = moments[..., 0] * len(groups)
    pure &= np.abs(mean - centre) < 1e-2
    write(folder / f"group{suffix}.exr", np.dstack([centre, mean, pure]).astype(np.float32))


def camera(name: str, eye: tuple[float, float, float], target: tuple[float, float, float], lens: float) -> None:
    """A camera that stands upright."""
    data = bpy.data.cameras.new(name)
    data.lens, data.clip_start = lens, 0.02
    thing = bpy.data.objects.new(name, data)
    thing.location = eye
    thing.rotation_euler = (Vector(target) - Vector(eye)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(thing)


def light(name: str, kind: str, energy: float, where: tuple[float, float, float],
          target: tuple[float, float, float], colour: tuple[float, float, float], spread: float = 60.0) -> None:
    """A sun, or a point or a spot without a size, which is all that glTF knows."""
    data = bpy.data.lights.new(name, kind)
    data.energy, data.color = energy, colour
    if kind == "SUN":
        data.angle = 0.0
    else:
        data.shadow_soft_size = 0.0
    if kind == "SPOT":
        data.spot_size = math.radians(spread)
    thing = bpy.data.objects.new(name, data)
    thing.location = where
    thing.rotation_euler = (Vector(target) - Vector(where)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(thing)


def window_portal(low: tuple[float, float, float], high: tuple[float, float, float], inward: float) -> None:
    """A portal over a window in a wall of constant x: Cycles then samples the sky through it. It changes only
    the noise, and no file holds it.
    """
    data = bpy.data.lights.new("portal", "AREA")
    data.shape, data.size, data.size_y = "RECTANGLE", high[2] - low[2], high[1] - low[1]
    data.cycles.is_portal = True
    thing = bpy.data.objects.new("portal", data)
    thing.location = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
    thing.rotation_euler = (0.0, math.radians(-90.0 if inward > 0 else 90.0), 0.0)
    bpy.context.scene.collection.objects.link(thing)
