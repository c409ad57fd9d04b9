"""Projects: the scene, the photograph, and what is known already."""

from __future__ import annotations

import copy
import json
import os
import tempfile
import tomllib
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _unrender
from ._control import StrPath
from .errors import FileError, RequestError
from .materials import jsonable
from .pictures import Picture, plain, png_file, read_picture
from .scene import Camera, Scene

__all__ = ["Project"]

IN_MEMORY = "(in memory)"

PATHS = (
    ("scene",),
    ("photo",),
    ("photo", "bracket"),
    ("mask",),
    ("response",),
    ("camera", "opencv"),
    ("camera", "colmap"),
    ("environment", "panorama"),
)
"""The keys of a project file that name files."""


class Project:
    """The input of a recovery, as in a project file; from a file, or built in memory.

    The keys are those of the project file (README, "The project file"); keys that are left out here
    are left out there.

    Attributes:
        document: The project file as a dict.
        folder: The folder of its relative paths.
    """

    document: dict[str, Any]
    folder: Path

    def __init__(
        self,
        scene: Scene | StrPath,
        photo: ArrayLike | StrPath | None = None,
        *,
        photos: Sequence[Mapping[str, Any]] | None = None,
        response: str | Mapping[str, float] | None = None,
        exposure: float | ArrayLike | str | None = None,
        anchor: Mapping[str, Any] | None = None,
        groups: Mapping[str, Mapping[str, Any]] | None = None,
        lights: Mapping[str, Mapping[str, Any]] | list[Mapping[str, Any]] | None = None,
        environment: Mapping[str, Any] | None = None,
        camera: Camera | str | None = None,
        mask: ArrayLike | StrPath | None = None,
        recover: Mapping[str, Any] | None = None,
        folder: StrPath = ".",
        **keys: Any,
    ) -> None:
        """A project in memory.

        Args:
            scene: A scene, or the path of its file.
            photo: The path of the photograph, if it is one; or an array (H, W, 3) of its codes: float32 (by
                default taken as linear), or uint8 or uint16 (by default taken as sRGB).
            photos: Several photographs instead of one: for each a mapping with the keys of ``[[photos]]`` in a
                project file: ``photo`` (a path), ``camera``, ``exposure``, ``lights_off`` and so on. Keys that
                an entry leaves out are those given here for all.
            response: How codes follow from linear values: "srgb", "linear", {"gamma": 2.2}, the path
                of a curve, or "auto".
            exposure: Scene radiance of a linear pixel value of one: a number, three, or "auto".
            anchor: The group that fixes an unknown scale: {"group": ..., "rho_d": [...]}.
            groups: The statements about groups: {"ceil": {"known": {"rho_d": [1, 1, 1]}}}.
            lights: {"lamp": {"unknown": True}}, or a list of lights that the model lacks.
            environment: Light from all around: {"color": [...]} or {"panorama": path}.
            camera: The photograph's camera, or the name of one of the scene.
            mask: The path of a mask, or an array (H, W): pixels that are zero or False are not
                used.
            recover: {"brdf": ..., "max_rung": ..., "thresholds": {...}}.
            folder: The folder of relative paths.
            keys: Further keys of the project file.
        """
        self.folder = Path(folder).absolute()
        self._read: tuple[Path, dict[str, Any]] | None = None
        self._scene = scene if isinstance(scene, Scene) else None
        is_file = photo is None or isinstance(photo, (str, os.PathLike))
        self._photo = None if is_file else np.asarray(photo)
        is_mask = mask is not None and not isinstance(mask, (str, os.PathLike))
        self._mask = np.asarray(mask) if is_mask else None
        document = {
            "scene": IN_MEMORY if isinstance(scene, Scene) else os.fspath(scene),
            "photo": photo_name(photo),
            "mask": os.fspath(mask) if isinstance(mask, (str, os.PathLike)) else None,
            "response": response,
            "exposure": exposure,
            "camera": camera.table() if isinstance(camera, Camera) else camera,
            "photos": None if photos is None else [photo_table(taken) for taken in photos],
            **keys,
            "anchor": anchor,
            "groups": groups,
            "lights": lights,
            "environment": environment,
            "recover": recover,
        }
        filled = {key: value for key, value in document.items() if value is not None}
        self.document = jsonable(filled)

    @classmethod
    def read(cls, path: StrPath) -> Project:
        """The project in a file."""
        file = Path(path)
        try:
            document = tomllib.loads(file.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise FileError(f"{file}: cannot be read: {error}", file) from error
        made = cls.__new__(cls)
        made.document, made.folder = document, file.parent.absolute()
        made._read = (file, copy.deepcopy(document))
        made._scene = made._photo = made._mask = None
        return made

    @classmethod
    def of(cls, value: Project | StrPath) -> Project:
        """A project, or the one in the file of this path."""
        return value if isinstance(value, Project) else cls.read(value)

    @property
    def path(self) -> Path | None:
        """The file from which it was read, if nothing was changed since."""
        if self._read is None or self._read[1] != self.document:
            return None
        return self._read[0]

    @property
    def text(self) -> str:
        """The text of the project file."""
        return _unrender.toml_text(json.dumps(self.document))

    @property
    def is_in_memory(self) -> bool:
        """Whether scene, photograph or mask are in memory."""
        return not (self._scene is None and self._photo is None and self._mask is None)

    def scene(self) -> Scene:
        """The scene, without the lights that the project adds."""
        return self._scene or Scene.read(self.folder / self.document["scene"])

    def save(self, path: StrPath) -> Path:
        """Writes the project file, with scene, environment, photograph and mask beside it if they are in
        memory; returns its path."""
        file = Path(path).absolute()
        file.parent.mkdir(parents=True, exist_ok=True)
        document = json.loads(json.dumps(self.document))
        self._name_files(document, file.parent)
        if self._scene is not None:
            self._save_scene(document, file)
        mask = None if self._mask is None else mask_picture(self._mask)
        if self._photo is not None:
            mask = self._save_photo(document, file, mask)
        if mask is not None:
            document["mask"] = f"{file.stem}_mask.exr"
            Picture(mask).save(file.with_name(document["mask"]))
        file.write_text(_unrender.toml_text(json.dumps(document)), encoding="utf-8")
        return file

    def _name_files(self, document: dict[str, Any], folder: Path) -> None:
        """Makes the relative paths of ``document`` start at ``folder``."""

        def moved(value: Any) -> Any:
            if isinstance(value, list):
                return [moved(item) for item in value]
            # Some of these keys may have another value than a path.
            if not isinstance(value, str) or not (self.folder / value).exists():
                return value
            return value if Path(value).is_absolute() else os.path.relpath(self.folder / value, folder)

        for of in [document, *document.get("photos", [])]:
            for *tables, key in PATHS:
                table: Any = of
                for name in tables:
                    table = table.get(name) if isinstance(table, dict) else None
                if isinstance(table, dict) and key in table:
                    table[key] = moved(table[key])

    def _save_scene(self, document: dict[str, Any], file: Path) -> None:
        scene = self.scene()._inner
        document["scene"] = f"{file.stem}.glb"
        scene.save(os.fspath(file.with_suffix(".glb")))
        around = scene.environment()
        # An environment of the project replaces it.
        if around is not None and "environment" not in document:
            panorama, turned = around
            name = f"{file.stem}_environment.exr"
            Picture(panorama).save(file.with_name(name))
            document["environment"] = {"panorama": name, "rotation_deg": turned}

    def _save_photo(
        self, document: dict[str, Any], file: Path, mask: NDArray[np.float32] | None
    ) -> NDArray[np.float32] | None:
        """Writes the photograph. Returns its mask: pixels that are not numbers are not used."""
        values, bits = codes(self._photo)
        if bits:
            document["photo"] = f"{file.stem}_photo.png"
            file.with_name(document["photo"]).write_bytes(png_file(np.asarray(self._photo)))
            return mask
        document["photo"] = f"{file.stem}_photo.exr"
        document.setdefault("response", "linear")
        bad = ~np.isfinite(values).all(axis=2, keepdims=True)
        Picture(np.where(bad, np.float32(0), values)).save(file.with_name(document["photo"]))
        if not np.any(bad):
            return mask
        if mask is None and "mask" in document:
            mask = code_values(file.parent / document["mask"])
        elif mask is None:
            mask = np.ones_like(values)
        if mask.shape != values.shape:
            raise RequestError(f"the mask is of the shape {mask.shape[:2]}, the photo {values.shape[:2]}")
        return plain(np.where(bad, np.float32(0), mask))

    @contextmanager
    def as_file(self) -> Generator[Path, None, None]:
        """The path of a file of the project: its own, or a temporary one."""
        if self.path is not None:
            yield self.path
            return
        with tempfile.TemporaryDirectory(prefix="unrender-") as folder:
            yield self.save(Path(folder) / "project.toml")

    def __repr__(self) -> str:
        return f"<Project {self.path or IN_MEMORY}: {', '.join(self.document)}>"


class ProjectParts:
    """A project in the form of the compiled half."""

    def __init__(self, project: Project) -> None:
        self.path = os.fspath(project.path or project.folder / "project.toml")
        self.text = project.text
        inner = project._scene
        self.scene = inner._inner if inner is not None else None
        self.photo: NDArray[np.float32] | None = None
        self.bits = 0
        if project._photo is not None:
            self.photo, self.bits = codes(project._photo)
        self.mask = None if project._mask is None else mask_picture(project._mask)
        for key, held in (("scene", self.scene), ("photo", self.photo)):
            name = project.document.get(key)
            if held is None and isinstance(name, str) and not (project.folder / name).is_file():
                file = project.folder / name
                raise FileError(f"{self.path}: {key}: there is no file {file}", self.path)


def photo_name(photo: Any) -> str | None:
    """The keys of a project's document about its single photograph."""
    if photo is None:
        return None
    return os.fspath(photo) if isinstance(photo, (str, os.PathLike)) else IN_MEMORY


def photo_table(taken: Mapping[str, Any]) -> dict[str, Any]:
    """An entry of the list of several photographs."""
    table = dict(taken)
    photo, camera = table.get("photo"), table.get("camera")
    if photo is not None and not isinstance(photo, (str, os.PathLike, Mapping)):
        raise RequestError("each of several photographs is a file: save it first, and give its path")
    if isinstance(photo, os.PathLike):
        table["photo"] = os.fspath(photo)
    if isinstance(camera, Camera):
        table["camera"] = camera.table()
    return table


def codes(photo: Any) -> tuple[NDArray[np.float32], int]:
    """The code values of a photograph, 0 to 1 for integers, and the bits of those."""
    array = np.asarray(photo)
    if array.ndim != 3 or array.shape[2] != 3:
        raise RequestError(f"the photo is an array (H, W, 3), not of the shape {array.shape}")
    if array.dtype == np.uint8:
        return plain(array.astype(np.float32) / np.float32(255)), 8
    if array.dtype == np.uint16:
        return plain(array.astype(np.float32) / np.float32(65535)), 16
    if array.dtype.kind not in "f":
        raise RequestError(
            f"the photo is an array of {array.dtype}, whose white is not known; codes of 0 to 255 "
            "are uint8, those of 0 to 65535 uint16 (photo.astype(np.uint8)), and other values floats"
        )
    return plain(array), 0


def code_values(path: Path) -> NDArray[np.float32]:
    """The values (H, W, 3) of a file, unchanged."""
    read = read_picture(path)
    return plain(read) if path.suffix.lower() in (".exr", ".hdr") else read.srgb()


def mask_picture(mask: NDArray[Any]) -> NDArray[np.float32]:
    """A mask (H, W) as a picture, white where pixels are used."""
    if mask.ndim != 2:
        raise RequestError(f"the mask is an array (H, W), not of the shape {mask.shape}")
    white = (mask != 0).astype(np.float32)
    return plain(np.repeat(white[:, :, None], 3, axis=2))
