"""Scenes: meshes in groups that share a material, lights and cameras; from files or from arrays.

Frames and units are those of glTF: metres, y up, right-handed; faces are counter-clockwise seen from
their front; radiance in W sr^-1 m^-2 per channel of linear RGB.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _unrender
from ._control import StrPath, warn
from .materials import Materials, Parts, jsonable
from .pictures import plain

__all__ = ["Camera", "Group", "Light", "Mesh", "Scene"]

Triple = Sequence[float] | NDArray[Any]
"""Three numbers: a point or direction (x, y, z), or a colour (red, green, blue)."""


@dataclass(frozen=True)
class Camera:
    """A perspective camera.

    Attributes:
        eye: Its position, metres.
        target: A point at which it looks, metres.
        up: A direction that is upwards in the picture.
        fov_y_deg: The full vertical field of view, degrees.
        name: Its name in the scene.
        principal_point: From the picture's centre to the right and downwards, in heights of the
            picture.
        k1: Radial distortion, the coefficient of the squared distance from the axis.
        k2: The coefficient of its fourth power.
        k3: The coefficient of its sixth power.
        p1: Tangential distortion, of a lens tilted about the horizontal axis.
        p2: Tangential distortion, of a lens tilted about the vertical axis.
        fx_over_fy: The focal length in pixels across over that in pixels down.
        aspect: Width over height, if it is stated.
        world_from_camera: The exact pose that a file states, 12 numbers, column by column; eye,
            target and up give the same except for rounding.
    """

    eye: Triple
    target: Triple
    up: Triple = (0.0, 1.0, 0.0)
    fov_y_deg: float = 45.0
    name: str = "camera"
    principal_point: Sequence[float] = (0.0, 0.0)
    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    fx_over_fy: float = 1.0
    aspect: float | None = None
    world_from_camera: tuple[float, ...] | None = field(default=None, repr=False)

    def table(self) -> dict[str, Any]:
        """The camera as the table ``[camera]`` of a project file."""
        table = jsonable(
            {
                "eye": list(self.eye),
                "target": list(self.target),
                "up": list(self.up),
                "fov_y_deg": self.fov_y_deg,
                "principal_point": list(self.principal_point),
                "k1": self.k1,
                "k2": self.k2,
                "k3": self.k3,
                "p1": self.p1,
                "p2": self.p2,
                "fx_over_fy": self.fx_over_fy,
            }
        )
        if self.fx_over_fy == 1.0:
            del table["fx_over_fy"]
        return {key: value for key, value in table.items() if value not in (0.0, [0.0, 0.0])}

    def project(
        self, points: ArrayLike, width: int, height: int
    ) -> NDArray[np.float64]:
        """The pixels of points (N, 3), metres, in a picture of ``width`` x ``height`` pixels: (N,
        2), from its top left corner to the right and downwards; NaN behind the camera."""
        at = np.atleast_2d(np.asarray(points, dtype=float)) - np.asarray(self.eye, dtype=float)
        back = np.asarray(self.eye, dtype=float) - np.asarray(self.target, dtype=float)
        back /= np.linalg.norm(back)
        right = np.cross(np.asarray(self.up, dtype=float), back)
        right /= np.linalg.norm(right)
        depth = -at @ back
        depth = np.where(depth > 0.0, depth, np.nan)
        plane = np.stack([at @ right, -(at @ np.cross(back, right))], axis=1) / depth[:, None]
        r2 = np.sum(plane**2, axis=1, keepdims=True)
        xy = plane[:, :1] * plane[:, 1:]
        tilt = np.array([[self.p2, self.p1]]) * (r2 + 2.0 * plane**2)
        tilt += 2.0 * np.array([[self.p1, self.p2]]) * xy
        plane = plane * (1.0 + self.k1 * r2 + self.k2 * r2**2 + self.k3 * r2**3) + tilt
        plane = plane * np.array([[self.fx_over_fy, 1.0]])
        focal = 0.5 * height / np.tan(np.radians(0.5 * self.fov_y_deg))
        centre = np.array([0.5 * width, 0.5 * height]) + height * np.asarray(self.principal_point)
        return np.asarray(plane * focal + centre)


@dataclass(frozen=True)
class Mesh:
    """One object of a scene.

    Attributes:
        group: The name of its group.
        vertices: Positions in world space, metres, (N, 3).
        faces: Vertex numbers, counter-clockwise seen from the front, (M, 3).
        uvs: Texture coordinates (N, 2), (0, 0) at the top left of the texture; or None.
        normals: Shading normals (N, 3); or None for flat faces.
        name: The object's name; by default that of its group.
    """

    group: str
    vertices: ArrayLike
    faces: ArrayLike
    uvs: ArrayLike | None = None
    normals: ArrayLike | None = None
    name: str = ""


@dataclass(frozen=True)
class Group:
    """The properties of all surfaces of one group.

    Attributes:
        rho_d: Diffuse reflectance by channel, 0 to 1.
        rho_s: Specular reflectance by channel, 0 to 1.
        alpha_x: Roughness along the anisotropy direction.
        alpha_y: Roughness across it; both 0 for a mirror.
        theta_deg: The anisotropy direction, degrees from the surface's tangent.
        emission: Radiance that the surfaces emit from their front, W sr^-1 m^-2 by channel.
        texture: Diffuse reflectance over the surface, linear (H, W, 3), in place of rho_d.
    """

    rho_d: Triple = (0.5, 0.5, 0.5)
    rho_s: Triple = (0.0, 0.0, 0.0)
    alpha_x: float = 0.0
    alpha_y: float = 0.0
    theta_deg: float = 0.0
    emission: Triple = (0.0, 0.0, 0.0)
    texture: ArrayLike | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Light:
    """A light without a surface.

    Attributes:
        kind: "point", "spot", "directional", or "profiled" for a lamp with a photometric profile.
        strength: Radiant intensity, W sr^-1 per channel, the greatest of a profile; for directional ones
            irradiance, W m^-2.
        position: Of all but directional ones, metres.
        direction: The direction in which the light of spots and directional ones travels, or in which a
            lamp with a profile is aimed.
        inner_deg: For spots: the half angle up to which the intensity is full, degrees.
        outer_deg: For spots: the half angle from which it is zero, degrees.
        name: Its name.
        upright: For lamps with a profile: the horizontal angle 0 of type C, upwards of types A and B.
        profile: Its table: photometry ("A", "B" or "C"), vertical_deg, horizontal_deg, and candela, for each
            horizontal angle those at all vertical ones.
    """

    kind: Literal["point", "spot", "directional", "profiled"]
    strength: Triple
    position: Triple = (0.0, 0.0, 0.0)
    direction: Triple = (0.0, -1.0, 0.0)
    inner_deg: float = 0.0
    outer_deg: float = 45.0
    name: str = "light"
    upright: Triple = (1.0, 0.0, 0.0)
    profile: Mapping[str, Any] | None = None


_FAR = 32.0
"""Meshes farther from zero than this many times their extent have an origin at their middle, like
those of files."""


def _origin(meshes: Sequence[Mesh]) -> NDArray[np.float64]:
    """The best origin of the vertices in single precision."""
    corners = [np.asarray(mesh.vertices, dtype=float).reshape(-1, 3) for mesh in meshes]
    corners = [c for c in corners if c.size and np.isfinite(c).all()]
    if not corners:
        return np.zeros(3)
    low = np.min([c.min(axis=0) for c in corners], axis=0)
    high = np.max([c.max(axis=0) for c in corners], axis=0)
    middle, extent = 0.5 * (low + high), float(np.linalg.norm(high - low))
    step = 10.0 ** np.floor(np.log10(extent)) if extent > 0.0 else 1.0
    return np.asarray(np.where(np.abs(middle) > _FAR * extent, np.round(middle / step) * step, 0.0))


class _Arrays:
    """The arrays of a mesh in the form of the compiled half, relative to an origin."""

    def __init__(self, mesh: Mesh, origin: NDArray[np.float64]) -> None:
        far = origin.any() and np.ndim(mesh.vertices) == 2
        self.positions = plain(np.asarray(mesh.vertices, dtype=float) - origin if far else mesh.vertices)
        self.triangles = np.require(mesh.faces, np.uint32, ["C", "A"])
        self.normals = None if mesh.normals is None else plain(mesh.normals)
        self.uvs = None if mesh.uvs is None else plain(mesh.uvs)


class Scene:
    """Meshes in groups that share one material, lights, an environment and cameras.

    Scenes do not change; methods that change something return another scene.

    Attributes:
        path: The file from which it was read, if it was.
    """

    path: Path | None

    def __init__(
        self,
        meshes: Iterable[Mesh],
        *,
        groups: Mapping[str, Group] | None = None,
        lights: Iterable[Light] = (),
        cameras: Iterable[Camera] = (),
        environment: Triple | None = None,
    ) -> None:
        """A scene of ``meshes``.

        Args:
            meshes: The objects; arrays are copied.
            groups: Their groups by name; those that are left out are grey and emit nothing.
            lights: Lights without a surface; area lights are groups with an emission.
            cameras: The cameras.
            environment: Radiance from everywhere, by channel.
        """
        meshes, given = list(meshes), dict(groups or {})
        for mesh in meshes:
            given.setdefault(mesh.group, Group())
        origin = _origin(meshes)
        textures = {n: plain(g.texture) for n, g in given.items() if g.texture is not None}
        fields = ("rho_d", "rho_s", "alpha_x", "alpha_y", "theta_deg", "emission")
        document = {
            "groups": [
                {"name": name, **{key: getattr(group, key) for key in fields}}
                for name, group in given.items()
            ],
            "objects": [{"name": mesh.name or mesh.group, "group": mesh.group} for mesh in meshes],
            "lights": [vars(light) for light in lights],
            "cameras": [vars(camera) for camera in cameras],
            "environment": environment,
            "origin": list(origin),
        }
        text = json.dumps(jsonable(document))
        self._inner, doubts = _unrender.Scene.build(text, [_Arrays(m, origin) for m in meshes], textures)
        self.path = None
        self._doubt(doubts)

    @classmethod
    def read(
        cls,
        path: StrPath,
        *,
        light_units: str | None = None,
        allow_outside: bool = False,
        allow_missing: bool = False,
    ) -> Scene:
        """The scene in a file: glTF (.glb, .gltf), OBJ, Mitsuba 3 (.xml) or Radiance (.rad).

        Args:
            path: The file.
            light_units: The units of a glTF file's lights: "blender-standard", "unitless",
                "blender-raw" or "radiometric"; by default as its generator writes them.
            allow_outside: Whether the file may name files outside its folder.
            allow_missing: Whether the rest is read where files that it names are missing.
        """
        inner, doubts = _unrender.Scene.read(
            os.fspath(path), light_units, allow_outside, allow_missing
        )
        made = cls._of(inner)
        made.path = Path(path)
        cls._doubt(doubts)
        return made

    @classmethod
    def _of(cls, inner: _unrender.Scene) -> Scene:
        made = cls.__new__(cls)
        made._inner, made.path = inner, None
        return made

    @staticmethod
    def _doubt(doubts: list[str]) -> None:
        for doubt in doubts:
            warn(doubt)

    def _description(self) -> dict[str, Any]:
        described: dict[str, Any] = json.loads(self._inner.describe())
        return described

    @property
    def groups(self) -> dict[str, Group]:
        """The groups by name, in the scene's order; textures are in :meth:`texture`."""
        found = {}
        for entry in self._description()["groups"]:
            entry.pop("textured")
            name = entry.pop("name")
            found[name] = Group(**entry)
        return found

    @property
    def cameras(self) -> list[Camera]:
        """The cameras, in the scene's order."""
        found = []
        for entry in self._description()["cameras"]:
            entry["world_from_camera"] = tuple(entry["world_from_camera"])
            found.append(Camera(**entry))
        return found

    @property
    def lights(self) -> list[Light]:
        """The lights without a surface."""
        return [Light(**entry) for entry in self._description()["lights"]]

    @property
    def objects(self) -> list[tuple[str, str]]:
        """The name and the group of every object, in the order of :meth:`mesh`."""
        return [(entry["name"], entry["group"]) for entry in self._description()["objects"]]

    @property
    def brdf(self) -> str:
        """The lobe of the materials' parameters."""
        name: str = self._description()["brdf"]
        return name

    def mesh(self, index: int) -> Mesh:
        """The arrays of the object with this number: vertices (N, 3) in metres, faces (M, 3),
        normals (N, 3), uvs (N, 2) or None. The vertices of a scene far from zero have double precision."""
        described = self._description()
        name, group = described["objects"][index]["name"], described["objects"][index]["group"]
        vertices, faces, normals, uvs = self._inner.mesh(index)
        if any(described["origin"]):
            vertices = np.asarray(vertices, dtype=float) + np.asarray(described["origin"])
        return Mesh(group, vertices, faces, uvs=uvs, normals=normals, name=name)

    def texture(self, group: str) -> NDArray[np.float32] | None:
        """The texture of a group's rho_d, linear (H, W, 3)."""
        return self._inner.texture(group)

    def with_materials(self, materials: Materials | Mapping[str, Any] | StrPath) -> Scene:
        """The same scene with ``materials`` (a path, a dict or Materials) on its groups."""
        inner, doubts = self._inner.with_materials(Parts(Materials.of(materials)))
        self._doubt(doubts)
        return self._of(inner)

    def with_camera(self, camera: Camera) -> Scene:
        """The same scene with a further camera, which replaces one of its name."""
        return self._of(self._inner.with_camera(json.dumps(jsonable(vars(camera)))))

    def save(self, path: StrPath) -> None:
        """Writes the scene to a .glb file, with the exact Ward parameters in its extras. Its environment,
        if it has one, is not in the file: glTF cannot express it."""
        self._inner.save(os.fspath(path))
        if self._inner.environment() is not None:
            warn(f"{os.fspath(path)}: glTF cannot express the scene's environment, which is not in it")

    def __getstate__(self) -> dict[str, Any]:
        """The state of the scene, for processes with the same build: ``pickle`` and ``copy`` use
        it."""
        return {"bytes": self._inner.to_bytes(), "path": self.path}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restores the scene from such a state."""
        self._inner, self.path = _unrender.Scene.from_bytes(state["bytes"]), state["path"]

    def __repr__(self) -> str:
        described = self._description()
        triangles = sum(entry["triangles"] for entry in described["objects"])
        groups = ", ".join(entry["name"] for entry in described["groups"])
        origin = f"{self.path}: " if self.path else ""
        return f"<Scene {origin}{triangles} triangles; groups {groups}>"
