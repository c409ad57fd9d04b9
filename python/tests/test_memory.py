"""Scenes, projects, materials and arrays in memory give the same as files, to the bit, in every verb."""

from __future__ import annotations

import copy
import pickle
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import unrender
from test_objects import room

pytestmark = pytest.mark.filterwarnings("ignore::unrender.UnrenderWarning")

MATERIALS: dict[str, Any] = {"floor": {"rho_d": [0.2, 0.4, 0.6]}}


def lit_room() -> unrender.Scene:
    """The room under a sky."""
    plain = room()
    return unrender.Scene(
        [plain.mesh(k) for k in range(len(plain.objects))],
        groups=plain.groups,
        cameras=plain.cameras,
        environment=(0.2, 0.4, 0.8),
    )


def test_scenes_are_copied_and_sent_to_the_bit(corpus: Path) -> None:
    scene = lit_room()
    here = unrender.render(scene, height=12, spp=2)
    for same in (pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene)):
        np.testing.assert_array_equal(unrender.render(same, height=12, spp=2), here)
    read = unrender.Scene.read(corpus / "isotropic" / "scene.glb")
    assert pickle.loads(pickle.dumps(read)).path == read.path
    state = read.__getstate__()
    with pytest.raises(unrender.RequestError, match="not the bytes of a scene"):
        read.__setstate__({**state, "bytes": state["bytes"][:100]})


def test_parts_and_layers_are_made_of_objects(tmp_path: Path) -> None:
    scene, materials = lit_room(), unrender.Materials(MATERIALS)
    whole = unrender.render(scene, materials=materials, height=16, spp=8)
    parts = [tmp_path / "a.exr", tmp_path / "b.exr"]
    for samples, part in zip(((0, 3), (3, 8)), parts, strict=True):
        unrender.render(scene, materials=materials, height=16, samples=samples, out=part)
    np.testing.assert_array_equal(unrender.merge([*parts], out=tmp_path / "c.exr"), whole)
    layers = unrender.render(
        scene, materials=MATERIALS, height=16, spp=8, layers=True, out=tmp_path / "layers.exr"
    )
    alone = unrender.render(scene, materials=MATERIALS, height=16, spp=8, independent=True)
    np.testing.assert_allclose(layers, alone, rtol=1e-4, atol=1e-6)


def test_panoramas_are_arrays(tmp_path: Path) -> None:
    sky = np.linspace(0.1, 2.0, 8 * 16 * 3, dtype=np.float32).reshape(8, 16, 3)
    unrender.Picture(sky).save(tmp_path / "sky.exr")
    first, second = (
        unrender.render(room(), environment=given, height=12, spp=2)
        for given in (sky, tmp_path / "sky.exr")
    )
    np.testing.assert_array_equal(first, second)
    assert (first != unrender.render(room(), height=12, spp=2)).any()
    with pytest.raises(unrender.RequestError, match="panorama is an array"):
        unrender.render(room(), environment=sky[:, :, 0])
    size: dict[str, Any] = {"width": 16, "height": 12, "spp": 2}
    restaged = unrender.restage(scene=room(), environment=sky, **size).pictures
    again = unrender.restage(scene=room(), environment=str(tmp_path / "sky.exr"), **size).pictures
    np.testing.assert_array_equal(next(iter(restaged.values())), next(iter(again.values())))


def test_restage_takes_objects(tmp_path: Path) -> None:
    size: dict[str, Any] = {"width": 24, "height": 16, "spp": 2, "repaint": ["wall: rho_d = [0.9, 0.1, 0.1]"]}
    room().save(tmp_path / "room.glb")
    unrender.Materials(MATERIALS).write(tmp_path / "materials.json")
    files = unrender.restage(
        scene=tmp_path / "room.glb", materials=tmp_path / "materials.json", **size
    ).pictures
    objects = unrender.restage(scene=room(), materials=unrender.Materials(MATERIALS), **size).pictures
    assert list(objects) == list(files)
    for name, picture in objects.items():
        np.testing.assert_array_equal(picture, files[name])
    # The sky of a scene in memory is seen, though a .glb file cannot contain it.
    under_sky = next(iter(unrender.restage(scene=lit_room(), **size).pictures.values()))
    assert under_sky[0, 0, 2] >= 0.8
    with pytest.raises(unrender.RequestError, match=r"Scene\.read"):
        unrender.restage(scene=room(), light_units="unitless", **size)


