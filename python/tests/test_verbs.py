"""The verbs: their signatures are the flags of the command, and their results are the same."""

from __future__ import annotations

import inspect
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import unrender
from unrender import _unrender

pytestmark = pytest.mark.filterwarnings("ignore::unrender.UnrenderWarning")

VERBS: dict[str, Callable[..., object]] = {
    "calibrate": unrender.calibrate,
    "check": unrender.check,
    "export": unrender.export,
    "fit-brdf": unrender.fit_brdf,
    "init": unrender.init,
    "merge": unrender.merge,
    "merge-exposures": unrender.merge_exposures,
    "plan": unrender.plan,
    "recover": unrender.recover,
    "relight": unrender.relight,
    "render": unrender.render,
    "report": unrender.report,
    "restage": unrender.restage,
    "score": unrender.score,
    "split": unrender.split,
    "view": unrender.view,
}
# Functions return values instead of printing them.
# `resume` continues from the files of a killed process in a folder.
ONLY_COMMAND = {"json", "help", "version", "quiet", "resume"}
# They are about the command itself; Python has unrender.dask in place of `farm`.
NO_VERBS = {"help", "completions", "farm", "man"}
ONLY_PYTHON = {"progress", "cancel", "on_iteration"}
# A Project in memory names its scene and photograph itself.
IN_THE_PROJECT = {"recover": {"scene", "photo"}}
GLOBAL = {"threads", "allow_outside", "allow_missing", "input_memory"}


def described() -> dict[str, Any]:
    commands: dict[str, Any] = json.loads(_unrender.description())
    return {name: command for name, command in commands.items() if name not in NO_VERBS}


def test_there_is_a_verb_for_every_subcommand() -> None:
    assert set(described()) == set(VERBS)


@pytest.mark.parametrize("verb", sorted(VERBS))
def test_options_have_the_names_and_defaults_of_flags(verb: str) -> None:
    flags = {flag["name"]: flag for flag in described()[verb]["flags"]}
    parameters = inspect.signature(VERBS[verb]).parameters
    own = set(flags) - ONLY_COMMAND - GLOBAL - IN_THE_PROJECT.get(verb, set())
    assert own <= set(parameters), own - set(parameters)
    assert set(parameters) <= own | GLOBAL | ONLY_PYTHON, set(parameters) - own
    for name in own:
        flag, default = flags[name], parameters[name].default
        if flag["switch"]:
            assert default is False, name
        elif flag["default"] is not None and name != "out":
            same = default == flag["default"] or float(default) == float(flag["default"])
            assert same, (name, default, flag["default"])
        else:
            assert default in (None, inspect.Parameter.empty), name


@pytest.fixture(scope="module")
def recovery(corpus: Path) -> unrender.Recovery:
    return unrender.recover(corpus / "plastic" / "project.toml", spp=4, effort="draft", no_refine=True)


def test_check_says_what_to_mend(corpus: Path) -> None:
    checkup = unrender.check(corpus / "plastic" / "project.toml")
    assert checkup.document["groups"]
    assert checkup.edges.ndim == 3
    assert checkup._repr_png_() is not None


def test_a_project_is_made_of_two_files(corpus: Path, tmp_path: Path) -> None:
    scene, photo, out = corpus / "plastic" / "scene.glb", corpus / "plastic" / "photo.jpg", tmp_path / "p.toml"
    proposed = unrender.init(scene, photo, out=out)
    assert proposed.path == out
    assert "is written" in proposed.summary
    assert unrender.check(out).document["groups"]
    with pytest.raises(unrender.FileError, match="there already"):
        unrender.init(scene, photo, out=out)


