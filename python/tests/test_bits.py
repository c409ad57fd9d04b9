"""Tests that pictures and materials equal those of the command to the bit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import unrender
from conftest import Command

pytestmark = pytest.mark.filterwarnings("ignore::unrender.UnrenderWarning")


def test_render_has_the_bits_of_the_command(fig8: Path, command: Command, tmp_path: Path) -> None:
    scene, truth, out = fig8 / "scene.glb", fig8 / "truth.json", tmp_path / "picture.exr"
    options: dict[str, Any] = {"width": 64, "height": 48, "spp": 3, "seed": 5}
    flags = [f"--{name}={value}" for name, value in options.items()]
    command("render", scene, "--materials", truth, *flags, "--out", out)
    expected = np.asarray(unrender.read_picture(out))
    document = json.loads(truth.read_text())
    in_memory = unrender.Scene.read(scene)
    for materials in (truth, document, document["groups"], unrender.Materials.read(truth)):
        if "brdf" in document and materials is document["groups"]:
            continue
        picture = unrender.render(scene, materials=materials, **options)
        assert isinstance(picture, np.ndarray)
        assert picture.dtype == np.float32
        assert picture.shape == (48, 64, 3)
        np.testing.assert_array_equal(picture, expected)
    picture = unrender.render(in_memory, materials=truth, threads=1, **options)
    np.testing.assert_array_equal(picture, expected)
    with_truth = in_memory.with_materials(truth)
    np.testing.assert_array_equal(unrender.render(with_truth, **options), expected)
    other = unrender.render(scene, materials=truth, **{**options, "seed": 6})
    assert not np.array_equal(other, expected)


def test_a_project_is_rendered_as_by_the_command(
    corpus: Path, command: Command, tmp_path: Path
) -> None:
    project, out = corpus / "mirror" / "project.toml", tmp_path / "picture.exr"
    command("render", "--project", project, "--spp=2", "--independent", "--out", out)
    picture = unrender.render(project=project, spp=2, independent=True)
    np.testing.assert_array_equal(picture, unrender.read_picture(out))


def test_recover_has_the_bits_of_the_command(corpus: Path, command: Command, tmp_path: Path) -> None:
    project = corpus / "textured" / "project.toml"
    command("recover", project, "--out", tmp_path / "command", "--seed=3", "--spp=2", "--effort=draft")
    options: dict[str, Any] = {"seed": 3, "spp": 2, "effort": "draft"}
    recovery = unrender.recover(project, out=tmp_path / "python", **options)
    by_command = unrender.Recovery.read(tmp_path / "command")
    by_python = unrender.Recovery.read(tmp_path / "python")
    np.testing.assert_array_equal(recovery.rerendered, by_command.rerendered)
    np.testing.assert_array_equal(by_python.rerendered, by_command.rerendered)
    assert by_python.materials.document["groups"] == by_command.materials.document["groups"]
    for group, of_command in by_command.materials.items():
        entry, got = dict(of_command), dict(recovery.materials[group])
        texture = entry.pop("texture")
        got.pop("texture")
        assert got == entry
        if texture is not None:
            texels = recovery.texture(group)
            assert texels is not None
            np.testing.assert_array_equal(texels, by_command.texture(group))
    # The texture in memory is that of the file.
    in_memory = unrender.render(project=project, materials=recovery, spp=2)
    from_files = unrender.render(project=project, materials=tmp_path / "python", spp=2)
    np.testing.assert_array_equal(in_memory, from_files)


def test_parts_merge_to_the_bits_of_one_run(corpus: Path, tmp_path: Path) -> None:
    scene = corpus / "plastic" / "scene.glb"
    whole = unrender.render(scene, height=24, spp=6)
    parts: list[Path] = []
    for samples in ((0, 4), range(4, 6)):
        parts.append(tmp_path / f"part{len(parts)}.exr")
        unrender.render(scene, height=24, samples=samples, out=parts[-1])
    merged = unrender.merge(parts, out=tmp_path / "merged.exr")
    np.testing.assert_array_equal(merged, whole)
