"""Photographs the room of examples/blender/room.py after its import back into Blender.

python3 blender_again.py ROOM.PY SOURCE OUT SPP WIDTH; SOURCE is scene.py of an export, or a glTF file.
"""

import pathlib
import runpy
import sys

import bpy

room, source, out, spp, width = sys.argv[1:]
made = runpy.run_path(room)
bpy.ops.wm.read_factory_settings(use_empty=True)
if source.endswith(".py"):
    before = bpy.context.scene
    sys.argv = [source]
    runpy.run_path(source, run_name="__main__")
    bpy.data.scenes.remove(before)
else:
    bpy.ops.import_scene.gltf(filepath=source)
    scene = bpy.context.scene
    scene.camera = next(thing for thing in scene.objects if thing.type == "CAMERA")
render = bpy.context.scene.render
render.resolution_x, render.resolution_y = int(width), int(width) * 3 // 4
folder = pathlib.Path(out)
folder.mkdir(parents=True, exist_ok=True)
made["photographs"](folder, int(spp))
