"""Shared code of all verbs: flags from keyword arguments, progress, cancellation and warnings."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

from . import _unrender
from .errors import UnrenderWarning, in_python

StrPath = str | os.PathLike[str]
"""A path of a file or folder."""

Samples = tuple[int, int] | range
"""The numbers from A to B, B not included."""


class ProgressCallback(Protocol):
    """Receives the progress of the work; it is called in the thread that started the work."""

    def __call__(self, done: float, message: str, /) -> object:
        """``done`` is the share of the work that is done, 0 to 1; ``message`` the last step."""


Progress = ProgressCallback | bool | None
"""A callback; or True for a bar on stderr; or None or False for none."""

CancelToken = _unrender.Token


class Bar:
    """A progress bar of `tqdm <https://tqdm.github.io>`_: ``recover(..., progress=Bar())``.

    Keyword arguments are those of ``tqdm.auto.tqdm``. Without tqdm, progress is on one plain line.
    """

    def __init__(self, **options: Any) -> None:
        self._options = options
        self._bar: Any = None

    def __call__(self, done: float, message: str, /) -> None:
        if self._bar is None:
            try:
                from tqdm.auto import tqdm
            except ImportError:
                end = "\n" if done >= 1.0 else "\r"
                print(f"{100 * done:5.1f} % {message}", end=end, file=sys.stderr, flush=True)
                return
            form = "{desc} {percentage:3.0f} %|{bar}| {elapsed} < {remaining}"
            options: dict[str, Any] = {"total": 1.0, "bar_format": form, **self._options}
            self._bar = tqdm(**options)
        self._bar.set_description_str(message, refresh=False)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Ends the bar's line."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None


class Control:
    """The connection to the work: token, threads, warnings, progress."""

    def __init__(
        self, progress: Progress, cancel: CancelToken | None, threads: int | None
    ) -> None:
        self.token = cancel
        self.threads = threads
        self.handler = self
        self._message = ""
        self.hear: Callable[[str], object] | None = None
        self._bar = Bar() if progress is True else None
        self._callback: Callable[[float, str], object] | None
        self._callback = self._bar if progress is True else (progress or None)

    def warning(self, text: str) -> None:
        """Raises a warning of the work as a Python warning, at the caller's line."""
        warn(text)

    def progress(self, message: str | None, done: float) -> None:
        """Passes on the progress of the work."""
        self._message = message or self._message
        if self._callback is not None:
            self._callback(done, self._message)

    def iteration(self, text: str) -> None:
        """Passes on the state of a recovery after an iteration, as JSON."""
        if self.hear is not None:
            self.hear(text)

    def close(self) -> None:
        """Ends the bar, if it was made here."""
        if self._bar is not None:
            self._bar.close()


@contextmanager
def control(
    progress: Progress, cancel: CancelToken | None, threads: int | None
) -> Generator[Control, None, None]:
    """The control of one piece of work."""
    made = Control(progress, cancel, threads)
    try:
        yield made
    finally:
        made.close()


def warn(text: str) -> None:
    """A warning at the line that called this package."""
    level = outside(os.path.dirname(__file__))
    warnings.warn(in_python(text), UnrenderWarning, stacklevel=level)


def outside(package: str) -> int:
    """The level of the first frame outside ``package``, as seen from :func:`warn`."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(package):
        frame, level = frame.f_back, level + 1
    return level


def words(
    command: str,
    positional: Sequence[StrPath] = (),
    flags: Mapping[str, object] | None = None,
    allow_outside: bool = False,
    input_memory: float | None = None,
    allow_missing: bool = False,
) -> list[str]:
    """The words of a command line.

    A flag is left out if it is None or False, has no value if it is True, and is repeated for every
    item of a list.
    """
    line = [command]
    limits = {
        "allow_outside": allow_outside,
        "allow_missing": allow_missing,
        "input_memory": input_memory,
    }
    every = {**(flags or {}), **limits}
    for name, value in every.items():
        flag = "--" + name.replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            line.append(flag)
            continue
        for item in value if isinstance(value, list) else [value]:
            line.append(f"{flag}={text(item)}")
    if positional:
        line.append("--")
        line.extend(os.fspath(path) for path in positional)
    return line


def text(value: object) -> str:
    """A value in the syntax of the command line."""
    if isinstance(value, range):
        return f"{value.start}..{value.stop}"
    if isinstance(value, tuple):
        first, last = value
        return f"{first}..{last}"
    if isinstance(value, os.PathLike):
        return str(Path(value))
    return str(value)
