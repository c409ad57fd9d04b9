"""Pictures and recoveries over the workers of Dask equal those of one process to the bit."""

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
from cluster import cluster as made
from cluster import room, sha256

distributed: Any = pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings("ignore")

# All steps of a recovery, but few paths.
OPTIONS: dict[str, Any] = {"spp": 2, "effort": "draft", "no_refine": True}


@pytest.fixture(scope="module")
def project() -> unrender.Project:
    """A small room."""
    return room()


@pytest.fixture(scope="module")
def alone(project: unrender.Project) -> str:
    """The recovery by one process."""
    return sha256(unrender.recover(project, **OPTIONS))


@pytest.fixture(scope="module")
def cluster() -> Generator[Any, None, None]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None
        ) as started:
            yield started


@pytest.fixture
def client(cluster: Any) -> Generator[Any, None, None]:
    with distributed.Client(cluster) as started:
        yield started


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


def test_a_recovery_has_the_bits_of_one_process(client: Any, corpus: Path) -> None:
    project = corpus / "isotropic" / "project.toml"
    here = unrender.recover(project, **OPTIONS)
    counted: list[Any] = []
    there = unrender.dask.recover(project, client=client, counted=counted.append, **OPTIONS)
    assert sha256(there) == sha256(here)
    assert counted[0].requests > 20
    # The scene goes to each worker once, and the cache when it changes.
    assert counted[0].sent < 100 * (corpus / "isotropic" / "scene.glb").stat().st_size


def test_several_photographs_have_the_bits_of_one_process(client: Any, corpus: Path) -> None:
    folder = corpus / "isotropic"
    document = unrender.Project.read(folder / "project.toml").document
    photos = [
        {"photo": folder / "photo.png", "exposure": document["exposure"]},
        {"photo": folder / "photo.png", "exposure": "auto"},
    ]
    project = unrender.Project(
        folder / "scene.glb", photos=photos, camera="camera", response="srgb", recover=document["recover"]
    )
    options = {**OPTIONS, "max_rung": "diffuse"}
    here = unrender.recover(project, **options)
    there = unrender.dask.recover(project, client=client, **options)
    assert sha256(there) == sha256(here)
    np.testing.assert_array_equal(there.of(1).rerendered, here.of(1).rerendered)


def test_a_recovery_outlives_its_workers(
    cluster: Any, client: Any, project: unrender.Project, alone: str
) -> None:
    killed: list[int] = []

    def kill(done: float, message: str) -> None:
        workers = [worker.pid for worker in cluster.workers.values() if worker.pid]
        if "iteration" in message and workers and len(killed) < 2:
            killed.append(workers[0])
            os.kill(workers[0], signal.SIGKILL)

    there = unrender.dask.recover(project, client=client, progress=kill, **OPTIONS)
    assert killed
    assert sha256(there) == alone


def test_a_recovery_goes_on_by_itself_when_its_cluster_is_gone(
    project: unrender.Project, alone: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("unrender._workers.PATIENCE", 0.5)
    with made(1) as cluster, distributed.Client(cluster) as client:

        def heard(done: float, message: str) -> None:
            if cluster.workers:
                cluster.scale(0)

        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            there = unrender.dask.recover(project, client=client, progress=heard, **OPTIONS)
    assert sha256(there) == alone
    assert any("continues without its workers" in str(warning.message) for warning in told)


def test_a_worker_with_another_build_is_refused(
    client: Any, project: unrender.Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("unrender._workers.build", lambda: "another")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        unrender.dask.recover(project, client=client, **OPTIONS)
    assert any("install the same wheel" in str(warning.message) for warning in told)


def test_projects_and_materials_in_memory_go_to_the_workers(client: Any, project: unrender.Project) -> None:
    options: dict[str, Any] = {"materials": {"wall": {"rho_d": [0.1, 0.2, 0.3]}}, "spp": 6}
    here = unrender.render(project=project, **options)
    there = unrender.dask.render(project=project, client=client, **options)
    np.testing.assert_array_equal(there, here)
    settings = {**OPTIONS, "max_rung": "diffuse"}
    batch = unrender.dask.batch([project, project], client=client, **settings)
    results = batch.wait()
    assert sorted(result.number for result in results) == [1, 2]
    alone = unrender.recover(project, **settings)
    for result in results:
        assert result.error is None
        assert dict(result.materials or {}) == dict(alone.materials)
    assert set(batch.table().index.get_level_values("project")) == {"(in memory) 1", "(in memory) 2"}


def test_a_batch_hands_over_what_came_out(client: Any, corpus: Path, tmp_path: Path) -> None:
    projects = [corpus / name / "project.toml" for name in ("isotropic", "plastic")]
    options = {**OPTIONS, "max_rung": "diffuse"}
    batch = unrender.dask.batch(
        [*projects, tmp_path / "missing.toml"],
        client=client,
        out=tmp_path / "out",
        **options,
    )
    results = {result.project: result for result in batch}
    assert set(results) == {*projects, tmp_path / "missing.toml"}
    failed = results[tmp_path / "missing.toml"].error
    assert isinstance(failed, unrender.FileError)
    here = unrender.recover(projects[0], **options)
    found = results[projects[0]].materials
    assert found is not None
    assert dict(found) == dict(here.materials)
    table = batch.table()
    assert len(table) == 1 + sum(len(r.materials or {}) for r in results.values())
    assert batch.report(tmp_path / "batch.html").is_file()
