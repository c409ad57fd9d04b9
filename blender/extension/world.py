# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: light from all around, as one radiance or as a panorama that Cycles renders from its
nodes."""

import math

import bpy

PANORAMA_HEIGHT = 512
"""Rows of the panorama: 0.35 degrees per row. With half of it the sun of a sky texture is too wide,
double takes four times as long and does not improve a recovery."""


def environment(world, path):
    """The world for a project: a radiance per channel, or the path of a panorama, or neither.

    Returns:
        ``{"color": ...}``, ``{"panorama": path}`` or None.
    """
    if world is None:
        return None
    if not world.use_nodes or world.node_tree is None:
        return color_of(world.color)
    output = world.node_tree.get_output_node("CYCLES")
    link = next(iter(output.inputs["Surface"].links), None) if output else None
    if link is None:
        return None
    node = link.from_node
    if node.type == "BACKGROUND" and not any(socket.is_linked for socket in node.inputs):
        strength = node.inputs["Strength"].default_value
        return color_of([strength * c for c in node.inputs["Color"].default_value[:3]])
    bake(world, path)
    return {"panorama": path}


def color_of(color):
    """A radiance from everywhere; None if it is black."""
    radiance = [max(0.0, float(c)) for c in color[:3]]
    return {"color": radiance} if max(radiance) > 0.0 else None


def bake(world, path):
    """Renders only the world, into the panorama ``path`` (.exr)."""
    scene = bpy.data.scenes.new("unrender, world")
    camera = bpy.data.cameras.new("unrender, world")
    thing = bpy.data.objects.new("unrender, world", camera)
    try:
        scene.collection.objects.link(thing)
        scene.camera, scene.world = thing, world
        # The panorama's centre is Blender's +y, the -z of glTF.
        thing.rotation_euler = (math.radians(90.0), 0.0, 0.0)
        scene.render.engine = "CYCLES"
        camera.type = "PANO"
        set_panorama(camera)
        scene.cycles.samples = 16
        scene.cycles.use_denoising = False
        scene.render.resolution_x, scene.render.resolution_y = 2 * PANORAMA_HEIGHT, PANORAMA_HEIGHT
        scene.render.resolution_percentage = 100
        scene.render.film_transparent = False
        scene.render.image_settings.file_format = "OPEN_EXR"
        scene.render.image_settings.color_depth = "32"
        scene.render.filepath = path
        bpy.ops.render.render(write_still=True, scene=scene.name)
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.objects.remove(thing)
        bpy.data.cameras.remove(camera)


def set_panorama(camera):
    """Equirectangular; the setting has moved from Cycles to the camera in Blender 5."""
    owner = camera if hasattr(camera, "panorama_type") else camera.cycles
    owner.panorama_type = "EQUIRECTANGULAR"
