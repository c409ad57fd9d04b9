"""Three rooms made in Blender as artists make them: scene, photographs by Cycles, and the truth.

python3 room.py OUT [--room NAME] [--size 384x288] [--samples N], with `pip install "bpy==4.5.*"` (Python 3.11),
or blender --background --python room.py -- OUT

README.md says what OUT/NAME holds.
"""

import argparse
import importlib
import math
import os
import pathlib
import sys
import time
import types
from typing import Any

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import bpy
import numpy as np

import materials
import photograph

ROOMS = ("living", "kitchen", "bedroom")
LEFT_OUT = ("glass", "maps", "cutouts")
SKY_TURN = -90.0
"""A panorama's centre is +x in Blender and -z in unrender: degrees about the upright axis."""


def wanted() -> argparse.Namespace:
    """The command line; Blender's own words come before ``--``."""
    own = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    parser = argparse.ArgumentParser(prog="room.py", description="Makes rooms with Blender and Cycles.")
    parser.add_argument("out", type=pathlib.Path, help="the folder of the rooms; each gets one in it")
    parser.add_argument("--room", choices=ROOMS, action="append", help="only this room; may be repeated")
    parser.add_argument("--size", default="384x288", help="of the photographs, pixels [default: 384x288]")
    parser.add_argument("--samples", type=int, default=1024, help="of a photograph, per pixel [default: 1024]")
    parser.add_argument("--threads", type=int, default=2, help="of Cycles [default: 2]")
    parser.add_argument("--without", default="", help="leaves out, separated by commas: glass, maps, cutouts")
    parser.add_argument("--all-diffuse", action="store_true",
                        help="every material is its base colour alone; implies --without glass,maps,cutouts")
    parser.add_argument("--only", default="", help="photographs, separated by commas: photo, lamp_off, second "
                        "[default: all]")
    parser.add_argument("--brdf", default="principled", help="of the project files [default: principled]")
    asked = parser.parse_args(own)
    asked.without = frozenset(word for word in asked.without.split(",") if word)
    if unknown := asked.without - set(LEFT_OUT):
        parser.error(f"--without: {', '.join(sorted(unknown))}: expected {', '.join(LEFT_OUT)}")
    asked.only = frozenset(asked.only.split(",")) if asked.only else frozenset(("photo", "lamp_off", "second"))
    asked.size = tuple(int(side) for side in asked.size.split("x"))
    return asked


def world(folder: pathlib.Path, picture: Any) -> None:
    """Writes the sky as sky.exr and lights the scene with it."""
    photograph.write(folder / "sky.exr", picture.astype(np.float32))
    made = bpy.data.worlds.new("sky")
    made.use_nodes = True
    bpy.context.scene.world = made
    node = made.node_tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = bpy.data.images.load(str(folder / "sky.exr"))
    node.image.colorspace_settings.name = "Linear Rec.709"
    made.node_tree.links.new(node.outputs["Color"], made.node_tree.nodes["Background"].inputs["Color"])


PROJECT = """\
# {title}: made by examples/artist/room.py.
scene = "scene.glb"
photo = "{photo}"
camera = "camera"
response = "{response}"
exposure = 1.0                 # Cycles writes radiance

[environment]
panorama = "sky.exr"
rotation_deg = {turn}

[recover]
brdf = "{brdf}"
"""

RESTAGED = """\
# {title}: beside {file}.exr. `unrender restage {file}.toml --out again.exr` after
# `unrender recover project.toml --out result`.
recovered = "result"
project = "project.toml"

{change}
"""


def projects(folder: pathlib.Path, name: str, room: types.ModuleType, brdf: str) -> None:
    """The project files, and edits that make the other two photographs again."""
    title = f"The {name}"
    for file, photo, response in [("project", "photo.exr", "linear"), ("project_png", "photo.png", "srgb")]:
        text = PROJECT.format(title=title, photo=photo, response=response, turn=SKY_TURN, brdf=brdf)
        (folder / f"{file}.toml").write_text(text)
    off = f'[[lights]]\nname = "{room.OFF}"\non = false'
    (folder / "lamp_off.toml").write_text(
        RESTAGED.format(title=f"{title} without its {room.OFF}", file="lamp_off", change=off))
    (folder / "second.toml").write_text(
        RESTAGED.format(title=f"{title} from another place", file="second", change=viewpoint("second view")))


def viewpoint(camera: str) -> str:
    """A camera as unrender's table, y up."""
    thing = bpy.data.objects[camera]
    eye = thing.matrix_world.translation
    target = eye + thing.matrix_world.to_quaternion() @ photograph.FORWARD
    render = bpy.context.scene.render
    width, height = render.resolution_x, render.resolution_y
    data = thing.data
    fov = 2 * math.atan(0.5 * data.sensor_width / data.lens * height / max(width, height))

    def y_up(p: Any) -> str:
        return f"[{p.x:.7g}, {p.z:.7g}, {-p.y:.7g}]"

    return (f"[camera]\neye = {y_up(eye)}\ntarget = {y_up(target)}\n"
            f"fov_y_deg = {math.degrees(fov):.7g}")


def make(name: str, asked: argparse.Namespace) -> None:
    """One room, with all of its files."""
    room = importlib.import_module(name)
    folder = (asked.out / name).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    palette = materials.Palette(folder, asked.without, asked.all_diffuse)
    room.materials(palette)
    room.build(palette)
    room.lights()
    photograph.settings(asked.size, asked.samples, asked.threads)
    world(folder, room.sky())
    bpy.context.scene.camera = bpy.data.objects["camera"]
    bpy.context.view_layer.update()
    bpy.ops.export_scene.gltf(filepath=str(folder / "scene.glb"), export_apply=True, export_cameras=True,
                              export_lights=True)
    groups = palette.truth()
    projects(folder, name, room, asked.brdf)
    materials.write_truth(folder / "truth.json", name, groups, {
        "lamp_off": room.OFF,
        "left_out": sorted(asked.without) if not asked.all_diffuse else ["everything but the base"],
        "size": list(asked.size),
    })
    room.portal()
    if "photo" in asked.only:
        photograph.take(folder / "photo.exr", "camera", 0)
    if "second" in asked.only:
        photograph.take(folder / "second.exr", "second view", 1)
    if "lamp_off" in asked.only:
        photograph.switch(room.OFF, False)
        photograph.take(folder / "lamp_off.exr", "camera", 2)
    photograph.truths(folder, "", "camera", groups, palette.paints)
    if "second" in asked.only:
        photograph.truths(folder, "_second", "second view", groups, palette.paints)


def main() -> None:
    """Makes the rooms that are asked for, and says how long each took."""
    asked = wanted()
    # Blender prints lines for each sample on standard output.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    for name in asked.room or ROOMS:
        started = time.monotonic()
        make(name, asked)
        print(f"{name}: {asked.out / name}, {time.monotonic() - started:.0f} s", file=answers, flush=True)


if __name__ == "__main__":
    main()
