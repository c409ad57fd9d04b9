"""Recoveries go to other processes and are copied with all that they hold."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
import re
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import unrender
from test_objects import room

pytestmark = pytest.mark.filterwarnings("ignore::unrender.UnrenderWarning")

QUICK: dict[str, Any] = {"effort": "draft", "spp": 2, "max_rung": "diffuse"}


def recovered(seed: int, **options: Any) -> unrender.Recovery:
    """A recovery of a project in memory."""
    scene = room()
    photo = unrender.render(scene, width=24, height=20, spp=64)
    project = unrender.Project(scene, photo, exposure=1.0)
    return unrender.recover(project, seed=seed, **{**QUICK, **options})


def files(recovery: unrender.Recovery, folder: Path) -> dict[str, bytes]:
    """The contents of all files that a recovery writes, without the memory of the process that writes them."""
    recovery.save(folder)
    paths = (path for path in folder.rglob("*") if path.is_file() and path.name != "manifest.json")
    written = {str(path.relative_to(folder)): path.read_bytes() for path in paths}
    written["run.json"] = re.sub(rb'"peak_memory_bytes": \d+', b"", written["run.json"])
    written["report.html"] = re.sub(
        rb'"\d+"( data-key="/peak_memory_bytes" data-scale="[^"]*">)\d+', rb"\1", written["report.html"]
    )
    return written


def is_same(there: unrender.Recovery, here: unrender.Recovery, folder: Path) -> None:
    """Asserts that two recoveries hold the same and write the same files."""
    assert dict(there.materials) == dict(here.materials)
    assert (there.summary, there.termination, there.warnings) == (here.summary, here.termination, here.warnings)
    assert there.interrupted == here.interrupted
    for photograph in range(here.photographs):
        one, other = there.of(photograph), here.of(photograph)
        assert one.camera == other.camera
        for name in ("rerendered", "photo", "noise", "group_map", "status_map"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert (there.covariance is None) == (here.covariance is None)
    if there.covariance is not None and here.covariance is not None:
        assert there.covariance.names == here.covariance.names
        np.testing.assert_array_equal(there.covariance.matrix, here.covariance.matrix)
    written = files(here, folder / "here")
    assert len(written) > 10
    assert files(there, folder / "there") == written


def test_a_recovery_is_copied_and_sent_with_all_that_it_holds(tmp_path: Path) -> None:
    here = recovered(0)
    assert here.rerendered.shape == (20, 24, 3)
    is_same(pickle.loads(pickle.dumps(here)), here, tmp_path / "pickle")
    is_same(copy.deepcopy(here), here, tmp_path / "copy")
    # What is read from files is sent as before, and bytes that are cut short are refused.
    read = unrender.Recovery.read(tmp_path / "copy" / "here")
    assert dict(pickle.loads(pickle.dumps(read)).materials) == dict(here.materials)
    state = here.__getstate__()
    with pytest.raises(unrender.RequestError, match="not the bytes of a recovery"):
        copy.copy(here).__setstate__({**state, "_inner": state["_inner"][:100]})


def test_a_pool_of_processes_returns_recoveries(tmp_path: Path) -> None:
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context) as pool:
        there, other = pool.map(recovered, [0, 1])
    here = recovered(0)
    assert there.materials["floor"]["rho_d"] == here.materials["floor"]["rho_d"]
    np.testing.assert_array_equal(there.rerendered, here.rerendered)
    assert (other.rerendered != here.rerendered).any()
    assert there.save(tmp_path / "there") == tmp_path / "there"
    restaged = unrender.restage(recovered=there, remove=["wall"], width=16, height=12, spp=1)
    assert "synthetic" in restaged.pictures


def test_what_is_in_a_project_is_sent_too(tmp_path: Path) -> None:
    """Several photographs, a measured response, unknown vignetting, a known dielectric, an added light."""
    scene = room()
    scene.save(tmp_path / "scene.glb")
    for name in ("a.png", "b.png"):
        unrender.Picture(unrender.render(scene, width=16, height=12, spp=64) / 8).save(tmp_path / name)
    (tmp_path / "curve.csv").write_text("code,linear\n0,0\n0.25,0.05\n0.5,0.21\n0.75,0.52\n1,1\n")
    (tmp_path / "room.toml").write_text(
        'scene = "scene.glb"\nresponse = "curve.csv"\nexposure = 8.0\nvignetting = "auto"\n'
        '[recover]\nbrdf = "principled"\n'
        '[environment]\ncolor = [0.2, 0.4, 0.8]\n'
        '[[photos]]\nphoto = "a.png"\n[[photos]]\nphoto = "b.png"\nresponse = { gamma = 2.2 }\n'
        '[groups.wall]\nknown = { rho_d = 0.7, reflectance = "dielectric", ior = 1.5, alpha_x = 0.3 }\n'
        '[[lights]]\nname = "new"\nadd = "point"\nposition = [0, 1.5, 1]\nstrength = 0.01\n'
    )
    here = unrender.recover(tmp_path / "room.toml", force=True, **QUICK)
    assert here.photographs == 2
    is_same(pickle.loads(pickle.dumps(here)), here, tmp_path)


def test_an_interrupted_recovery_is_sent(tmp_path: Path) -> None:
    token = unrender.CancelToken()

    def heard(done: float, message: str) -> None:
        if "iteration" in message:
            token.cancel()

    here = recovered(0, progress=heard, cancel=token)
    assert here.interrupted
    is_same(pickle.loads(pickle.dumps(here)), here, tmp_path)
    told = pickle.loads(pickle.dumps(unrender.Interrupted(recovery=here)))
    assert dict(told.recovery.materials) == dict(here.materials)
    assert str(told) == str(unrender.Interrupted())
    sketch = unrender.recovery._sketched({"groups": {"wall": {"rho_d": [0.5, 0.5, 0.5]}}})
    assert dict(pickle.loads(pickle.dumps(sketch)).materials) == dict(sketch.materials)
