"""The package as a whole: types, stubs, the command, memory, notebooks."""

from __future__ import annotations

import gc
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

import nbformat
import numpy as np
import pytest
import unrender
from conftest import ROOT
from nbclient import NotebookClient

PYTHON = Path(__file__).resolve().parents[1]
SCRIPTS = Path(sysconfig.get_path("scripts"))


def run(*line: object, cwd: Path = PYTHON) -> str:
    ended = subprocess.run(
        [str(word) for word in line], cwd=cwd, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout


def test_mypy_accepts_package_and_tests() -> None:
    run(sys.executable, "-m", "mypy", "--strict", "unrender", "tests")


def test_pyright_accepts_the_package() -> None:
    run(sys.executable, "-m", "pyright", "--pythonpath", sys.executable)


def test_stubs_are_those_of_the_compiled_module(tmp_path: Path) -> None:
    run(sys.executable, "-m", "mypy.stubtest", "unrender._unrender", cwd=tmp_path)


def test_the_wheel_has_types_and_the_command() -> None:
    package = Path(unrender.__file__).parent
    assert (package / "py.typed").is_file()
    assert (package / "_unrender.pyi").is_file()
    assert run(SCRIPTS / "unrender", "--version").startswith("unrender ")
    usage = subprocess.run([SCRIPTS / "unrender", "render"], capture_output=True, check=False)
    assert usage.returncode == 2


def test_everything_public_says_what_it_is() -> None:
    for name in unrender.__all__:
        assert (getattr(unrender, name).__doc__ or "").strip(), name


def resident() -> float:
    """The memory of this process, MiB."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    return 0.0


@pytest.mark.skipif(sys.platform != "linux", reason="memory is read from /proc")
@pytest.mark.filterwarnings("ignore::unrender.UnrenderWarning")
def test_memory_does_not_grow_over_fifty_recoveries() -> None:
    square, faces = np.array([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]]), [[0, 1, 2], [0, 2, 3]]
    meshes = [
        unrender.Mesh("floor", square, faces),
        unrender.Mesh("lamp", square * 0.3 + [0, 2, 0], [[0, 2, 1], [0, 3, 2]]),
    ]
    groups = {"lamp": unrender.Group(rho_d=(0, 0, 0), emission=(9, 9, 9))}
    camera = unrender.Camera(eye=(0, 1.5, 2.5), target=(0, 0, 0))
    scene = unrender.Scene(meshes, groups=groups, cameras=[camera])
    photo = unrender.render(scene, width=32, height=32, spp=32)
    project = unrender.Project(scene, photo, response="linear", exposure=1.0)
    after: list[float] = []
    for _ in range(50):
        recovery = unrender.recover(project, spp=1, max_rung="diffuse", no_refine=True)
        assert recovery.rerendered.shape == (32, 32, 3)
        del recovery
        gc.collect()
        after.append(resident())
    # The memory of allocators settles in the first runs; a leak of a picture's size would add 12 kB
    # per run.
    assert np.median(after[-10:]) - np.median(after[20:30]) < 0.25, after


@pytest.mark.parametrize("notebook", sorted((ROOT / "examples" / "notebooks").glob("*.ipynb")))
def test_notebooks_run(notebook: Path) -> None:
    book: Any = nbformat.read(notebook, as_version=4)  # type: ignore[no-untyped-call]
    client = NotebookClient(book, timeout=600, resources={"metadata": {"path": notebook.parent}})
    client.execute()
    outputs = [output for cell in book.cells for output in cell.get("outputs", [])]
    assert any("image/png" in output.get("data", {}) for output in outputs)