def test_a_project_in_memory_is_restaged(tmp_path: Path) -> None:
    scene = lit_room()
    photo = unrender.render(scene, width=24, height=24, spp=16)
    project = unrender.Project(scene, photo, response="linear", exposure=1.0)
    made = unrender.restage(
        project=project, materials=MATERIALS, remove=["wall"], composite=True, spp=2, out=tmp_path / "new"
    )
    assert made.folder == tmp_path / "new"
    picture = made.pictures["composite"]
    assert picture.shape == photo.shape
    # The sky, which was behind the wall.
    np.testing.assert_allclose(picture[2, 12], (0.2, 0.4, 0.8), rtol=0.2)


def test_export_takes_objects(tmp_path: Path) -> None:
    room().save(tmp_path / "room.glb")
    unrender.Materials(MATERIALS).write(tmp_path / "materials.json")
    size: dict[str, Any] = {"to": "mitsuba", "width": 24, "height": 16}
    unrender.export(scene=room(), materials=MATERIALS, out=tmp_path / "objects", **size)
    unrender.export(
        scene=tmp_path / "room.glb", materials=tmp_path / "materials.json", out=tmp_path / "files", **size
    )
    names = sorted(path.name for path in (tmp_path / "files").iterdir())
    assert names == sorted(path.name for path in (tmp_path / "objects").iterdir())
    scenes = [(tmp_path / kind / "scene.xml").read_text() for kind in ("objects", "files")]
    assert "0.2" in scenes[0]
    assert scenes[0] == scenes[1]


def test_calibrate_takes_arrays_and_makes_projects(tmp_path: Path) -> None:
    scene = lit_room()
    photo = unrender.render(scene, width=160, height=120, spp=1)
    camera = unrender.Camera(eye=(0.5, 1.5, 4), target=(0, 1, 0), fov_y_deg=40)
    metres = np.random.default_rng(1).uniform(-1, 1, (12, 3)) + [0, 1, 0]
    points = (camera.project(metres, 160, 120), metres)
    found = unrender.calibrate(photo, scene=scene, points=points)
    np.testing.assert_allclose(np.asarray(found.camera.eye), camera.eye, atol=0.02)
    out = tmp_path / "made" / "room.toml"
    again = unrender.calibrate(photo, scene=scene, points=points, out=out)
    assert again.camera == found.camera
    read = unrender.Project.read(out)
    assert read.document["camera"]["fov_y_deg"] == pytest.approx(40, abs=0.2)
    # The project contains the scene's sky.
    whole = unrender.Project(scene, photo, camera=found.camera)
    first, second = (unrender.render(project=p, spp=1) for p in (read, whole))
    np.testing.assert_array_equal(first, second)
    glb = tmp_path / "seen.glb"
    assert unrender.calibrate(photo, scene=scene, points=points, out=glb).camera.name == "calibrated"
    with pytest.raises(unrender.RequestError, match="give photo and scene"):
        unrender.calibrate(scene=scene, points=points)
    with pytest.raises(unrender.RequestError, match="give photo and scene"):
        unrender.calibrate(photo, points=points)
    with pytest.raises(unrender.RequestError, match="is a project already"):
        unrender.calibrate(photo, scene=scene, points=points, out=out)