def test_a_plan_ranks_further_photographs(
    recovery: unrender.Recovery, corpus: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "plastic"
    shutil.copytree(corpus / "plastic", folder)
    # One group is open: each candidate is a refinement of all that are.
    names = [name for name in recovery.materials if name != "floor"]
    known = [f"\n[groups.{name}]\nknown = {{ rho_d = 0.5 }}\n" for name in names]
    project = folder / "project.toml"
    project.write_text(project.read_text(encoding="utf-8") + "".join(known), encoding="utf-8")
    planned = unrender.plan(project, recovered=recovery)
    ratios = [candidate["ratio"] for candidate in planned.candidates]
    assert ratios
    assert ratios == sorted(ratios)
    assert {"eye", "target"} <= set(planned.candidates[0]["camera"])


def test_score_compares_with_the_truth(recovery: unrender.Recovery, corpus: Path) -> None:
    truth = corpus / "plastic" / "truth.json"
    scored = unrender.score(recovery, truth)
    assert scored.groups
    assert scored.exceeded == []
    assert unrender.score(recovery, truth, max_rho=1e-9).exceeded
    assert unrender.score(truth, truth).worst["rho_d"] == 0.0


def test_report_and_export_write_their_files(recovery: unrender.Recovery, tmp_path: Path) -> None:
    page = unrender.report(recovery, out=tmp_path / "page.html")
    assert "<html" in page.read_text(encoding="utf-8")
    folder = recovery.save(tmp_path / "results")
    assert unrender.report(folder) == folder / "report.html"
    glb = unrender.export(recovery, to="gltf", out=tmp_path / "scene.glb")
    assert glb.read_bytes()[:4] == b"glTF"
    with pytest.raises(unrender.RequestError, match="to"):
        unrender.export(recovery, to="paper", out=tmp_path / "x")


def test_a_page_of_light_and_colours_is_written_and_shown_inline(
    recovery: unrender.Recovery, tmp_path: Path
) -> None:
    folder = recovery.save(tmp_path / "results")
    page = recovery.view(spp=8)
    assert page.path == folder / "view.html"
    assert page.html == (folder / "view.html").read_text(encoding="utf-8")
    inline = page._repr_html_()
    assert inline.startswith("<iframe srcdoc=")
    assert "allow-same-origin" not in inline
    again = unrender.view(folder, no_open=True, spp=8, out=tmp_path / "page.html")
    assert again.html == page.html
    assert again.save(tmp_path / "copy.html").read_text(encoding="utf-8") == page.html


def test_lights_are_made_brighter_by_their_layers(corpus: Path, tmp_path: Path) -> None:
    scene, layers, out = corpus / "plastic" / "scene.glb", tmp_path / "layers.exr", tmp_path / "relit.exr"
    picture = unrender.render(scene, width=40, height=30, spp=4, layers=True, out=layers)
    np.testing.assert_allclose(unrender.relight(layers, out=out), picture, rtol=1e-4, atol=1e-6)
    with pytest.raises(unrender.Error, match="has no light") as refused:
        unrender.relight(layers, light={"nobody": 1}, out=out)
    lights = str(refused.value).split("it has ")[1].replace('"', "").split(", ")
    doubled = unrender.relight(layers, light={name: (2, 2, 2) for name in lights}, out=out)
    np.testing.assert_allclose(doubled, 2 * picture, rtol=1e-4, atol=1e-6)
    alone = sum(unrender.relight(layers, only=[name], out=out) for name in lights)
    np.testing.assert_allclose(alone, picture, rtol=1e-4, atol=1e-6)
    with pytest.raises(unrender.RequestError, match="give out"):
        unrender.render(scene, layers=True)


def test_exposures_are_merged(tmp_path: Path) -> None:
    scene = np.linspace(0.02, 0.9, 64 * 48 * 3, dtype=np.float32).reshape(48, 64, 3)
    dark, bright = tmp_path / "dark.exr", tmp_path / "bright.exr"
    unrender.Picture(scene).save(dark)
    unrender.Picture(4.0 * scene).save(bright)
    merged = unrender.merge_exposures([dark, bright], times=["1/60", "1/15"], out=tmp_path / "m.exr")
    shares = merged / scene
    assert np.ptp(shares) < 2e-3 * shares.mean()
    with pytest.raises(unrender.Error, match="exposure time"):
        unrender.merge_exposures([dark, bright], out=tmp_path / "again.exr")


def test_restage_makes_new_pictures(recovery: unrender.Recovery, corpus: Path) -> None:
    group = next(iter(recovery.materials))
    repaint = [f"{group}: rho_d = [0.1, 0.1, 0.8]"]
    project = corpus / "plastic" / "project.toml"
    made = unrender.restage(recovered=recovery, project=project, repaint=repaint, spp=2)
    assert made.folder is None
    picture = next(iter(made.pictures.values()))
    assert picture.shape == recovery.rerendered.shape
    assert np.isfinite(picture).all()


def test_calibrate_finds_the_camera_of_points_in_arrays(corpus: Path, tmp_path: Path) -> None:
    scene = corpus / "plastic" / "scene.glb"
    photo = tmp_path / "photo.png"
    unrender.render(scene, width=160, height=120, spp=1, out=photo)
    camera = unrender.Camera(eye=(0.5, 1.5, 4), target=(0, 1, 0), fov_y_deg=40)
    metres = np.random.default_rng(1).uniform(-1, 1, (12, 3)) + [0, 1, 0]
    pixels = camera.project(metres, 160, 120)
    found = unrender.calibrate(photo, scene=scene, points=(pixels, metres))
    np.testing.assert_allclose(np.asarray(found.camera.eye), camera.eye, atol=0.02)
    assert found.camera.fov_y_deg == pytest.approx(40, abs=0.2)
    assert "12" in found.summary
    with pytest.raises(unrender.CalibrateError):
        unrender.calibrate(photo, scene=scene, points=(pixels[:3], metres[:3]))


def test_a_measured_brdf_is_fitted(tmp_path: Path) -> None:
    counts = (12, 6, 4)
    cells = np.full((3, *counts), 0.5 / np.pi) / (np.array([1.0, 1.15, 1.66]) / 1500)[:, None, None, None]
    table = tmp_path / "chalk.binary"
    table.write_bytes(np.array(counts, "<i4").tobytes() + cells.astype("<f8").tobytes())
    fitted = unrender.fit_brdf(table, model="ggx")
    assert fitted.chosen["hypothesis"] == "diffuse"
    np.testing.assert_allclose(fitted.chosen["rho_d"], 0.5, rtol=1e-4)
    assert "[groups.chalk]" in fitted.project
    unrender.fit_brdf(table, model="ggx", group="board", out=tmp_path / "board")
    assert (tmp_path / "board" / "fits.png").exists()
    table.write_bytes(table.read_bytes()[:100])
    with pytest.raises(unrender.FileError, match="cut short"):
        unrender.fit_brdf(table)
