"""What can go wrong: every error names the file, what is wrong, and what to do about it."""

from __future__ import annotations

import re
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
    """Why unrender could not do what it was asked to.

    Attributes:
        file: The file that the error is about, if it is about one.
        problem: What is wrong.
        remedy: What to do about it, where that is known.
    """

    file: Path | None
    problem: str
    remedy: str | None

    def __init__(self, message: str, file: str | Path | None = None) -> None:
        message = in_python(message)
        super().__init__(message)
        self.file = Path(file) if file is not None else None
        text = message.removeprefix(f"{file}: ")
        # A message says what is wrong, and behind the last semicolon or colon what to do.
        cut = max(text.rfind("; "), text.rfind(": ") if self._colon else -1)
        self.problem = text[:cut] if cut >= 0 else text
        self.remedy = text[cut + 2 :] if cut >= 0 else None

    _colon = False

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self), (str(self), self.file))


class FileError(Error):
    """A file cannot be read or written, or says something impossible."""


class SceneError(Error):
    """The scene cannot be rendered."""

    _colon = True


class RequestError(Error, ValueError):
    """Something that was asked for does not fit the scene or the machine, or is no option."""


class CalibrateError(Error):
    """The measured points give no camera."""


class RecoverError(Error):
    """A recovery cannot start."""

    _colon = True


class Cancelled(Error):
    """The work was ended by its token before it had a result."""


class UnrenderWarning(UserWarning):
    """Doubtful but usable input, and what was assumed."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C was pressed: the work has ended, and what there was is here.

    Attributes:
        recovery: The best state of the recovery that was interrupted.
        picture: The picture that was interrupted, with the samples that it had.
    """

    recovery: Recovery | None
    picture: Any | None

    def __init__(self, *, recovery: Recovery | None = None, picture: Any | None = None) -> None:
        super().__init__("interrupted; what there was is in .recovery or .picture")
        self.recovery = recovery
        self.picture = picture
