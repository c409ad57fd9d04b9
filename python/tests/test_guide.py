"""The Python lines of the guide and the README run as they are printed, but for the size of pictures, on
small scenes under the names that they use."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import unrender
from conftest import ROOT

GUIDE = ROOT / "docs" / "guides" / "python.md"
# What needs a cluster or an interrupted notebook is only compiled.
ELSEWHERE = ("Client", "SLURMCluster", "sys.last_value")
SIZE = (48, 36)
# Pictures of a test's size.
SMALLER = {
    "width=640, height=480": "width={}, height={}".format(*SIZE),
    "spp=64": f"height={SIZE[1]}, spp=4",
    'render("room.glb", ': f'render("room.glb", height={SIZE[1]}, ',
}


def blocks(page: Path) -> list[str]:
    """The Python blocks of a page."""
    text = page.read_text()
    for printed, smaller in SMALLER.items():
        text = text.replace(printed, smaller)
    return re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def quad(*corners: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """A square of four corners, counter-clockwise seen from the front."""
    return np.array(corners, np.float32), np.array([[0, 1, 2], [0, 2, 3]])


def room() -> unrender.Scene:
    """A floor, a wall and a lamp under the ceiling, all with the names of the guide."""
    meshes = {
        "floor": quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)),
        "wall": quad((-1, 0, -1), (1, 0, -1), (1, 1.5, -1), (-1, 1.5, -1)),
        "ceil": quad((-1, 1.5, -1), (1, 1.5, -1), (1, 1.5, 1), (-1, 1.5, 1)),
        "lamp": quad((-0.3, 1.4, -0.3), (0.3, 1.4, -0.3), (0.3, 1.4, 0.3), (-0.3, 1.4, 0.3)),
        "ceiling": quad((0.5, 1.4, -0.3), (0.8, 1.4, -0.3), (0.8, 1.4, 0.3), (0.5, 1.4, 0.3)),
    }
    light = unrender.Group(rho_d=(0, 0, 0), emission=(8, 8, 8))
    uvs = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32)
    return unrender.Scene(
        [unrender.Mesh(name, *mesh, uvs=uvs) for name, mesh in meshes.items()],
        groups={"lamp": light, "ceiling": light},
        cameras=[unrender.Camera(name="door", eye=(0, 1.0, 3), target=(0, 0.6, 0), fov_y_deg=34)],
    )


def pairs() -> tuple[np.ndarray, np.ndarray]:
    """Corners of the room, and where the camera at the door shows them."""
    metres = np.array([[x, y, z] for x in (-0.8, 0.8) for y in (0.0, 1.2) for z in (-1.0, 0.5)])
    eye, target = np.array([0, 1.0, 3]), np.array([0, 0.6, 0])
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0, 1, 0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    depth = (metres - eye) @ forward
    focal = 0.5 * SIZE[1] / np.tan(np.radians(17))
    x = 0.5 * SIZE[0] + focal * ((metres - eye) @ right) / depth
    y = 0.5 * SIZE[1] - focal * ((metres - eye) @ up) / depth
    return np.stack([x, y], axis=1), metres


@pytest.fixture
def names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What the pages name without making it."""
    monkeypatch.chdir(tmp_path)
    scene = room()
    photo = unrender.render(scene, width=SIZE[0], height=SIZE[1], spp=16, independent=True)
    for name in ("from_the_door.jpg", "evening.jpg"):
        # Pictures are known by their content.
        photo.save("photo.png")
        Path("photo.png").rename(name)
    Path("examples/fig8").mkdir(parents=True)
    for file in ("room.glb", "examples/fig8/scene.glb"):
        unrender.export(scene=scene, materials={}, to="gltf", out=file)
    project = unrender.Project(scene, photo, response="linear", exposure=1.0)
    project.save("examples/fig8/fig8.toml")
    pixels, metres = pairs()
    vertices, faces = quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1))
    return {
        "scene": scene,
        "photo": photo,
        "pixels": pixels,
        "metres": metres,
        "project": project,
        "array": np.full((8, 8, 3), 0.5, np.float32),
        "vertices": vertices,
        "faces": faces,
        "uvs": np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32),
        "lamp_vertices": vertices * 0.3 + np.array([0, 1.4, 0], np.float32),
        "lamp_faces": faces[:, ::-1],
    }


def test_the_lines_of_the_guide_run_as_printed(names: dict[str, Any]) -> None:
    made = dict(names)
    for block in blocks(GUIDE):
        code = compile(block, str(GUIDE), "exec")
        if not any(word in block for word in ELSEWHERE):
            # A scene that a block makes is not that of the next.
            made.update(scene=names["scene"])
            exec(code, made)
    assert made["recovery"].photographs == 2


def test_the_lines_of_the_readme_run_as_printed(names: dict[str, Any]) -> None:
    [block] = blocks(ROOT / "python" / "README.md")
    exec(compile(block, "README.md", "exec"), dict(names))
