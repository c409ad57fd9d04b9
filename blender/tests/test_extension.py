# SPDX-License-Identifier: GPL-3.0-or-later
"""From an empty file to applied materials and a composite, by the operators of the installed extension."""

import importlib
import pathlib

import bpy
import numpy as np
import pytest
import studio
from mathutils import Vector

MODULE = "bl_ext.user_default.unrender"
SAMPLES = 48
"""Samples of the photograph: with these, group means are within half a percent."""


def module(name):
    """A module of the installed extension."""
    return importlib.import_module(f"{MODULE}.{name}")


@pytest.fixture(scope="module")
def desk(extension, tmp_path_factory):
    """The scene with its photograph, all materials grey, and no camera."""
    folder = tmp_path_factory.mktemp("desk")
    scene = studio.build()
    studio.colour()
    studio.render(scene, folder / "photo.exr", SAMPLES)
    studio.bleach()
    seen = {tuple(point): studio.project(scene, point) for point in studio.corners(scene)}
    assert len(seen) >= 8
    depsgraph = bpy.context.evaluated_depsgraph_get()
    true = scene.camera.matrix_world.copy(), module("frames").camera_of(scene.camera, depsgraph, studio.SIZE)
    bpy.data.objects.remove(scene.camera)
    scene.unrender.folder = str(folder / "work")
    return {"scene": scene, "folder": folder, "seen": seen, "true": true}


def test_it_is_installed_from_its_archive(extension, archive):
    import unrender

    where = pathlib.Path(unrender.__file__)
    assert "extensions" in where.parts, where
    assert hasattr(bpy.ops.unrender, "recover")
    assert hasattr(bpy.types, "UNRENDER_PT_match")


def test_1_match_camera(desk):
    scene, settings = desk["scene"], desk["scene"].unrender
    assert bpy.ops.unrender.load_photo(filepath=str(desk["folder"] / "photo.exr")) == {"FINISHED"}
    assert tuple(settings.size) == studio.SIZE
    assert settings.response == "linear"
    assert scene.camera.data.background_images[0].image.name == "unrender photograph"
    with pytest.raises(RuntimeError, match="5 pairs at least"):
        bpy.ops.unrender.match_camera()
    for number, (point, pixel) in enumerate(desk["seen"].items()):
        # One of them is wrong.
        off = 25.0 if number == 3 else 0.0
        bpy.ops.unrender.add_pair(point=point, pixel=(pixel[0], pixel[1] - off))
    assert bpy.ops.unrender.match_camera() == {"FINISHED"}
    assert [pair.rejected for pair in settings.pairs] == [k == 3 for k in range(len(settings.pairs))]
    assert settings.pairs[3].error == pytest.approx(25.0, abs=1.0)
    assert max(pair.error for pair in settings.pairs if not pair.rejected) < 0.3
    assert "standard deviation" in settings.focal
    place, camera = desk["true"]
    assert (scene.camera.matrix_world.translation - place.translation).length < 0.005
    assert np.degrees(scene.camera.data.angle_y) == pytest.approx(camera.fov_y_deg, abs=0.1)
    bpy.ops.unrender.remove_pair(index=3)
    assert len(settings.pairs) == len(desk["seen"]) - 1


def test_1_lines_of_the_photograph_give_the_camera(desk, tmp_path):
    import unrender

    scene, settings = desk["scene"], desk["scene"].unrender
    size = (640, 480)
    unrender.Picture(framed_walls(*size, fov_y_deg=45)).save(tmp_path / "room.exr")
    before = scene.camera.matrix_world.copy(), scene.camera.data.lens, settings.photo
    bpy.ops.unrender.load_photo(filepath=str(tmp_path / "room.exr"))
    settings.camera_height = 1.5
    assert bpy.ops.unrender.lines_camera() == {"FINISHED"}
    bpy.context.view_layer.update()
    found = module("frames").camera_of(scene.camera, bpy.context.evaluated_depsgraph_get(), size)
    assert found.fov_y_deg == pytest.approx(45, rel=0.01)
    assert found.eye[1] == pytest.approx(1.5, abs=1e-4)
    assert settings.focal.startswith("focal length")
    assert "unrender lines" in bpy.data.images
    bpy.ops.unrender.load_photo(filepath=before[2])
    scene.camera.matrix_world, scene.camera.data.lens = before[:2]