def test_calibrate_takes_lines_without_a_scene(tmp_path: Path) -> None:
    camera = unrender.Camera(eye=(1.6, 1.4, 3), target=(0, 0.4, 0), fov_y_deg=40)
    rows: list[list[object]] = []
    for axis in range(3):
        for corner in ((0, 0), (0, 1), (1, 0), (1, 1)):
            begin = np.insert(np.asarray(corner, dtype=float), axis, 0)
            ends = camera.project(np.array([begin, begin + np.eye(3)[axis]]), 640, 480)
            rows.append([f"+{'xyz'[axis]}", *ends.ravel(), 1.0 if not rows else ""])
    file = tmp_path / "lines.csv"
    header = "axis,x1_px,y1_px,x2_px,y2_px,length_m"
    file.write_text("\n".join([header, *(",".join(map(str, row)) for row in rows)]))
    photo = np.full((480, 640, 3), 0.5, dtype=np.float32)
    unrender.Picture(photo).save(tmp_path / "photo.exr")
    found = unrender.calibrate(tmp_path / "photo.exr", lines=file)
    np.testing.assert_allclose(np.asarray(found.camera.eye), camera.eye, atol=0.01)
    assert "12 of 12 lines" in found.summary
    with pytest.raises(unrender.CalibrateError, match="show no two perpendicular directions"):
        unrender.calibrate(tmp_path / "photo.exr", lines="auto")
    with pytest.raises(unrender.RequestError, match="take the path of the photo"):
        unrender.calibrate(photo, lines=file)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_integer_codes_are_written_without_a_loss(kind: Any, tmp_path: Path) -> None:
    scene = room()
    picture = unrender.render(scene, width=24, height=20, spp=64, independent=True)
    most = np.iinfo(kind).max
    codes = np.round(most * unrender.Picture(picture / 4).srgb()).astype(kind)
    project = unrender.Project(scene, codes, exposure=4.0)
    options: dict[str, Any] = {"spp": 2, "no_refine": True}
    here = unrender.recover(project, **options)
    saved = unrender.recover(project.save(tmp_path / "room.toml"), **options)
    np.testing.assert_array_equal(saved.photo, here.photo)
    assert dict(saved.materials) == dict(here.materials)
    assert unrender.check(project).document["groups"]


@pytest.mark.parametrize("kind", [np.int32, np.int64, np.uint32])
def test_integers_without_a_known_white_are_refused(kind: Any) -> None:
    project = unrender.Project(room(), np.full((20, 24, 3), 200, kind), exposure=1.0)
    with pytest.raises(unrender.RequestError, match="codes of 0 to 255 are uint8"):
        unrender.check(project)


def test_what_is_no_number_does_not_count_in_files_either(tmp_path: Path) -> None:
    scene = room()
    photo = np.array(unrender.render(scene, width=24, height=20, spp=64))
    photo[3:9, 4:12] = np.nan
    options: dict[str, Any] = {"spp": 1, "no_refine": True}
    for mask in (None, np.arange(24)[None, :] * np.ones((20, 1)) > 10):
        project = unrender.Project(scene, photo, exposure=1.0, mask=mask)
        file = project.save(tmp_path / "room.toml")
        for recovery in (unrender.recover(project, **options), unrender.recover(file, **options)):
            assert not recovery.valid[3:9, 4:12].any()
            assert recovery.valid[:, 12:].any()
    # The mask of a file is kept, with its greys.
    grey = np.full((20, 24, 3), 0.3, np.float32)
    grey[:, 20:] = 1.0
    unrender.Picture(grey).save(tmp_path / "mask.png")
    project = unrender.Project(scene, photo, exposure=1.0, mask="mask.png", folder=tmp_path)
    (tmp_path / "elsewhere").mkdir()
    recovery = unrender.recover(project.save(tmp_path / "elsewhere" / "room.toml"), **options)
    assert recovery.valid.any()
    assert recovery.valid[:, :20].any()


def test_a_project_that_was_changed_is_what_it_is_now(corpus: Path) -> None:
    project = unrender.Project.read(corpus / "plastic" / "project.toml")
    assert project.path is not None
    before = unrender.recover(project, spp=1, max_rung="diffuse", no_refine=True)
    project.document["exposure"] = 2.0
    assert project.path is None
    after = unrender.recover(project, spp=1, max_rung="diffuse", no_refine=True)
    assert (after.exposure == 2.0).all()
    assert not (before.exposure == 2.0).all()
    with project.as_file() as file:
        stated = unrender.Project.read(file)
        assert stated.document["exposure"] == 2.0
        assert (file.parent / stated.document["scene"]).is_file()


def test_a_sky_that_a_glb_lacks_is_told(tmp_path: Path) -> None:
    with pytest.warns(unrender.UnrenderWarning, match="environment"):
        lit_room().save(tmp_path / "room.glb")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        room().save(tmp_path / "room.glb")


def test_reports_compare_recoveries_in_memory(tmp_path: Path) -> None:
    scene = room()
    photo = unrender.render(scene, width=16, height=16, spp=16)
    project = unrender.Project(scene, photo, exposure=1.0)
    two = [unrender.recover(project, spp=1, max_rung="diffuse", no_refine=True, seed=k) for k in (0, 1)]
    assert "<html" in unrender.report(two, out=tmp_path / "both.html").read_text(encoding="utf-8")
