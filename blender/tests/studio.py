# SPDX-License-Identifier: GPL-3.0-or-later
"""A small scene in Blender, its true materials, its photograph by Cycles, and comparisons of
pictures."""

import math

import bpy
import numpy as np
from mathutils import Vector

SIZE = (96, 72)
# rho_d, rho_s, alpha.
TRUTH = {
    "floor": ((0.36, 0.22, 0.12), None, 0.0),
    "wall": ((0.62, 0.58, 0.50), None, 0.0),
    "box": ((0.10, 0.32, 0.16), None, 0.0),
    "ball": ((0.05, 0.10, 0.40), (0.30, 0.30, 0.30), 0.15),
}


def material(name):
    """A grey material, the default of a modeller."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.5, 0.5, 0.5, 1.0)
    return made


def add(name, stuff, make, **where):
    make(**where)
    thing = bpy.context.object
    thing.name = name
    if stuff is not None:
        thing.data.materials.append(stuff)
    return thing


def build():
    """The scene, entirely grey: a modifier, an instanced collection, an area light and a bulb."""
    # Extensions stay enabled, unlike with read_factory_settings.
    bpy.ops.wm.read_homefile(use_empty=True)
    plane, cube = bpy.ops.mesh.primitive_plane_add, bpy.ops.mesh.primitive_cube_add
    stuff = {name: material(name) for name in TRUTH}
    add("floor", stuff["floor"], plane, size=2.4)
    add("wall", stuff["wall"], plane, size=2.4, location=(0, 0.6, 0.8), rotation=(math.radians(90), 0, 0))
    # A row of two boxes by a modifier, with a scaled object as parent.
    parent = bpy.data.objects.new("parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.scale = (0.5, 0.5, 0.5)
    box = add("box", stuff["box"], cube, size=0.4, location=(-1.1, 0.3, 0.2))
    box.parent = parent
    array = box.modifiers.new("row", "ARRAY")
    array.count, array.relative_offset_displace = 2, (0.0, 0.0, 1.0)
    # The ball is an instance of a collection that is not in the scene itself.
    ball = add("ball", stuff["ball"], bpy.ops.mesh.primitive_uv_sphere_add, segments=48, ring_count=24, radius=0.2)
    bpy.ops.object.shade_smooth()
    stock = bpy.data.collections.new("stock")
    stock.objects.link(ball)
    for collection in list(ball.users_collection):
        if collection != stock:
            collection.objects.unlink(ball)
    instance = bpy.data.objects.new("ball here", None)
    instance.instance_type, instance.instance_collection = "COLLECTION", stock
    instance.location = (0.25, -0.05, 0.2)
    bpy.context.scene.collection.objects.link(instance)
    lamps()
    scene = bpy.context.scene
    bpy.ops.object.camera_add(location=(0.0, -1.6, 0.8), rotation=(math.radians(70), 0, math.radians(2)))
    scene.camera = bpy.context.object
    scene.camera.name = "true camera"
    scene.camera.data.angle = math.radians(48)
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    settle(scene)
    return scene


def lamps():
    """An area light, a bulb and a faint world."""
    bpy.ops.object.light_add(type="AREA", location=(-0.5, -0.5, 1.5))
    lamp = bpy.context.object
    lamp.name, lamp.data.name = "area", "area"
    lamp.rotation_euler = (math.radians(20), math.radians(-15), 0.3)
    lamp.data.shape, lamp.data.size, lamp.data.size_y = "RECTANGLE", 0.5, 0.3
    lamp.data.energy, lamp.data.color = 12.0, (1.0, 0.9, 0.75)
    bpy.ops.object.light_add(type="POINT", location=(0.8, -0.7, 1.0))
    bulb = bpy.context.object
    bulb.name, bulb.data.energy, bulb.data.shadow_soft_size = "bulb", 10.0, 0.06
    world = bpy.data.worlds.new("world")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.05, 0.06, 0.08, 1.0)
    bpy.context.scene.world = world


def settle(scene):
    """Cycles with light transport only."""
    scene.render.engine = "CYCLES"
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    cycles = scene.cycles
    cycles.pixel_filter_type = "BOX"
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    cycles.caustics_reflective = True
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = 32


def colour():
    """Gives the materials their true reflectances."""
    for name, (rho_d, rho_s, alpha) in TRUTH.items():
        tree = bpy.data.materials[name].node_tree
        output = tree.nodes["Material Output"].inputs["Surface"]
        diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
        diffuse.inputs["Color"].default_value = (*rho_d, 1.0)
        made = [diffuse]
        total = diffuse.outputs[0]
        if rho_s is not None:
            glossy, both = tree.nodes.new("ShaderNodeBsdfAnisotropic"), tree.nodes.new("ShaderNodeAddShader")
            glossy.distribution = "GGX"
            glossy.inputs["Color"].default_value = (*rho_s, 1.0)
            glossy.inputs["Roughness"].default_value = math.sqrt(alpha)
            tree.links.new(diffuse.outputs[0], both.inputs[0])
            tree.links.new(glossy.outputs[0], both.inputs[1])
            total = both.outputs[0]
            made += [glossy, both]
        tree.links.new(total, output)


def bleach():
    """Makes all materials grey again."""
    for name in TRUTH:
        tree = bpy.data.materials[name].node_tree
        tree.links.new(tree.nodes["Principled BSDF"].outputs[0], tree.nodes["Material Output"].inputs["Surface"])


def render(scene, path, samples):
    """A picture by Cycles, radiance, as .exr."""
    scene.cycles.samples = samples
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    return path


def corners(scene):
    """Points of the scene that its camera shows, in world space: on floor, wall and boxes."""
    points = [
        (-0.6, 0.6, 0.0), (0.6, 0.6, 0.0), (-0.5, 0.0, 0.0), (0.5, 0.0, 0.0), (0.0, 0.6, 0.7), (0.55, 0.6, 0.5),
        (-0.65, 0.05, 0.2), (-0.45, 0.05, 0.4), (-0.45, 0.25, 0.4), (0.25, -0.05, 0.4), (0.0, 0.3, 0.0),
        (-0.6, 0.6, 0.6),
    ]
    inside = []
    for point in map(Vector, points):
        x, y = project(scene, point)
        if 0.0 <= x <= SIZE[0] and 0.0 <= y <= SIZE[1]:
            inside.append(point)
    return inside


def project(scene, point):
    """The place of a point in the scene's camera: pixels from the top left corner, by Blender
    itself."""
    from bpy_extras.object_utils import world_to_camera_view

    x, y, _ = world_to_camera_view(scene, scene.camera, point)
    return (x * scene.render.resolution_x, (1.0 - y) * scene.render.resolution_y)


def group_means(picture, groups, least=30):
    """The mean radiance of every group's inner pixels."""
    found = {}
    for number in np.unique(groups):
        inside = groups == number
        # Pixels at edges are mixed.
        for axis in (0, 1):
            for step in (1, -1):
                inside &= np.roll(groups, step, axis) == number
        if number >= 0 and inside.sum() >= least:
            found[int(number)] = picture[inside].mean(axis=0)
    return found
