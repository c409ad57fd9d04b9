"""Scenes from arrays, projects in memory, and the results of a recovery."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import unrender
from numpy.typing import NDArray

pytestmark = pytest.mark.filterwarnings("ignore::unrender.UnrenderWarning")

SQUARE = np.array([[0, 1, 2], [0, 2, 3]])


def quad(group: str, corners: list[list[float]]) -> unrender.Mesh:
    return unrender.Mesh(group, np.array(corners), SQUARE, uvs=[[0, 1], [1, 1], [1, 0], [0, 0]])


def room(wall: tuple[float, float, float] = (0.7, 0.7, 0.7)) -> unrender.Scene:
    """A floor, a wall and a lamp."""
    meshes = [
        quad("floor", [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]]),
        quad("wall", [[-1, 0, -1], [1, 0, -1], [1, 2, -1], [-1, 2, -1]]),
        quad("lamp", [[-0.4, 2, -0.4], [0.4, 2, -0.4], [0.4, 2, 0.4], [-0.4, 2, 0.4]]),
    ]
    groups = {
        "floor": unrender.Group(rho_d=(0.6, 0.3, 0.1)),
        "wall": unrender.Group(rho_d=wall),
        "lamp": unrender.Group(rho_d=(0, 0, 0), emission=(8, 8, 8)),
    }
    camera = unrender.Camera(eye=(0, 1.4, 3), target=(0, 0.6, 0), fov_y_deg=34)
    return unrender.Scene(meshes, groups=groups, cameras=[camera])


def test_a_scene_of_arrays_is_there_and_back() -> None:
    scene = room()
    assert list(scene.groups) == ["floor", "wall", "lamp"]
    assert scene.groups["lamp"].emission == [8.0, 8.0, 8.0]
    assert scene.objects[1] == ("wall", "wall")
    mesh = scene.mesh(0)
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    assert vertices.dtype == np.float32
    assert vertices.shape == (6, 3)
    assert faces.shape == (2, 3)
    assert np.asarray(mesh.uvs).shape == (6, 2)
    np.testing.assert_allclose(np.asarray(mesh.normals), [[0, 1, 0]] * 6, atol=1e-6)
    camera = scene.cameras[0]
    np.testing.assert_allclose(np.asarray(camera.eye), (0, 1.4, 3), atol=1e-6)
    assert camera.fov_y_deg == pytest.approx(34)


def unaligned(values: list[list[float]], dtype: Any) -> NDArray[Any]:
    """An array that begins at an odd byte, as an array from a network may."""
    array = np.asarray(values, dtype=dtype)
    apart = np.frombuffer(b"-" + array.tobytes(), dtype=dtype, offset=1).reshape(array.shape)
    assert not apart.flags.aligned
    return apart


def test_arrays_may_begin_at_any_byte() -> None:
    corners = unaligned([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], np.float32)
    faces = unaligned([[0, 1, 2], [0, 2, 3]], np.uint32)
    groups = {"floor": unrender.Group(rho_d=(0.5, 0.5, 0.5))}
    scene = unrender.Scene([unrender.Mesh("floor", corners, faces)], groups=groups)
    np.testing.assert_array_equal(np.asarray(scene.mesh(0).vertices)[0], corners[0])


def test_a_scene_of_arrays_equals_its_file(tmp_path: Path) -> None:
    scene = room()
    scene.save(tmp_path / "room.glb")
    again = unrender.Scene.read(tmp_path / "room.glb")
    assert list(again.groups) == list(scene.groups)
    first, second = (unrender.render(s, height=20, spp=2) for s in (scene, again))
    np.testing.assert_array_equal(first, second)


def test_textures_are_arrays() -> None:
    texture = np.zeros((4, 4, 3), np.float32)
    texture[:, :2] = 0.9
    scene = room().with_materials(unrender.Materials({"wall": {}}, textures={"wall": texture}))
    got = scene.texture("wall")
    assert got is not None
    np.testing.assert_array_equal(got, texture)
    assert scene.texture("floor") is None
    picture = unrender.render(scene, height=32, spp=8)
    assert picture[8, 12].mean() > 3 * picture[8, 20].mean()


def test_cameras_project_what_they_see() -> None:
    camera = unrender.Camera(eye=(0, 0, 2), target=(0, 0, 0), fov_y_deg=90)
    seen = camera.project([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 5]], 100, 50)
    np.testing.assert_allclose(seen[:3], np.array([[50.0, 25.0], [62.5, 25.0], [50.0, 12.5]]))
    assert np.isnan(seen[3]).all()
    scene = room().with_camera(unrender.Camera(eye=(0, 1, 2.5), target=(0, 1, 0), name="near"))
    assert [c.name for c in scene.cameras] == ["camera", "near"]
    picture = unrender.render(scene, camera="near", height=8, spp=1)
    again = unrender.render(room(), camera=scene.cameras[1], height=8, spp=1)
    np.testing.assert_array_equal(picture, again)


def test_a_project_in_memory_finds_its_materials(tmp_path: Path) -> None:
    scene = room()
    photo = unrender.render(scene, width=24, height=24, spp=256, independent=True)
    unknown = room(wall=(0.1, 0.1, 0.1))
    project = unrender.Project(unknown, photo, response="linear", exposure=1.0)
    recovery = unrender.recover(project, spp=8)
    for group, truth in {"floor": (0.6, 0.3, 0.1), "wall": (0.7, 0.7, 0.7)}.items():
        np.testing.assert_allclose(recovery.materials[group]["rho_d"], truth, atol=0.02)
    # The same from files, to the bit.
    saved = unrender.recover(project.save(tmp_path / "room.toml"), spp=8)
    np.testing.assert_array_equal(recovery.rerendered, saved.rerendered)
    # Results of a project in memory can be written like others.
    recovery.save(tmp_path / "out")
    assert (tmp_path / "out" / "report.html").is_file()
    read = unrender.Recovery.read(tmp_path / "out")
    np.testing.assert_array_equal(read.rerendered, recovery.rerendered)
    checked = unrender.check(project)
    # Small photographs are shown larger.
    assert checked.edges.shape == (96, 96, 3)


def test_several_photographs_have_one_set_of_materials(tmp_path: Path) -> None:
    scene = room()
    aside = unrender.Camera(eye=(0.9, 1.2, 2.6), target=(0, 0.7, 0), fov_y_deg=36)
    photos = []
    for number, camera in enumerate([scene.cameras[0], aside]):
        picture = unrender.render(scene, camera=camera, width=24, height=20 + number, spp=256, independent=True)
        unrender.Picture(picture).save(tmp_path / f"{number}.exr")
        photos.append({"photo": tmp_path / f"{number}.exr", "camera": camera})
    photos[1]["exposure"] = "auto"
    project = unrender.Project(
        room(wall=(0.1, 0.1, 0.1)), photos=photos, response="linear", exposure=1.0
    )
    recovery = unrender.recover(project, spp=8, effort="draft", out=tmp_path / "out")
    np.testing.assert_allclose(recovery.materials["wall"]["rho_d"], (0.7, 0.7, 0.7), atol=0.03)
    assert recovery.photographs == 2
    read = unrender.Recovery.read(tmp_path / "out")
    assert read.photographs == 2
    for number in range(2):
        of = recovery.of(number)
        assert of.rerendered.shape == of.photo.shape == (20 + number, 24, 3)
        assert of.group_map.shape == of.status_map.shape == of.noise.shape == (20 + number, 24)
        assert of.camera is not None
        np.testing.assert_array_equal(read.of(number).rerendered, of.rerendered)
    np.testing.assert_array_equal(recovery.rerendered, recovery.of(0).rerendered)
    np.testing.assert_array_equal(recovery.exposure, 1.0)
    np.testing.assert_allclose(recovery.of(1).exposure, 1.0, rtol=0.02)
    std = recovery.of(1).exposure_std
    assert recovery.of(0).exposure_std is None
    assert std is not None and 0.0 < std[0] < 0.02
    assert unrender.render(project=project, photo=2, spp=2).shape == (21, 24, 3)
    with pytest.raises(unrender.RequestError, match="no photograph 2"):
        recovery.of(2)
    # A project that is saved elsewhere still finds its files.
    saved = project.save(tmp_path / "elsewhere" / "room.toml")
    assert len(unrender.check(saved).document["further"]) == 1


def test_integer_codes_and_masks_are_taken(corpus: Path) -> None:
    scene = room()
    picture = unrender.render(scene, width=24, height=24, spp=64, independent=True)
    codes = np.round(255 * unrender.Picture(picture / 4).srgb()).astype(np.uint8)
    mask = np.ones((24, 24), bool)
    mask[:6] = False
    project = unrender.Project(scene, codes, exposure=4.0, mask=mask)
    recovery = unrender.recover(project, spp=2, no_refine=True)
    assert not recovery.valid[:6].any()
    assert recovery.valid.any()
    np.testing.assert_allclose(recovery.materials["floor"]["rho_d"], (0.6, 0.3, 0.1), atol=0.05)


def test_a_recovery_hands_over_what_it_knows(corpus: Path, tmp_path: Path) -> None:
    recovery = unrender.recover(
        corpus / "isotropic" / "project.toml", spp=2, effort="draft", out=tmp_path / "out"
    )
    height, width, _ = recovery.rerendered.shape
    assert recovery.photo.shape == recovery.rerendered.shape
    assert recovery.noise.shape == recovery.group_map.shape == (height, width)
    assert set(np.unique(recovery.group_map)) <= set(range(-1, len(recovery.materials)))
    assert not recovery.interrupted
    assert recovery.iterations[-1]["refining"]
    assert recovery.seconds > 0.0
    covariance = recovery.covariance
    assert covariance is not None
    assert covariance.matrix.shape == (len(covariance.names),) * 2
    np.testing.assert_allclose(covariance.matrix, covariance.matrix.T, rtol=1e-6, atol=1e-12)
    assert np.abs(covariance.correlation).max() < 1.0 + 1e-6
    checked = 0
    for (name, group, channel), std in zip(covariance.names, covariance.std, strict=True):
        if name in ("rho_d", "rho_s") and group is not None and channel is not None:
            stated = recovery.materials[group]["std"][name]
            assert stated[channel] == pytest.approx(std, rel=1e-3)
            checked += 1
        if name == "alpha" and group is not None:
            stated = recovery.materials[group]["std"]["alpha_x"]
            assert stated == pytest.approx(std, rel=1e-3)
            checked += 1
    assert checked > 3
    html = recovery._repr_html_()
    assert "data:image/png;base64," in html
    png = recovery._repr_png_()
    assert png is not None
    assert png.startswith(b"\x89PNG")
    table = recovery.to_pandas()
    assert list(table.index) == list(recovery.materials)
    assert "std_rho_d_red" in table.columns
    tables = recovery.to_xarray()
    assert tables["rerendered"].shape == (height, width, 3)
    assert tables["rho_d"].sel(channel="red").shape == (len(recovery.materials),)


def test_pictures_are_handed_over_without_a_copy() -> None:
    picture = unrender.render(room(), width=16, height=8, spp=1)
    assert picture.base is not None
    assert picture.flags.c_contiguous
    same = unrender.Picture(picture)
    assert np.shares_memory(same, picture)
    png = picture._repr_png_()
    assert png is not None
    assert picture[0]._repr_png_() is None
