"""Measures one recovery over the workers of Dask: the same bits, also with killed workers, and the cost.

    python python/tests/cluster.py [PROJECT.toml] [--runs 50] [--spp 2] [--pairs 3]

uses a room of 32 x 32 pixels if no project is given. It prints the SHA-256 of the results of one process, of
one, two and three workers, and of ``--runs`` runs with workers killed at random; then the time of one process
and of one, two and three workers, ``--pairs`` times in turn, with the requests and bytes of a recovery. Workers
are processes of this machine with as many threads as the one process.
"""

from __future__ import annotations

import argparse
import collections
import hashlib
import importlib
import json
import os
import random
import signal
import statistics
import threading
import time
import warnings
from pathlib import Path
from typing import Any

# A restarted worker is a copy of a process that has imported everything, and is ready at once.
os.environ.setdefault("DASK_DISTRIBUTED__WORKER__MULTIPROCESSING_METHOD", "forkserver")

import numpy as np
import pytest
import unrender
import unrender.dask
from unrender._workers import Workers

distributed: Any = pytest.importorskip("distributed")


def room() -> unrender.Project:
    """A glossy floor, a wall and a lamp, and their photograph of 32 x 32 pixels."""
    square, faces = np.array([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]]), [[0, 1, 2], [0, 2, 3]]
    wall = np.array([[-1, 0, -1], [1, 0, -1], [1, 2, -1], [-1, 2, -1]])
    meshes = [
        unrender.Mesh("floor", square, faces),
        unrender.Mesh("wall", wall, faces),
        unrender.Mesh("lamp", square * 0.3 + [0, 2, 0], [[0, 2, 1], [0, 3, 2]]),
    ]
    groups = {
        "floor": unrender.Group(rho_d=(0.4, 0.3, 0.2), rho_s=(0.2, 0.2, 0.2), alpha_x=0.2, alpha_y=0.2),
        "wall": unrender.Group(rho_d=(0.6, 0.6, 0.5)),
        "lamp": unrender.Group(rho_d=(0, 0, 0), emission=(9, 9, 9)),
    }
    camera = unrender.Camera(eye=(0.3, 1.3, 2.6), target=(0, 0.5, 0))
    scene = unrender.Scene(meshes, groups=groups, cameras=[camera])
    photo = unrender.render(scene, width=32, height=32, spp=64)
    return unrender.Project(scene, photo, response="linear", exposure=1.0)


def sha256(recovery: unrender.Recovery) -> str:
    """The digest of all values and the picture, without the time."""
    document = {**recovery.materials.document, "seconds": None}
    found = hashlib.sha256(json.dumps(document, sort_keys=True).encode())
    found.update(np.ascontiguousarray(recovery.rerendered).tobytes())
    if recovery.covariance is not None:
        found.update(recovery.covariance.matrix.tobytes())
    return found.hexdigest()


def cluster(workers: int) -> Any:
    """Worker processes on this machine."""
    utils: Any = importlib.import_module("distributed.utils")
    utils.get_mp_context().set_forkserver_preload(["distributed", "unrender.dask"])
    return distributed.LocalCluster(
        n_workers=workers, threads_per_worker=1, dashboard_address=None, silence_logs=50
    )


class Killer(threading.Thread):
    """Kills workers at random times; one time in five the last one, too."""

    def __init__(self, made: Any, seed: int, pause: float) -> None:
        super().__init__(daemon=True)
        self.over, self.killed = threading.Event(), 0
        self._made, self._random, self._pause = made, random.Random(seed), pause
        self.start()

    def run(self) -> None:
        while not self.over.wait(self._random.uniform(0.0, 2.0 * self._pause)):
            pids = [worker.pid for worker in list(self._made.workers.values()) if worker.pid]
            # Processes that are restarting are not workers yet.
            there = len(self._made.scheduler.workers)
            if pids and there > (0 if self._random.random() < 0.2 else 1):
                try:
                    os.kill(self._random.choice(pids), signal.SIGKILL)
                    self.killed += 1
                except ProcessLookupError:
                    pass

    def end(self) -> int:
        self.over.set()
        self.join()
        return self.killed


