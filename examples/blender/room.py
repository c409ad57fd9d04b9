"""A furnished room in Blender: its model for unrender, and photographs of it by Cycles.

python3 room.py FOLDER [--size WIDTH] [--spp N] [--other], with `pip install "bpy==4.5.*"` (Python 3.11), or
blender --background --python room.py -- FOLDER

Writes room.glb by Blender's exporter with its defaults (and cameras and lights, which it leaves out else),
room.exr, and light_NAME.exr, which has that light alone; with --other also other.exr, from the place of
room_other.toml.
"""

import argparse
import math
import pathlib
import sys

import bpy

# Matte surfaces, as most of a room is: roughness 1, no specular. (Principled's own 0.5 dims what lies under
# it the more the flatter one looks at it, which no number in a glTF file says.)
MATTE = {
    "floor": (0.40, 0.27, 0.16),
    "ceiling": (0.80, 0.80, 0.78),
    "wall back": (0.62, 0.60, 0.55),
    "wall left": (0.60, 0.42, 0.32),
    "wall right": (0.45, 0.55, 0.50),
    "rug": (0.36, 0.09, 0.09),
    "table legs": (0.12, 0.10, 0.09),
    "chair": (0.20, 0.30, 0.14),
    "cabinet": (0.55, 0.45, 0.30),
    "cabinet door": (0.66, 0.62, 0.52),
    "shelf": (0.30, 0.20, 0.12),
    "books red": (0.45, 0.07, 0.05),
    "books blue": (0.06, 0.12, 0.40),
    "books green": (0.08, 0.30, 0.12),
    "sofa": (0.16, 0.22, 0.34),
    "cushion": (0.70, 0.55, 0.12),
    "curtain": (0.52, 0.48, 0.58),
    "pot": (0.50, 0.22, 0.12),
    "picture": (0.30, 0.40, 0.50),
    "table top": (0.50, 0.32, 0.20),
    "vase": (0.65, 0.62, 0.58),
}
# Metallic 1, roughness 0.5.
METAL = {"frame": (0.80, 0.64, 0.35)}

PANEL_RADIANCE = 6.0
BULB_WATTS, SPOT_WATTS, SUN = 35.0, 60.0, 4.0
LAMPS = ("panel", "bulb", "spot", "sun")

# Another place of the camera, metres, and its turns, radians.
OTHER = ((1.0, 0.3, 1.5), (math.radians(80), 0, math.radians(-25)))


def material(name, color, **inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*color, 1.0)
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value


def materials():
    for name, color in MATTE.items():
        material(name, color, Roughness=1.0, Specular_IOR_Level=0.0)
    for name, color in METAL.items():
        material(name, color, Metallic=1.0, Roughness=0.5)
    material("panel", (0.0, 0.0, 0.0), Specular_IOR_Level=0.0,
             Emission_Color=(1.0, 0.92, 0.8, 1.0), Emission_Strength=PANEL_RADIANCE)


def dressed(name, made_of):
    thing = bpy.context.object
    thing.name = name
    thing.data.materials.append(bpy.data.materials[made_of])
    return thing


def box(name, low, high, made_of=None, turn=0.0):
    """A box between two corners, turned about its upright axis; its scale is not applied, as a modeller
    leaves it."""
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=middle, rotation=(0, 0, math.radians(turn)))
    bpy.context.object.scale = [b - a for a, b in zip(low, high)]
    return dressed(name, made_of or name)


