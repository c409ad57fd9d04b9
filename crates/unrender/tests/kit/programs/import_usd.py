"""Renders a USD stage by Cycles, after Blender's own import of it.

python3 import_usd.py STAGE WIDTH HEIGHT SPP PICTURE.exr
"""

import sys

import bpy

stage, width, height, spp, picture = sys.argv[1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
# The import fills the scene's world, and makes none.
scene.world = bpy.data.worlds.new("world")
scene.world.use_nodes = True
scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
bpy.ops.wm.usd_import(filepath=stage)
for light in bpy.data.lights:
    if light.type == "SUN":
        # The import takes a distant light for four times as bright as UsdLux does.
        light.energy /= 4
for image in bpy.data.images:
    # Pictures hold linear numbers: nothing may be made of them on the way.
    assert image.colorspace_settings.name in ("Non-Color", "Linear Rec.709"), image.name
scene.camera = next(thing for thing in scene.objects if thing.name.startswith("c_"))
render, cycles = scene.render, scene.cycles
render.engine = "CYCLES"
render.resolution_x, render.resolution_y = int(width), int(height)
render.resolution_percentage = 100
scene.view_settings.view_transform = "Standard"
cycles.samples = int(spp)
cycles.pixel_filter_type = "BOX"
cycles.use_denoising = cycles.use_adaptive_sampling = False
cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
cycles.blur_glossy = 0
cycles.caustics_reflective = cycles.caustics_refractive = True
cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = 64
cycles.transmission_bounces = cycles.transparent_max_bounces = 64
render.image_settings.file_format = "OPEN_EXR"
render.image_settings.color_depth = "32"
render.filepath = picture
bpy.ops.render.render(write_still=True)
