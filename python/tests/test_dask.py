"""Pictures and recoveries over the workers of Dask, to the bits of one process."""

from __future__ import annotations

import os
import signal
import warnings
from collections.abc import Generator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import unrender
import unrender.dask

distributed: Any = pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture(scope="module")
def cluster() -> Generator[Any, None, None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None
        ) as made:
            yield made


@pytest.fixture
def client(cluster: Any) -> Generator[Any, None, None]:
    with distributed.Client(cluster) as made:
        yield made


def test_a_picture_has_the_bits_of_one_process(client: Any, corpus: Path) -> None:
    folder = corpus / "isotropic"
    scene, truth = folder / "scene.glb", folder / "truth.json"
    here = unrender.render(scene, materials=truth, height=32, spp=10, seed=2)
    told: list[float] = []
    options: dict[str, Any] = {"materials": truth, "height": 32, "spp": 10, "seed": 2}
    there = unrender.dask.render(
        scene, client=client, progress=lambda done, message: told.append(done), **options
    )
    np.testing.assert_array_equal(there, here)
    assert told[-1] == 1.0
    in_memory = unrender.dask.render(
        unrender.Scene.read(scene).with_materials(truth), client=client, height=32, spp=10, seed=2
    )
    np.testing.assert_array_equal(in_memory, here)


def test_a_lost_worker_changes_no_bit(cluster: Any, client: Any, corpus: Path) -> None:
    scene = corpus / "isotropic" / "scene.glb"
    here = unrender.render(scene, height=48, spp=24)
    workers = [worker.pid for worker in cluster.workers.values()]
    killed: list[int] = []

    def kill(done: float, message: str) -> None:
        if not killed:
            killed.append(workers[0])
            os.kill(workers[0], signal.SIGKILL)

    there = unrender.dask.render(
        scene, client=client, height=48, spp=24, parts=12, progress=kill
    )
    assert killed
    np.testing.assert_array_equal(there, here)


def test_a_batch_hands_over_what_came_out(client: Any, corpus: Path, tmp_path: Path) -> None:
    projects = [corpus / name / "project.toml" for name in ("isotropic", "plastic")]
    batch = unrender.dask.batch(
        [*projects, tmp_path / "missing.toml"],
        client=client,
        out=tmp_path / "out",
        spp=2,
        no_refine=True,
    )
    results = {result.project: result for result in batch}
    assert set(results) == {*projects, tmp_path / "missing.toml"}
    failed = results[tmp_path / "missing.toml"].error
    assert isinstance(failed, unrender.FileError)
    here = unrender.recover(projects[0], spp=2, no_refine=True)
    found = results[projects[0]].materials
    assert found is not None
    assert dict(found) == dict(here.materials)
    table = batch.table()
    assert len(table) == 1 + sum(len(r.materials or {}) for r in results.values())
    assert batch.report(tmp_path / "batch.html").is_file()