def same_bits(
    project: Path | unrender.Project,
    options: dict[str, Any],
    runs: int,
    pause: float,
    workers: list[int],
) -> None:
    """The digests of one process, of one, two and three workers, and with workers killed."""
    alone = sha256(unrender.recover(project, **options))
    print(f"one process:     {alone}")
    for count in workers:
        with cluster(count) as made, distributed.Client(made) as client:
            there = sha256(unrender.dask.recover(project, client=client, **options))
        print(f"{count} worker{'s' if count > 1 else ' '}:       {there}", "same" if there == alone else "OTHER", flush=True)
    found: collections.Counter[str] = collections.Counter()
    killed, without, begun = 0, 0, time.perf_counter()
    if not runs:
        return
    with cluster(2) as made, distributed.Client(made) as client:
        for run in range(runs):
            killer = Killer(made, run, pause)
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                found[sha256(unrender.dask.recover(project, client=client, **options))] += 1
            without += any("without its workers" in str(warning.message) for warning in told)
            killed += killer.end()
            seconds = time.perf_counter() - begun
            so_far = ", ".join(f"{number} x {name[:12]}" for name, number in found.items())
            print(f"{run + 1} runs, {killed} workers killed, {seconds:.0f} s: {so_far}", flush=True)
    print(f"{runs} runs, {killed} workers killed: {dict(found)}", "all the same" if set(found) <= {alone} else "OTHER")
    print(f"runs that continued without workers: {without}")


def cpu(pids: list[int]) -> float:
    """Processor seconds of these processes, which a busy machine changes less than clock time."""
    ticks = 0
    for pid in pids:
        fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def overhead(project: Path | unrender.Project, options: dict[str, Any], pairs: int, workers: list[int]) -> None:
    """The overhead of ``count`` workers against one process, in turn."""
    for count in workers:
        ratios, shares = [], []
        with cluster(count) as made, distributed.Client(made) as client:
            unrender.dask.recover(project, client=client, **options)
            pids = [os.getpid(), *(worker.pid for worker in made.workers.values())]
            for _ in range(pairs):
                begun, spent = time.perf_counter(), cpu(pids)
                unrender.recover(project, **options)
                alone, busy = time.perf_counter() - begun, cpu(pids) - spent
                counted: list[Workers] = []
                begun, spent = time.perf_counter(), cpu(pids)
                unrender.dask.recover(project, client=client, counted=counted.append, **options)
                there, worked = time.perf_counter() - begun, cpu(pids) - spent
                ratios.append(there / alone - 1.0)
                shares.append(worked / busy - 1.0)
                asked = counted[0]
                print(
                    f"clock: one process {alone:.2f} s, {count} worker(s) {there:.2f} s, {ratios[-1]:+.1%}; "
                    f"processor: {busy:.2f} s, {worked:.2f} s, {shares[-1]:+.1%}; {asked.requests} requests, "
                    f"{asked.sent / 1e6:.1f} MB sent, {asked.received / 1e6:.1f} MB received",
                    flush=True,
                )
        medians = f"clock {statistics.median(ratios):+.1%}, processor {statistics.median(shares):+.1%}"
        print(f"{count} worker(s), medians: {medians}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("project", nargs="?", type=Path)
    parser.add_argument("--runs", type=int, default=50)
    parser.add_argument("--workers", type=int, nargs="*", default=[1, 2, 3])
    parser.add_argument("--spp", type=int, default=2)
    parser.add_argument("--pause", type=float, default=1.0, help="seconds between two kills, on the mean")
    parser.add_argument("--pairs", type=int, default=3)
    parser.add_argument("--effort", help="how much work a recovery takes, as of unrender recover")
    parser.add_argument("--no-refine", action="store_true")
    parser.add_argument("--only", choices=["bits", "overhead"])
    words = parser.parse_args()
    warnings.simplefilter("ignore", unrender.UnrenderWarning)
    project = words.project or room()
    options: dict[str, Any] = {"spp": words.spp, "no_refine": words.no_refine}
    if words.effort:
        options["effort"] = words.effort
    if words.only != "overhead":
        same_bits(project, options, words.runs, words.pause, words.workers)
    if words.only != "bits":
        overhead(project, options, words.pairs, words.workers)


if __name__ == "__main__":
    main()
