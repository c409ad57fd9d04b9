"""Fixtures of the tests: the repository's examples, and the command that Cargo built."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

Command = Callable[..., str]


@pytest.fixture(scope="session", autouse=True)
def _interrupts() -> None:
    """Enables Ctrl-C as in a terminal: background jobs of a shell and their children ignore it."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def corpus() -> Path:
    """Tiny scenes with photographs and true materials."""
    return ROOT / "examples" / "corpus"


@pytest.fixture(scope="session")
def fig8() -> Path:
    """The Cornell box with a brushed floor."""
    return ROOT / "examples" / "fig8"


@pytest.fixture(scope="session")
def command() -> Command:
    """Runs the command that Cargo built, not the one in the package; returns its output."""
    places = [ROOT / "target" / profile / "unrender" for profile in ("release", "debug")]
    built = [path for path in places if path.is_file()]
    named = os.environ.get("UNRENDER_BINARY")
    binary = Path(named) if named else (built[0] if built else None)
    if binary is None:
        pytest.fail("build the command first (cargo build --release), or name it in UNRENDER_BINARY")

    def run(*words: object) -> str:
        line = [str(binary), *map(str, words), "--quiet"]
        return subprocess.run(line, check=True, capture_output=True, text=True).stdout

    return run
