"""The errors: each names the file, the problem, and the remedy."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .recovery import Recovery

__all__ = [
    "CalibrateError",
    "Cancelled",
    "Error",
    "FileError",
    "Interrupted",
    "RecoverError",
    "RequestError",
    "SceneError",
    "UnrenderWarning",
]


def in_python(text: str) -> str:
    """The message ``text`` with flags of the command line as keyword arguments: ``--max-rung``
    becomes ``max_rung``."""
    return re.sub(r"--([a-z][a-z-]*)", lambda flag: flag[1].replace("-", "_"), text)


class Error(Exception):
    """An error of unrender.

    Attributes:
        file: The file of the error, if there is one.
        problem: What is wrong.
        remedy: What to do about it, if that is known.
    """

    file: Path | None
    problem: str
    remedy: str | None

    def __init__(self, message: str, file: str | Path | None = None) -> None:
        message = in_python(message)
        super().__init__(message)
        self.file = Path(file) if file is not None else None
        text = message.removeprefix(f"{file}: ")
        # A message states the problem, and after the last semicolon or colon the remedy.
        cut = max(text.rfind("; "), text.rfind(": ") if self._colon else -1)
        self.problem = text[:cut] if cut >= 0 else text
        self.remedy = text[cut + 2 :] if cut >= 0 else None

    _colon = False

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (str(self), self.file))


class FileError(Error):
    """A file cannot be read or written, or is not valid."""


class SceneError(Error):
    """The scene cannot be rendered."""

    _colon = True


class RequestError(Error, ValueError):
    """A request does not fit the scene or the machine, or is not a valid option."""


class CalibrateError(Error):
    """The measured points do not determine a camera."""


class RecoverError(Error):
    """A recovery cannot start."""

    _colon = True


class Cancelled(Error):
    """The token ended the work before it had a result."""


class UnrenderWarning(UserWarning):
    """A warning of doubtful but usable input, with the assumption that was made."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C was pressed: the work has ended, with its results so far.

    Attributes:
        recovery: The best state of the recovery that was interrupted.
        picture: The interrupted picture, with its samples so far.
    """

    recovery: Recovery | None
    picture: Any | None

    def __init__(self, *, recovery: Recovery | None = None, picture: Any | None = None) -> None:
        super().__init__("interrupted; the results so far are in .recovery or .picture")
        self.recovery = recovery
        self.picture = picture

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), recovery=self.recovery, picture=self.picture), ()