def wall(name, corners, made_of=None):
    """Quadrilaterals, four corners each."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], [range(i, i + 4) for i in range(0, len(corners), 4)])
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(thing)
    mesh.materials.append(bpy.data.materials[made_of or name])


def shell():
    """4 m wide, 5 m deep and 2.6 m high, with a window in the right wall."""
    wall("floor", [(0, 0, 0), (4, 0, 0), (4, 5, 0), (0, 5, 0)])
    wall("ceiling", [(0, 0, 2.6), (0, 5, 2.6), (4, 5, 2.6), (4, 0, 2.6)])
    wall("wall back", [(0, 5, 0), (4, 5, 0), (4, 5, 2.6), (0, 5, 2.6)])
    wall("wall front", [(0, 0, 0), (0, 0, 2.6), (4, 0, 2.6), (4, 0, 0)], "wall back")
    wall("wall left", [(0, 0, 0), (0, 5, 0), (0, 5, 2.6), (0, 0, 2.6)])
    around = [((0, 0), (5, 0.9)), ((0, 2.2), (5, 2.6)), ((0, 0.9), (2.2, 2.2)), ((3.6, 0.9), (5, 2.2))]
    corners = [(4, y, z) for (y0, z0), (y1, z1) in around
               for y, z in ((y0, z0), (y0, z1), (y1, z1), (y1, z0))]
    wall("wall right", corners)
    box("curtain", (3.88, 3.6, 0.4), (3.96, 4.3, 2.35))


def furniture():
    box("rug", (0.9, 1.6, 0.0), (3.0, 3.6, 0.015))
    box("table top", (1.3, 2.2, 0.70), (2.5, 3.0, 0.74))
    for i, (x, y) in enumerate([(1.35, 2.25), (2.39, 2.25), (1.35, 2.89), (2.39, 2.89)]):
        box(f"leg {i}", (x, y, 0.015), (x + 0.06, y + 0.06, 0.70), "table legs")
    box("seat", (2.65, 1.9, 0.42), (3.1, 2.35, 0.47), "chair", 20)
    box("chair back", (2.65, 2.35, 0.47), (3.1, 2.39, 0.95), "chair", 20)
    for i, (x, y) in enumerate([(2.68, 1.95), (3.03, 1.95), (2.68, 2.3), (3.03, 2.3)]):
        box(f"chair leg {i}", (x, y, 0.0), (x + 0.04, y + 0.04, 0.42), "chair")
    box("cabinet", (0.02, 3.7, 0.0), (0.5, 4.9, 1.1))
    box("cabinet door", (0.5, 3.75, 0.05), (0.52, 4.85, 1.05))
    box("shelf", (1.2, 4.7, 1.5), (2.8, 4.98, 1.54))
    for i, (name, x) in enumerate([("books red", 1.3), ("books blue", 1.75), ("books green", 2.25)]):
        box(name, (x, 4.72, 1.54), (x + 0.36, 4.94, 1.78 + 0.05 * i))
    box("sofa seat", (1.2, 4.0, 0.0), (3.0, 4.6, 0.42), "sofa")
    box("sofa back", (1.2, 4.6, 0.0), (3.0, 4.85, 0.85), "sofa")
    box("cushion", (1.35, 4.3, 0.42), (1.8, 4.55, 0.8), turn=10)
    box("picture", (0.01, 2.0, 1.3), (0.02, 2.9, 1.9))
    for i, (low, high) in enumerate([((0.0, 1.93, 1.23), (0.04, 2.97, 1.3)),
                                     ((0.0, 1.93, 1.9), (0.04, 2.97, 1.97))]):
        box(f"frame {i}", low, high, "frame")
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, radius=0.14,
                                         location=(1.75, 2.6, 0.88))
    dressed("vase", "vase")
    bpy.ops.object.shade_smooth()
    bpy.ops.mesh.primitive_cylinder_add(vertices=48, radius=0.22, depth=0.45, location=(3.4, 4.5, 0.225))
    dressed("pot", "pot")


def lamps():
    """A ceiling panel of a material that emits, and three lights as new ones are but for their power."""
    wall("panel", [(1.5, 1.2, 2.59), (1.5, 1.8, 2.59), (2.5, 1.8, 2.59), (2.5, 1.2, 2.59)])
    for name, kind, energy, where, turn in [
        ("bulb", "POINT", BULB_WATTS, (0.5, 0.6, 1.9), (0, 0, 0)),
        ("spot", "SPOT", SPOT_WATTS, (3.4, 1.0, 2.3), (35, 0, 35)),
        ("sun", "SUN", SUN, (8, 2, 6), (0, 55, -10)),
    ]:
        bpy.ops.object.light_add(type=kind, location=where, rotation=[math.radians(t) for t in turn])
        bpy.context.object.name = name
        bpy.context.object.data.energy = energy
    bpy.data.lights[bpy.data.objects["bulb"].data.name].color = (1.0, 0.85, 0.65)


def camera(width):
    bpy.ops.object.camera_add(location=(2.1, 0.15, 1.55), rotation=(math.radians(82), 0, math.radians(2)))
    bpy.context.object.data.lens = 22.0
    scene = bpy.context.scene
    scene.camera = bpy.context.object
    scene.render.resolution_x, scene.render.resolution_y = width, width * 3 // 4


def photograph(file, spp):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = spp
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    # Cycles' defaults bias pictures: it clamps bright indirect light and ends paths early.
    scene.cycles.sample_clamp_indirect = 0.0
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = 32
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(file)
    bpy.ops.render.render(write_still=True)


def alone(kept):
    """Switches all lamps off but one, "panel" for what materials emit; all on for None."""
    for thing in bpy.context.scene.objects:
        if thing.type == "LIGHT":
            name = thing.get("unrender_name", thing.name)
            thing.hide_render = kept is not None and name != kept
    for material in bpy.data.materials:
        for node in material.node_tree.nodes if material.use_nodes else []:
            key = {"BSDF_PRINCIPLED": "Emission Color", "EMISSION": "Color"}.get(node.type)
            if key:
                color = node.inputs[key]
                if "whole" not in node:
                    node["whole"] = list(color.default_value)
                shown = kept in (None, "panel")
                color.default_value = list(node["whole"]) if shown else (0.0, 0.0, 0.0, 1.0)


def photographs(folder, spp):
    for name in LAMPS:
        alone(name)
        photograph(folder / f"light_{name}.exr", spp)
    alone(None)
    photograph(folder / "room.exr", spp)


def main():
    own = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    parser = argparse.ArgumentParser(prog="room.py")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--size", type=int, default=320)
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--other", action="store_true")
    wanted = parser.parse_args(own)
    folder = wanted.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    materials()
    shell()
    furniture()
    lamps()
    camera(wanted.size)
    bpy.ops.export_scene.gltf(filepath=str(folder / "room.glb"), export_cameras=True,
                              export_lights=True)
    photographs(folder, wanted.spp)
    if wanted.other:
        eye = bpy.context.scene.camera
        eye.location, eye.rotation_euler = OTHER
        photograph(folder / "other.exr", wanted.spp)


if __name__ == "__main__":
    main()