def framed_walls(width, height, fov_y_deg):
    """A room of 4 x 2.6 x 5 m from its corner, whose walls have frames: linear values, eight samples a pixel."""
    eye, forward = np.array([2.9, 1.5, 4.2]), np.array([-1.5, -0.4, -3.2])
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 1, 0])
    right /= np.linalg.norm(right)
    up, room = np.cross(right, forward), np.array([4, 2.6, 5])
    total = np.zeros((height, width))
    for sample in range(8):
        x = (np.arange(width) + (sample % 4 + 0.5) / 4 - width / 2) * 2 / height
        y = (height / 2 - np.arange(height) - (sample // 4 + 0.5) / 2) * 2 / height
        half = np.tan(np.radians(fov_y_deg) / 2)
        way = forward + half * (x[None, :, None] * right + y[:, None, None] * up)
        to = np.where(way < 0, -eye, room - eye) / way
        wall = to.argmin(axis=2)
        share = (eye + to.min(axis=2, keepdims=True) * way) / room
        off = np.abs(share - 0.5)
        np.put_along_axis(off, wall[..., None], 0, axis=2)
        total += 0.1 + 0.1 * wall + 0.15 * (off.max(axis=2) > 0.3)
    return np.repeat((total / 8)[..., None], 3, axis=2).astype(np.float32)


def test_1_a_click_takes_the_vertex_in_front(desk):
    pick = module("pick")
    scene, size = desk["scene"], (400, 300)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    camera = scene.camera
    lens = camera.calc_matrix_camera(depsgraph, x=size[0], y=size[1])
    view = lens @ camera.matrix_world.inverted()
    corner = Vector((-0.65, 0.05, 0.0))
    clip = view @ corner.to_4d()
    mouse = [(clip[k] / clip.w + 1.0) * 0.5 * size[k] + 3.0 for k in (0, 1)]
    found = pick.nearest_vertex(depsgraph, view, size, mouse)
    assert (found - corner).length < 1e-5
    assert pick.nearest_vertex(depsgraph, view, size, (-500.0, -500.0)) is None
    assert pick.pixel_of((0.25, 0.75), (160, 120)) == (40.0, 30.0)


def test_1_cameras_come_back_as_they_went(desk):
    frames = module("frames")
    thing = desk["scene"].camera
    kept = thing.matrix_world.copy(), thing.data.angle_y
    thing.data.shift_x, thing.data.shift_y = 0.07, -0.03
    depsgraph = bpy.context.evaluated_depsgraph_get()
    camera = frames.camera_of(thing, depsgraph, studio.SIZE)
    for point in desk["seen"]:
        ours = camera.project(frames.y_up([point]), *studio.SIZE)[0]
        assert np.allclose(ours, studio.project(desk["scene"], Vector(point)), atol=0.01)
    frames.place_camera(thing, camera)
    assert (thing.data.shift_x, thing.data.shift_y) == pytest.approx((0.07, -0.03), abs=1e-5)
    assert np.allclose(thing.matrix_world, kept[0], atol=1e-5)
    thing.data.shift_x = thing.data.shift_y = 0.0
    assert thing.data.angle_y == pytest.approx(kept[1], abs=1e-5)


def test_2_prepare(desk):
    settings = desk["scene"].unrender
    bpy.ops.unrender.list_groups()
    assert [item.name for item in settings.groups] == ["ball", "box", "floor", "wall"]
    assert bpy.ops.unrender.check(wait=True) == {"FINISHED"}
    assert settings.message.startswith("Check")
    assert all(item.pixels > 100 for item in settings.groups), [g.pixels for g in settings.groups]
    overlay = bpy.data.images["unrender check"]
    # Small photographs are enlarged.
    assert overlay.size[0] % studio.SIZE[0] == 0
    entries = {e.image.name: e for e in desk["scene"].camera.data.background_images}
    assert entries["unrender check"].display_depth == "FRONT"
    bpy.ops.unrender.toggle_overlay()
    assert not entries["unrender check"].show_background_image


def test_2_what_is_known_or_ignored_goes_over(desk):
    import unrender

    model, settings = module("model"), desk["scene"].unrender
    settings.groups["wall"].known = settings.groups["ball"].ignored = True
    path, materials, _ = model.project_of(bpy.context)
    project = unrender.Project.read(path)
    assert project.document["groups"]["wall"]["known"]["rho_d"] == pytest.approx([0.5] * 3)
    assert "ball" not in project.scene().groups
    bpy.ops.unrender.list_groups()
    assert settings.groups["wall"].known, "ticks stay"
    settings.groups["wall"].known = settings.groups["ball"].ignored = False


def test_2_a_world_of_nodes_becomes_a_panorama(extension, tmp_path, monkeypatch):
    import unrender

    world = module("world")
    monkeypatch.setattr(world, "PANORAMA_HEIGHT", 32)
    made = bpy.data.worlds.new("red to +x, green to +y, blue to +z")
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    positive = nodes.new("ShaderNodeVectorMath")
    positive.operation = "MAXIMUM"
    links.new(nodes.new("ShaderNodeTexCoord").outputs["Generated"], positive.inputs[0])
    links.new(positive.outputs[0], nodes["Background"].inputs["Color"])
    scenes = len(bpy.data.scenes)
    found = world.environment(made, str(tmp_path / "world.exr"))
    assert len(bpy.data.scenes) == scenes
    speck = unrender.Mesh("speck", [(0, 9, 0), (0.01, 9, 0), (0, 9, 0.01)], [(0, 1, 2)])
    for axis, color in (((1, 0, 0), (1, 0, 0)), ((0, 1, 0), (0, 1, 0)), ((0, 0, 1), (0, 0, 1))):
        target = module("frames").y_up_one(axis)
        up = (0, 1, 0) if axis != (0, 0, 1) else (1, 0, 0)
        camera = unrender.Camera(eye=(0, 0, 0), target=target, up=up, fov_y_deg=8)
        seen = unrender.render(
            unrender.Scene([speck], cameras=[camera]), environment=found["panorama"], width=4, height=4, spp=4
        )
        assert np.allclose(np.asarray(seen).mean((0, 1)), color, atol=0.08), (axis, seen.mean((0, 1)))


def test_3_a_recovery_can_be_cancelled(desk):
    job = module("job")
    scene = desk["scene"]
    path, *_ = module("model").project_of(bpy.context)
    import unrender

    def work(progress, token):
        return unrender.recover(path, progress=progress, cancel=token)

    ended = []
    started = job.start("Recover", scene, work, ended.append)
    assert scene.unrender.running == "Recover"
    assert not bpy.ops.unrender.recover.poll()
    assert bpy.ops.unrender.cancel() == {"FINISHED"}
    try:
        started.wait()
    except unrender.Cancelled:
        pass
    else:
        assert ended[0].result.interrupted
    assert scene.unrender.running == ""
    assert bpy.ops.unrender.recover.poll()


def test_3_recover(desk, monkeypatch):
    settings = desk["scene"].unrender
    pictures, shown = module("pictures"), []
    load = pictures.load

    def watched(path, name):
        image = load(path, name)
        shown.append((pathlib.Path(path).name, name, tuple(image.size)))
        return image

    monkeypatch.setattr(pictures, "load", watched)
    settings.max_rung, settings.spp = "isotropic", 16
    assert bpy.ops.unrender.recover(wait=True) == {"FINISHED"}
    assert {item.name for item in settings.results} == set(studio.TRUTH)
    by_name = {item.name: item for item in settings.results}
    assert by_name["ball"].hypothesis == "isotropic", by_name["ball"].numbers
    assert "±" in by_name["ball"].numbers
    assert settings.progress == 1.0
    assert bpy.data.images["unrender re-rendering"].size[0] == studio.SIZE[0]
    # The re-renderings on the way, and the final one.
    assert {("preview.png", "unrender re-rendering", studio.SIZE)} == set(shown[:-1])
    assert shown[-1][:2] == ("rerendered.png", "unrender re-rendering")
    import unrender

    recovery = unrender.Recovery.read(desk["folder"] / "work" / "result")
    for name, (rho_d, _, _) in studio.TRUTH.items():
        assert np.allclose(recovery.materials[name]["rho_d"], rho_d, atol=0.02), name


def test_4_apply_and_back(desk):
    scene, settings = desk["scene"], desk["scene"].unrender
    before = {o.name: [s.material for s in o.material_slots] for o in bpy.data.objects}
    assert bpy.ops.unrender.apply() == {"FINISHED"}
    assert bpy.data.objects["ball"].material_slots[0].material.name == "ball (recovered)"
    assert bpy.data.materials["ball"].node_tree is not None, "the old one is still there"
    assert settings.is_applied
    same_picture(desk)
    assert bpy.ops.unrender.revert() == {"FINISHED"}
    after = {o.name: [s.material for s in o.material_slots] for o in bpy.data.objects}
    assert before == after
    assert bpy.data.materials["ball (recovered)"].use_fake_user
    # Repeated, it makes no duplicates.
    bpy.ops.unrender.apply()
    bpy.ops.unrender.apply()
    bpy.ops.unrender.list_groups()
    assert [item.name for item in settings.groups] == ["ball", "box", "floor", "wall"]
    assert "ball (recovered).001" not in bpy.data.materials
    assert scene.objects["floor"].material_slots[0].material.name == "floor (recovered)"


def same_picture(desk):
    """Cycles with the applied materials against our own rendering: group means within 3 %."""
    import unrender

    folder = desk["folder"]
    studio.render(desk["scene"], folder / "applied.exr", SAMPLES)
    theirs = unrender.read_picture(folder / "applied.exr")
    work = folder / "work"
    ours = unrender.render(project=work / "project.toml", materials=work / "result", spp=SAMPLES, independent=True)
    means = compared(desk, theirs, ours)
    print({name: f"{100 * off:.2f} %" for name, off in means.items()})
    assert max(means.values()) < 0.03, means
    # The photograph agrees with both of them.
    means = compared(desk, unrender.read_picture(folder / "photo.exr"), ours)
    print({name: f"{100 * off:.2f} %" for name, off in means.items()})


def compared(desk, theirs, ours):
    """The relative difference of the mean radiance of every group, in the worst channel."""
    names, groups = group_map(desk)
    left, right = (studio.group_means(np.asarray(p), groups) for p in (theirs, ours))
    return {names[k]: float(np.max(np.abs(left[k] / right[k] - 1.0))) for k in left}


def group_map(desk):
    """The group that a pixel shows: a picture of the scene with a different colour for each."""
    import unrender

    work = desk["folder"] / "work"
    scene = unrender.Scene.read(work / "project.glb")
    names = [name for name in scene.groups if name in studio.TRUTH]
    groups = {
        name: unrender.Group(rho_d=(0, 0, 0), emission=(names.index(name) + 1.0,) * 3)
        if name in names else unrender.Group(rho_d=(0, 0, 0))
        for name in scene.groups
    }
    meshes = [scene.mesh(k) for k in range(len(scene.objects))]
    camera = unrender.Camera(**unrender.Project.read(work / "project.toml").document["camera"])
    flat = unrender.Scene(meshes, groups=groups, cameras=[camera])
    seen = np.asarray(unrender.render(flat, width=studio.SIZE[0], height=studio.SIZE[1], spp=4))[:, :, 0]
    whole = np.abs(seen - np.round(seen)) < 1e-3
    return names, np.where(whole & (seen > 0.5), np.round(seen).astype(int) - 1, -1)


BRUSHED = {"rho_d": [0.05] * 3, "rho_s": [0.6] * 3, "alpha_x": 0.08, "alpha_y": 0.35}


def blocks(picture, groups, number, size=6):
    """The means of a group's pixels in those squares of the picture that have enough of them."""
    inside = groups == number
    rows, columns = (length // size for length in inside.shape)
    cut = (slice(0, rows * size), slice(0, columns * size))
    count = inside[cut].reshape(rows, size, columns, size).sum((1, 3))
    light = np.where(inside, picture.mean(axis=2), 0.0)[cut].reshape(rows, size, columns, size).sum((1, 3))
    return (light / np.maximum(count, 1))[count >= size * size // 2]


@pytest.mark.parametrize("has_uvs", [True, False])
def test_4_textures_and_anisotropic_lobes_are_those_of_our_rendering(desk, has_uvs):
    import json

    import unrender

    scene, folder, nodes, apply = desk["scene"], desk["folder"] / f"brushed{has_uvs}", module("nodes"), module("apply")
    folder.mkdir()
    floor = scene.objects["floor"]
    if not has_uvs:
        floor.data.uv_layers.remove(floor.data.uv_layers[0])
    project, *_ = module("model").project_of(bpy.context)
    texture = np.full((8, 8, 3), 0.1, np.float32)
    texture[:3, :5] = (0.7, 0.5, 0.2)
    means = {}
    for theta in (25.0, 115.0):
        groups = {
            "floor": {**BRUSHED, "theta_deg": theta},
            "wall": {"rho_d": [0.3] * 3, "rho_s": [0.0] * 3, "alpha_x": 0.0, "alpha_y": 0.0, "theta_deg": 0.0},
        }
        materials = unrender.Materials(groups, brdf="ggx", textures={"wall": texture})
        materials.write(folder / "materials.json")
        glb = project.with_suffix(".glb")
        unrender.export(scene=glb, materials=folder / "materials.json", to="blender", out=folder / f"export{theta}",
                        width=studio.SIZE[0], height=studio.SIZE[1])
        document = json.loads((folder / f"export{theta}" / "scene.json").read_text())
        made = {}
        for entry in document["groups"]:
            if entry["name"] in groups:
                old = scene.objects[entry["name"]].material_slots[0].material
                made[old] = bpy.data.materials.new(entry["name"])
                nodes.build(made[old], entry, groups[entry["name"]], str(folder / f"export{theta}"),
                            has_uvs or entry["name"] == "wall")
        apply.exchange(made)
        studio.render(scene, folder / "theirs.exr", 128)
        apply.exchange({new: old for old, new in made.items()})
        ours = unrender.render(project=project, materials=folder / "materials.json", spp=128, independent=True)
        theirs = unrender.read_picture(folder / "theirs.exr")
        names, seen = group_map(desk)
        for name in groups:
            left, right = (blocks(np.asarray(p), seen, names.index(name)) for p in (theirs, ours))
            off = float(np.abs(left - right).mean() / right.mean())
            print(f"{name}, {theta} degrees: {100 * off:.2f} % by squares")
            assert off < 0.04, (name, theta, off)
            means[name, theta] = right
    turned = np.abs(means["floor", 25.0] - means["floor", 115.0]).mean() / means["floor", 25.0].mean()
    assert turned > 0.15, "the direction would not show"


def test_5_composite(desk):
    scene, settings = desk["scene"], desk["scene"].unrender
    bpy.ops.object.select_all(action="DESELECT")
    with pytest.raises(RuntimeError, match="Select objects"):
        bpy.ops.unrender.composite(wait=True)
    cube = studio.add("new", studio.material("new"), bpy.ops.mesh.primitive_cube_add, size=0.2, location=(0.55, -0.1, 0.1))
    cube.select_set(True)
    assert bpy.ops.unrender.mark_inserted() == {"FINISHED"}
    settings.spp = 16
    assert bpy.ops.unrender.composite(wait=True) == {"FINISHED"}, settings.message
    import unrender

    photo = np.asarray(unrender.read_picture(desk["folder"] / "photo.exr"))
    made = np.asarray(unrender.read_picture(desk["folder"] / "work" / "composite" / "composite.exr"))
    changed = np.any(photo != made, axis=2)
    assert 0.01 < changed.mean() < 0.6, changed.mean()
    x, y = (int(v) for v in studio.project(scene, Vector((0.55, -0.1, 0.1))))
    assert changed[y - 2 : y + 3, x - 2 : x + 3].all()
    assert "unrender composite" in bpy.data.images
    # It is not part of the model.
    model = module("model")
    shapes, materials, *_ = model.scene_of(bpy.context)
    assert "new" not in materials
    bpy.ops.unrender.mark_inserted(clear=True)
    _, materials, *_ = model.scene_of(bpy.context)
    assert "new" in materials


def test_6_several_photographs_give_one_set_of_materials(desk):
    import unrender

    scene, settings, folder = desk["scene"], desk["scene"].unrender, desk["folder"]
    first = scene.camera
    aside = bpy.data.objects.new("aside", bpy.data.cameras.new("aside"))
    aside.location, aside.rotation_euler = (0.7, -1.4, 0.9), (np.radians(66), 0.0, np.radians(26))
    aside.data.angle = np.radians(50)
    scene.collection.objects.link(aside)
    scene.camera = aside
    bpy.context.view_layer.update()
    studio.render(scene, folder / "aside.exr", SAMPLES)
    bpy.ops.unrender.revert()
    scene.camera = first
    assert bpy.ops.unrender.keep_photo() == {"FINISHED"}
    assert (settings.photo, len(settings.shots), len(settings.pairs), scene.camera) == ("", 1, 0, None)
    # Kept photographs can be checked without another one.
    assert bpy.ops.unrender.check(wait=True) == {"FINISHED"}, settings.message
    scene.camera = aside
    assert bpy.ops.unrender.load_photo(filepath=str(folder / "aside.exr")) == {"FINISHED"}
    assert [e.image.name for e in first.data.background_images][0] == "unrender photo.exr"
    path, *_ = module("model").project_of(bpy.context)
    photos = unrender.Project.read(path).document["photos"]
    assert [pathlib.Path(entry["photo"]).name for entry in photos] == ["photo.exr", "aside.exr"]
    assert [entry["exposure"] for entry in photos] == [1.0, "auto"]
    assert bpy.ops.unrender.check(wait=True) == {"FINISHED"}
    settings.max_rung, settings.spp = "isotropic", 16
    assert bpy.ops.unrender.recover(wait=True) == {"FINISHED"}, settings.message
    recovery = unrender.Recovery.read(folder / "work" / "result")
    assert recovery.photographs == 2
    for name, (rho_d, _, _) in studio.TRUTH.items():
        assert np.allclose(recovery.materials[name]["rho_d"], rho_d, atol=0.02), name
    assert recovery.of(1).exposure == pytest.approx([1.0] * 3, rel=0.02)
    # Back to the first, and without the other.
    settings.shot = 0
    assert bpy.ops.unrender.use_photo() == {"FINISHED"}
    assert pathlib.Path(settings.photo).name == "photo.exr" and scene.camera == first
    behind = [e.image.name for e in first.data.background_images if e.display_depth == "BACK"]
    assert behind == ["unrender photograph"]
    assert [shot.name for shot in settings.shots] == ["aside.exr"]
    assert bpy.ops.unrender.forget_photo() == {"FINISHED"}
    assert not settings.shots and not bpy.ops.unrender.forget_photo.poll()


def test_work_does_not_end_in_another_file(desk):
    job, settings = module("job"), desk["scene"].unrender
    ended = []
    started = job.start("Check", desk["scene"], lambda progress, token: None, ended.append)
    # As when another file is loaded.
    module("properties").forget_work()
    started.wait()
    assert not ended and not job.is_running() and settings.running == ""


def test_the_panel_draws_in_every_state(desk):
    panel = module("panel")

    class Layout:
        """Accepts everything that a panel draws, and keeps the texts."""

        texts = []

        def __getattr__(self, name):
            def drawn(*words, **options):
                self.texts.append(str(options.get("text", "")))
                return Layout()

            return drawn

        def __setattr__(self, name, value):
            pass

    class Panel:
        layout = Layout()

    settings = desk["scene"].unrender
    for running in ("", "Recover"):
        settings.running = running
        for made in panel.CLASSES:
            if issubclass(made, bpy.types.Panel):
                made.draw(Panel(), bpy.context)
            else:
                items = {"pairs": settings.pairs, "groups": settings.groups, "results": settings.results, "shots": settings.shots}
                for item in items[made.__name__.split("_")[-1]]:
                    made.draw_item(Panel(), bpy.context, Layout(), None, item, 0, None, "")
    settings.running = ""
    assert any("isotropic" in text for text in Layout.texts)
    assert any("px" in text for text in Layout.texts)


def test_it_can_be_disabled_and_enabled_again(desk):
    import addon_utils

    addon_utils.disable(MODULE)
    assert not hasattr(bpy.types, "UNRENDER_PT_match")
    addon_utils.enable(MODULE)
    assert hasattr(bpy.types, "UNRENDER_PT_match")
