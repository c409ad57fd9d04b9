"""Progress, cancellation, Ctrl-C, threads of Python, errors and warnings."""

from __future__ import annotations

import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import unrender

INTERRUPTED = """
import signal, sys, threading, time
import unrender
project, begun = sys.argv[1], []
def heard(done, message):
    if "iteration" in message and not begun:
        begun.append(time.monotonic())
        signal.raise_signal(signal.SIGINT)
try:
    unrender.recover(project, progress=heard)
except unrender.Interrupted as interrupted:
    seconds = time.monotonic() - begun[0]
    assert seconds < 1.0, seconds
    recovery = interrupted.recovery
    assert recovery is not None and recovery.interrupted
    assert "interrupted" in recovery.termination, recovery.termination
    assert all(entry["rho_d"] is not None for entry in recovery.materials.values())
    print(f"{seconds:.2f}")
"""


@pytest.mark.parametrize("project", ["examples/corpus/textured/project.toml", "examples/fig8/fig8.toml"])
def test_ctrl_c_ends_within_a_second_and_leaves_the_best_state(project: str) -> None:
    root = Path(__file__).resolve().parents[2]
    line = [sys.executable, "-W", "ignore", "-c", INTERRUPTED, str(root / project)]
    ended = subprocess.run(line, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.strip(), "it was not interrupted"


def test_ctrl_c_ends_a_rendering_with_its_samples(fig8: Path) -> None:
    timer = threading.Timer(1.0, signal.raise_signal, [signal.SIGINT])
    timer.start()
    begun = time.monotonic()
    with pytest.raises(unrender.Interrupted) as raised:
        unrender.render(fig8 / "scene.glb", width=32, height=24, spp=1_000_000_000)
    assert time.monotonic() - begun < 2.5
    assert raised.value.picture is not None
    assert raised.value.picture.shape == (24, 32, 3)
    assert isinstance(raised.value, KeyboardInterrupt)


@pytest.mark.filterwarnings("ignore::unrender.UnrenderWarning")
def test_a_token_ends_a_recovery_with_its_best_state(corpus: Path, tmp_path: Path) -> None:
    token = unrender.CancelToken()
    assert not token.cancelled

    def heard(done: float, message: str) -> None:
        if "iteration" in message:
            token.cancel()

    project = corpus / "textured" / "project.toml"
    recovery = unrender.recover(project, out=tmp_path / "out", progress=heard, cancel=token)
    assert token.cancelled
    assert recovery.interrupted
    assert "interrupted" in recovery.termination
    assert (tmp_path / "out" / "report.html").is_file()
    assert unrender.Recovery.read(tmp_path / "out").interrupted


def test_progress_is_told_on_the_callers_thread(fig8: Path) -> None:
    heard: list[tuple[float, int]] = []
    unrender.render(
        fig8 / "scene.glb",
        height=32,
        spp=64,
        progress=lambda done, message: heard.append((done, threading.get_ident())),
    )
    assert heard
    assert [done for done, _ in heard] == sorted(done for done, _ in heard)
    assert {thread for _, thread in heard} == {threading.get_ident()}


def test_a_bar_of_tqdm_is_one_line(fig8: Path, capsys: pytest.CaptureFixture[str]) -> None:
    unrender.render(fig8 / "scene.glb", height=32, spp=64, progress=True)
    assert "%" in capsys.readouterr().err


def test_what_a_callback_raises_comes_out(fig8: Path) -> None:
    def heard(done: float, message: str) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        unrender.render(fig8 / "scene.glb", height=64, spp=4096, progress=heard)


def test_other_threads_of_python_go_on(fig8: Path) -> None:
    counted, stop = [0], threading.Event()

    def count() -> None:
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    begun = time.monotonic()
    unrender.render(fig8 / "scene.glb", height=64, spp=64, threads=1)
    seconds = time.monotonic() - begun
    stop.set()
    thread.join()
    assert counted[0] > 20 * seconds, (counted, seconds)


def test_two_threads_render_at_once(fig8: Path) -> None:
    pictures: dict[int, unrender.Picture] = {}

    def one(seed: int) -> None:
        pictures[seed] = unrender.render(fig8 / "scene.glb", height=24, spp=2, seed=seed)

    threads = [threading.Thread(target=one, args=[seed]) for seed in (1, 2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for seed, picture in pictures.items():
        again = unrender.render(fig8 / "scene.glb", height=24, spp=2, seed=seed)
        np.testing.assert_array_equal(picture, again)


def test_errors_name_file_problem_and_remedy(tmp_path: Path) -> None:
    missing = tmp_path / "missing.glb"
    with pytest.raises(unrender.FileError) as raised:
        unrender.render(missing)
    assert raised.value.file == missing
    assert isinstance(raised.value, unrender.Error)
    assert "does not exist" in raised.value.problem
    odd = tmp_path / "scene.xyz"
    odd.write_text("")
    with pytest.raises(unrender.FileError) as raised:
        unrender.render(odd)
    assert raised.value.remedy is not None
    assert raised.value.remedy.startswith("scenes are read from .glb")
    again = pickle.loads(pickle.dumps(raised.value))
    assert (str(again), again.file) == (str(raised.value), odd)


def test_options_that_cannot_be_meant_are_request_errors(fig8: Path) -> None:
    wrong: list[dict[str, Any]] = [{"spp": 0}, {"noise": -1.0}, {"samples": (4, 4)}, {"width": 0}]
    for options in wrong:
        with pytest.raises(unrender.RequestError) as raised:
            unrender.render(fig8 / "scene.glb", **options)
        assert "--" not in str(raised.value)
    with pytest.raises(ValueError, match="no group"):
        unrender.Scene.read(fig8 / "scene.glb").texture("nobody")
    with pytest.raises(unrender.RequestError, match="either a scene or a project"):
        unrender.render()
    with pytest.raises(unrender.RequestError, match=r"\(H, W, 3\)"):
        photo = np.zeros((4, 4), np.float32)
        unrender.recover(unrender.Project(fig8 / "scene.glb", photo))


def test_doubts_are_python_warnings_at_the_callers_line(fig8: Path) -> None:
    with pytest.warns(unrender.UnrenderWarning, match='no group "nobody"') as told:
        materials = {"nobody": {"rho_d": [0, 0, 0]}}
        unrender.render(fig8 / "scene.glb", materials=materials, height=8, spp=1)
    assert told[0].filename == __file__


@pytest.mark.filterwarnings("ignore::unrender.UnrenderWarning")
def test_materials_are_heard_after_iterations(corpus: Path) -> None:
    project = corpus / "isotropic" / "project.toml"
    heard: list[unrender.Materials] = []
    here = threading.get_ident()
    threads: set[int] = set()

    def hear(materials: unrender.Materials) -> None:
        heard.append(materials)
        threads.add(threading.get_ident())

    recovery = unrender.recover(
        project, spp=2, effort="draft", no_refine=True, on_iteration=hear
    )
    assert heard and threads == {here}
    assert all(set(materials) == set(recovery.materials) for materials in heard)
    with pytest.raises(ZeroDivisionError):
        unrender.recover(
            project, spp=2, effort="draft", no_refine=True, on_iteration=lambda materials: 1 // 0
        )
