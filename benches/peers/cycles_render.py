"""Renders an export for Blender by Cycles as often as requested: FOLDER of scene.py.

Prints a line of JSON when the scene is built, then one for each line of JSON that it reads,
{"spp", "seed", "picture"}: {"seconds"}. Groups in FOLDER/foreign.json get a Principled BSDF:
{NAME: {"base_color", "metallic", "roughness", "anisotropic"}}; a texture of the export stays.
"""

import json
import os
import sys
import time

# Blender prints lines for each sample on standard output, which nobody needs.
answers = os.fdopen(os.dup(1), "w")
os.dup2(os.open(os.devnull, os.O_WRONLY), 1)

import bpy

folder = sys.argv[1]
path = os.path.join(folder, "scene.py")
with open(path, encoding="utf-8") as file:
    source = file.read()
assert source.rstrip().endswith("\nmain()"), "scene.py ends with the call of its main"
space = {"__name__": "scene", "__file__": path}
exec(compile(source.rstrip()[:-len("main()")], path, "exec"), space)
scene = space["build"]()


def principled(name, asked):
    material = bpy.data.materials[name]
    nodes, links = material.node_tree.nodes, material.node_tree.links
    picture = next((node for node in nodes if node.type == "TEX_IMAGE"), None)
    output = next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
    node = nodes.new("ShaderNodeBsdfPrincipled")
    node.inputs["Base Color"].default_value = (*asked["base_color"], 1)
    for key, socket in [("metallic", "Metallic"), ("roughness", "Roughness"),
                        ("anisotropic", "Anisotropic")]:
        node.inputs[socket].default_value = asked[key]
    if picture is not None:
        links.new(picture.outputs["Color"], node.inputs["Base Color"])
    links.new(node.outputs[0], output.inputs["Surface"])


foreign = os.path.join(folder, "foreign.json")
if os.path.exists(foreign):
    with open(foreign, encoding="utf-8") as file:
        for name, asked in json.load(file).items():
            principled(name, asked)
image = scene.render.image_settings
image.file_format, image.color_depth = "OPEN_EXR", "32"


def say(what):
    print(json.dumps(what), file=answers, flush=True)


say({"version": bpy.app.version_string})
for line in sys.stdin:
    asked = json.loads(line)
    scene.cycles.samples, scene.cycles.seed = asked["spp"], asked["seed"]
    scene.render.filepath = asked["picture"]
    started = time.perf_counter()
    bpy.ops.render.render(write_still=True, scene=scene.name)
    say({"seconds": time.perf_counter() - started})
