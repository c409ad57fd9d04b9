"""Materials: the recovered or given parameters of every group, as in ``materials.json``."""

from __future__ import annotations

import copy
import json
import os
from collections.abc import Iterator, Mapping, MutableMapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._control import StrPath
from .errors import FileError
from .pictures import Picture, plain, read_picture

__all__ = ["Materials"]

GroupMaterial = dict[str, Any]
"""The keys of a group in materials.json: rho_d, rho_s (three numbers each), alpha_x, alpha_y,
theta_deg, texture, std, and further results of a recovery."""


class Materials(MutableMapping[str, GroupMaterial]):
    """The materials of a scene's groups: a mapping from the name of a group to its parameters.

    Keys of a group that are left out mean "as in the scene". ``rho_d`` and ``rho_s`` are
    reflectances, 0 to 1, three numbers or one; ``alpha_x`` and ``alpha_y`` roughnesses along and across the
    anisotropy direction; ``theta_deg`` that direction, degrees counter-clockwise from the surface's
    tangent seen from the front. Textures are float32 arrays (H, W, 3) of linear ``rho_d`` in glTF's
    orientation, in :attr:`textures`.

    Attributes:
        document: The whole of materials.json, as it is written.
        textures: Textures in memory, by the names of their groups; they override those of files.
        folder: The folder of the texture files that the document names.
    """

    def __init__(
        self,
        groups: Mapping[str, Mapping[str, Any]] | None = None,
        *,
        brdf: str | None = None,
        lights: Mapping[str, Mapping[str, Any]] | None = None,
        textures: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        """Materials of ``groups``; their lobe is ``brdf`` ("ward-gmd", "ward-1992", "ward-duer" or
        "ggx"), by default the scene's."""
        self.document: dict[str, Any] = {"version": 1}
        if brdf is not None:
            self.document["brdf"] = brdf
        entries = {name: jsonable(dict(entry)) for name, entry in (groups or {}).items()}
        self.document["groups"] = entries
        if lights:
            self.document["lights"] = {name: jsonable(dict(of)) for name, of in lights.items()}
        given = (textures or {}).items()
        self.textures: dict[str, NDArray[np.float32]] = {name: plain(t) for name, t in given}
        self.folder = Path()

    @classmethod
    def of(cls, value: Materials | Mapping[str, Any] | StrPath) -> Materials:
        """Materials from any accepted form: the path of a file, a dict like materials.json or like
        its groups, or materials."""
        if isinstance(value, Materials):
            return value
        if not isinstance(value, Mapping):
            return cls.read(value)
        made = cls()
        whole = "groups" in value
        document = dict(value) if whole else {"version": 1, "groups": dict(value)}
        made.document = jsonable(document)
        return made

    @classmethod
    def read(cls, path: StrPath) -> Materials:
        """The materials in a materials.json, or in the one of a folder of results."""
        file = Path(path)
        if file.is_dir():
            file = file / "materials.json"
        try:
            document = json.loads(file.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise FileError(f"{file}: cannot be read: {error}", file) from error
        if not isinstance(document, dict) or not isinstance(document.get("groups"), dict):
            raise FileError(f"{file}: has no groups; name a file like materials.json", file)
        made = cls()
        made.document, made.folder = document, file.parent
        return made

    @property
    def brdf(self) -> str | None:
        """The lobe of the parameters."""
        return self.document.get("brdf")

    @property
    def lights(self) -> dict[str, dict[str, Any]]:
        """The lights whose brightness was unknown, by name: ``intensity`` and ``std``."""
        found: dict[str, dict[str, Any]] = self.document.get("lights", {})
        return found

    def texture(self, group: str) -> NDArray[np.float32] | None:
        """The texture of a group's rho_d, linear (H, W, 3)."""
        if group in self.textures:
            return self.textures[group]
        name = self[group].get("texture")
        if not name:
            return None
        exr = (self.folder / name).with_suffix(".exr")
        return plain(read_picture(exr if exr.is_file() else self.folder / name))

    def write(self, path: StrPath) -> None:
        """Writes the materials as JSON, with their textures as .exr files beside it."""
        file = Path(path)
        document = with_triples(self.document)
        for number, name in enumerate(dict.fromkeys((*self, *self.textures))):
            texture = self.texture(name)
            if texture is not None:
                picture = file.with_name(f"{file.stem}_texture_{number}.exr")
                Picture(texture).save(picture)
                document["groups"].setdefault(name, {})["texture"] = picture.name
        file.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")

    def __getitem__(self, name: str) -> GroupMaterial:
        groups: dict[str, GroupMaterial] = self.document["groups"]
        return groups[name]

    def __setitem__(self, name: str, value: GroupMaterial) -> None:
        self.document["groups"][name] = jsonable(dict(value))

    def __delitem__(self, name: str) -> None:
        del self.document["groups"][name]
        self.textures.pop(name, None)

    def __iter__(self) -> Iterator[str]:
        return iter(self.document["groups"])

    def __len__(self) -> int:
        return len(self.document["groups"])

    def __repr__(self) -> str:
        return f"Materials({', '.join(self)})"

    def _repr_html_(self) -> str:
        from ._tables import materials_html

        return materials_html(self)


class Parts:
    """Materials in the form of the compiled half."""

    def __init__(self, materials: Materials) -> None:
        self.json = json.dumps(with_triples(materials.document))
        self.folder = os.fspath(materials.folder)
        self.textures = {name: plain(t) for name, t in materials.textures.items()}


def with_triples(document: dict[str, Any]) -> dict[str, Any]:
    """A copy of a document of materials; one number as a reflectance becomes three, a grey."""
    document = copy.deepcopy(document)
    for entry in document["groups"].values():
        for key in ("rho_d", "rho_s"):
            if isinstance(entry.get(key), (int, float)):
                entry[key] = [entry[key]] * 3
    return document


def jsonable(value: Any) -> Any:
    """``value`` with arrays as lists and NumPy's numbers as Python's."""
    if isinstance(value, Mapping):
        return {str(key): jsonable(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return jsonable(value.tolist())
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (list, tuple)):
        return [jsonable(item) for item in value]
    return value
