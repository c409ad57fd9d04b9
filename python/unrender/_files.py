"""Writes data in memory to files, for commands that read files."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from . import _unrender
from ._control import StrPath
from .errors import RequestError
from .materials import Materials
from .pictures import Picture
from .project import IN_MEMORY, Project
from .recovery import Recovery
from .scene import Scene

AnyMaterials = Materials | Recovery | Mapping[str, Any] | StrPath
"""Materials in the forms that callers may pass."""


def is_path(value: object) -> bool:
    """Whether ``value`` is the path of a file or folder, not data in memory."""
    return isinstance(value, (str, os.PathLike))


@contextmanager
def temporary() -> Generator[Path, None, None]:
    """A temporary folder."""
    with tempfile.TemporaryDirectory(prefix="unrender-") as name:
        yield Path(name)


@contextmanager
def project_file(project: Project | StrPath | None) -> Generator[Path | None, None, None]:
    """The path of a project's file."""
    if isinstance(project, Project):
        with project.as_file() as path:
            yield path
    else:
        yield None if project is None else Path(project)


@contextmanager
def results_folder(recovery: Recovery | StrPath | None) -> Generator[Path | None, None, None]:
    """The folder of a recovery."""
    if isinstance(recovery, Recovery):
        with recovery.as_folder() as folder:
            yield folder
    else:
        yield None if recovery is None else Path(recovery)


def given_scene(
    scene: Scene | StrPath | None, light_units: str | None
) -> tuple[StrPath | None, _unrender.Scene | None]:
    """The argument of the command line for a scene, and the scene, if it is in memory."""
    if not isinstance(scene, Scene):
        return scene, None
    if light_units is not None:
        raise RequestError(
            "light_units are those of a file; give them to Scene.read, which has read this scene"
        )
    return IN_MEMORY, scene._inner


def materials_file(value: AnyMaterials | None, place: Path) -> Path | None:
    """The path of materials, which are written to ``place`` if they are in memory."""
    if value is None:
        return None
    if isinstance(value, (str, os.PathLike)):
        path = Path(value)
        return path / "materials.json" if path.is_dir() else path
    materials = value.materials if isinstance(value, Recovery) else Materials.of(value)
    materials.write(place)
    return place


def panorama_file(value: Any, place: Path) -> Any:
    """The path of a panorama, which is written to ``place`` if it is an array (H, W, 3)."""
    if value is None or is_path(value):
        return value
    picture = Picture(np.asarray(value))
    if picture.ndim != 3 or picture.shape[2] != 3:
        raise RequestError(f"a panorama is an array (H, W, 3), not of the shape {picture.shape}")
    picture.save(place)
    return place
