# SPDX-License-Identifier: GPL-3.0-or-later
"""A scripted session in Blender, from an empty file to a composite, and the pictures of the tutorial.

    UNRENDER_WHEEL=FILE.whl python blender/tests/session.py docs/images/from-blender.jpg

makes docs/tutorials/from-blender.md's picture: photograph, check, Cycles with the applied materials,
composite; and beside it from-blender-panel.svg, the panel after each step, and from-blender-growing.jpg, the
re-rendering during the recovery and at its end. It prints the contents of the panel.
"""

import importlib
import os
import pathlib
import sys
import tempfile

import conftest  # An empty profile; it comes before bpy.

import bpy  # isort: skip
import build
import drawn
import numpy as np
import studio


def install():
    """The extension, built and installed."""
    archive = build.build([conftest.wheel()], pathlib.Path(conftest.PROFILE.name) / "zip")
    bpy.ops.extensions.package_install_files(filepath=str(archive), repo="user_default", enable_on_install=True)


def photograph(folder):
    """The scene, grey, without a camera; its photograph; points and their places in it."""
    scene = studio.build()
    studio.colour()
    studio.render(scene, folder / "photo.exr", 64)
    studio.bleach()
    pairs = [(point, studio.project(scene, point)) for point in studio.corners(scene)]
    bpy.data.objects.remove(scene.camera)
    scene.unrender.folder = str(folder / "work")
    return scene, pairs


def panel(step):
    """The present contents of the panel of a step."""
    return drawn.captured(getattr(bpy.types, f"UNRENDER_PT_{step}"))


def recovered(settings, looks):
    """Step 3; returns the contents of its panel halfway. Pictures of the re-rendering on the way are added
    to ``looks``."""
    import unrender

    job, pictures = (importlib.import_module(f"bl_ext.user_default.unrender.{name}") for name in ("job", "pictures"))
    halfway, redraw, load = [], job.redraw, pictures.load

    def loaded(path, name):
        looks.append(unrender.read_picture(path))
        return load(path, name)

    def watched():
        redraw()
        if settings.running and settings.progress > 0.4 and not halfway:
            halfway.append(panel("recover"))

    job.redraw, pictures.load = watched, loaded
    bpy.ops.unrender.recover(wait=True)
    job.redraw, pictures.load = redraw, load
    return (halfway or [panel("recover")])[0]


def work(folder, looks):
    """The five steps; the panel after each. See :func:`recovered`."""
    scene, pairs = photograph(folder)
    settings = scene.unrender
    bpy.ops.unrender.load_photo(filepath=str(folder / "photo.exr"))
    for number, (point, pixel) in enumerate(pairs):
        # One of them is wrong.
        bpy.ops.unrender.add_pair(point=point, pixel=(pixel[0], pixel[1] - (25.0 if number == 3 else 0.0)))
    bpy.ops.unrender.match_camera()
    print(settings.calibration)
    match = panel("match")
    bpy.ops.unrender.check(wait=True)
    print(settings.message, settings.messages, sep="\n")
    settings.max_rung, settings.spp = "isotropic", 16
    prepare = panel("prepare")
    recover = recovered(settings, looks)
    settings.result = settings.results.find("ball")
    for item in settings.results:
        print(f"{item.name}: {item.hypothesis}, {item.status}", item.numbers, item.note, sep="\n    ")
    bpy.ops.unrender.apply()
    applied = panel("apply")
    studio.render(scene, folder / "applied.exr", 64)
    bpy.ops.object.select_all(action="DESELECT")
    stuff = studio.material("new")
    stuff.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.6, 0.3, 0.02, 1.0)
    studio.add("new", stuff, bpy.ops.mesh.primitive_cube_add, size=0.22, location=(-0.15, -0.35, 0.11))
    bpy.ops.unrender.mark_inserted()
    bpy.ops.unrender.composite(wait=True)
    print(settings.message)
    return drawn.svg([[match], [prepare], [recover, applied], [panel("composite")]])


def sheet(folder, out):
    """The four pictures in a row."""
    import unrender

    files = ["photo.exr", "work/check.png", "applied.exr", "work/composite/composite.exr"]
    pictures = [np.asarray(unrender.read_picture(folder / file)) for file in files]
    # The check enlarges small photographs.
    pictures = [p[:: p.shape[0] // pictures[0].shape[0], :: p.shape[0] // pictures[0].shape[0]] for p in pictures]
    write(folder, pictures, out)


def write(folder, pictures, out):
    """Pictures of one size in a row, as JPEG."""
    import unrender

    gap = np.ones((pictures[0].shape[0], 4, 3), dtype=np.float32)
    row = np.concatenate([p for picture in pictures for p in (picture, gap)][:-1], axis=1)
    unrender.Picture(np.ascontiguousarray(row)).save(folder / "sheet.png")
    image = bpy.data.images.load(str(folder / "sheet.png"), check_existing=False)
    # Image.save keeps the format of the file that was loaded, whatever the name says.
    scene = bpy.context.scene
    scene.view_settings.view_transform = "Standard"
    scene.render.image_settings.file_format, scene.render.image_settings.quality = "JPEG", 88
    image.save_render(str(out), scene=scene)


def main():
    out = pathlib.Path(sys.argv[1]).absolute()
    studio.SIZE = (200, 150)
    install()
    with tempfile.TemporaryDirectory(prefix="unrender-session-") as name:
        looks = []
        panels = work(pathlib.Path(name), looks)
        out.with_name(out.stem + "-panel.svg").write_text(panels, encoding="utf-8")
        sheet(pathlib.Path(name), out)
        first = looks[: 1 if len(looks) < 4 else 3]
        write(pathlib.Path(name), [*first, looks[-1]], out.with_name(out.stem + "-growing.jpg"))
    sys.stdout.flush()
    # Blender as a module may hang when it is unloaded.
    os._exit(0)


main()
