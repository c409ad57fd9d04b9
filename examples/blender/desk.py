"""A desk in Blender: its model for unrender, a photograph of it by Cycles, and the truth.

python3 desk.py FOLDER, with `pip install "bpy==4.5.*"` (Python 3.11), or
blender --background --python desk.py -- FOLDER
"""

import json
import math
import pathlib
import sys

import bpy

# What the photograph shows and the model does not know: rho_d, rho_s, alpha of every group.
TRUTH = {
    "wall": ([0.62, 0.58, 0.50], None, 0.0),
    "desk": ([0.36, 0.22, 0.12], None, 0.0),
    "box": ([0.10, 0.32, 0.16], None, 0.0),
    "ball": ([0.05, 0.10, 0.40], [0.30, 0.30, 0.30], 0.12),
}
LAMP_RADIANCE = 12.0
POINT_WATTS = 20.0


def principled(name):
    """A material as a modeller leaves it: grey, without a shine."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.5, 0.5, 0.5, 1.0)
    shader.inputs["Specular IOR Level"].default_value = 0.0
    return material


def lamp_material():
    material = bpy.data.materials.new("lamp")
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    shader.inputs["Specular IOR Level"].default_value = 0.0
    shader.inputs["Emission Color"].default_value = (1.0, 0.9, 0.75, 1.0)
    shader.inputs["Emission Strength"].default_value = LAMP_RADIANCE
    return material


def add(name, material, make, **where):
    make(**where)
    thing = bpy.context.object
    thing.name = name
    thing.data.materials.append(material)
    return thing


def build():
    """The scene: metres, z up, as Blender has it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    plane, cube = bpy.ops.mesh.primitive_plane_add, bpy.ops.mesh.primitive_cube_add
    materials = {name: principled(name) for name in TRUTH}
    add("desk", materials["desk"], plane, size=2.4, location=(0, 0, 0))
    upright = (math.radians(90), 0, 0)
    add("wall", materials["wall"], plane, size=2.4, location=(0, 0.6, 0.8), rotation=upright)
    turned = (0, 0, math.radians(25))
    add("box", materials["box"], cube, size=0.3, location=(-0.3, 0.15, 0.15), rotation=turned)
    ball = bpy.ops.mesh.primitive_uv_sphere_add
    add("ball", materials["ball"], ball, segments=64, ring_count=32, radius=0.17,
        location=(0.22, -0.05, 0.17))
    bpy.ops.object.shade_smooth()
    down = (math.radians(180), 0, 0)
    add("lamp", lamp_material(), plane, size=0.4, location=(-0.4, -0.4, 1.3), rotation=down)
    bpy.ops.object.light_add(type="POINT", location=(0.7, -0.6, 0.9))
    bpy.context.object.name = "bulb"
    bpy.context.object.data.energy = POINT_WATTS
    bpy.context.object.data.shadow_soft_size = 0.0
    bpy.ops.object.camera_add(location=(0.0, -1.5, 0.75), rotation=(math.radians(70), 0, 0))
    bpy.context.object.data.angle = math.radians(45)
    scene = bpy.context.scene
    scene.camera = bpy.context.object
    # The exporter takes the camera's vertical angle from it: set it before.
    scene.render.resolution_x, scene.render.resolution_y = 320, 240


def colour(name):
    """Gives a material its true reflectance: a diffuse shader, and a glossy one added to it."""
    rho_d, rho_s, alpha = TRUTH[name]
    tree = bpy.data.materials[name].node_tree
    output = tree.nodes["Material Output"].inputs["Surface"]
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (*rho_d, 1.0)
    if rho_s is None:
        tree.links.new(diffuse.outputs[0], output)
        return
    glossy, both = tree.nodes.new("ShaderNodeBsdfGlossy"), tree.nodes.new("ShaderNodeAddShader")
    glossy.distribution = "GGX"
    glossy.inputs["Color"].default_value = (*rho_s, 1.0)
    glossy.inputs["Roughness"].default_value = math.sqrt(alpha)
    tree.links.new(diffuse.outputs[0], both.inputs[0])
    tree.links.new(glossy.outputs[0], both.inputs[1])
    tree.links.new(both.outputs[0], output)


def photograph(file):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 256
    scene.cycles.use_denoising = False
    # AgX and Filmic are tone curves; "Standard" is the sRGB curve that unrender inverts.
    scene.view_settings.view_transform = "Standard"
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_depth = "16"
    scene.render.filepath = str(file)
    bpy.ops.render.render(write_still=True)


def main():
    folder = pathlib.Path(sys.argv[-1]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    build()
    bpy.ops.export_scene.gltf(filepath=str(folder / "desk.glb"), export_cameras=True,
                              export_lights=True)
    for name in TRUTH:
        colour(name)
    photograph(folder / "desk.png")
    groups = {}
    for name, (rho_d, rho_s, alpha) in TRUTH.items():
        kind = "isotropic" if rho_s else "diffuse"
        groups[name] = {"hypothesis": kind, "rho_d": rho_d, "rho_s": rho_s or [0.0, 0.0, 0.0],
                        "alpha_x": alpha, "alpha_y": alpha}
    truth = {"version": 1, "brdf": "ggx", "groups": groups}
    (folder / "truth.json").write_text(json.dumps(truth, indent=2) + "\n")


main()
