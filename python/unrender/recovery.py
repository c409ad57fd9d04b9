"""The command ``unrender recover`` as a function, and its results."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Generator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _tables, _unrender
from ._control import CancelToken, Progress, StrPath, control, words
from .errors import Interrupted, RequestError
from .materials import Materials
from .page import Page
from .pictures import Picture, read_picture
from .project import Project, ProjectParts
from .scene import Camera, Scene

if TYPE_CHECKING:
    import pandas
    import xarray

__all__ = ["Covariance", "Recovery", "recover"]

WORKERS: ContextVar[Any] = ContextVar("WORKERS", default=None)
"""The workers that render for recoveries started here; None means this process."""


@dataclass(frozen=True)
class Covariance:
    """The joint covariance of all refined parameters.

    Attributes:
        names: The name of each parameter: ("rho_d", "floor", 0) is the red of the floor's diffuse
            reflectance. The first is "rho_d", "rho_s", "alpha" (of a round lobe), "alpha_x",
            "alpha_y", "theta_deg", "intensity", "exposure" or "camera"; the second the group or the
            light, or None; the third the channel, or None.
        matrix: Their covariance, (N, N), in the units of materials.json: degrees for directions.
    """

    names: list[tuple[str, str | None, int | None]]
    matrix: NDArray[np.float64]

    @property
    def std(self) -> NDArray[np.float64]:
        """The standard deviations, (N,)."""
        return np.sqrt(np.maximum(np.diag(self.matrix), 0.0))

    @property
    def correlation(self) -> NDArray[np.float64]:
        """The correlations, (N, N)."""
        std = self.std
        scale = np.outer(std, std)
        return np.divide(self.matrix, scale, out=np.zeros_like(self.matrix), where=scale > 0.0)


class Recovery:
    """The results from a photograph, or from several.

    Attributes:
        materials: The parameters of every group with their standard deviations, as in
            materials.json; textures in ``materials.textures``.
        interrupted: Whether it was interrupted.
        folder: The folder of the results, if they were written or read.
    """

    materials: Materials
    interrupted: bool
    folder: Path | None

    def __init__(
        self,
        materials: Materials,
        *,
        document: dict[str, Any] | None = None,
        inner: _unrender.Recovered | None = None,
        interrupted: bool = False,
        folder: Path | None = None,
    ) -> None:
        """As :func:`recover` and :meth:`read` make it."""
        self.materials, self.interrupted, self.folder = materials, interrupted, folder
        self._document, self._inner = document or {}, inner
        self._photograph = 0

    @classmethod
    def _of(cls, inner: _unrender.Recovered, folder: Path | None) -> Recovery:
        document = json.loads(inner.document())
        materials = Materials()
        materials.document = json.loads(document["materials"])
        for name in materials:
            found = inner.texture(name)
            if found is not None:
                materials.textures[name] = found[0]
        if folder is not None:
            materials.folder = folder
        interrupted = document["interrupted"]
        return cls(
            materials, document=document, inner=inner, interrupted=interrupted, folder=folder
        )

    @classmethod
    def read(cls, folder: StrPath) -> Recovery:
        """The recovery in a folder of results."""
        place = Path(folder)
        materials = Materials.read(place)
        run: dict[str, Any] = {}
        if (place / "run.json").is_file():
            run = json.loads((place / "run.json").read_text(encoding="utf-8"))
        interrupted = "interrupted" in str(materials.document.get("termination", ""))
        return cls(materials, document=run, interrupted=interrupted, folder=place)

    @property
    def photographs(self) -> int:
        """The number of photographs from which it was recovered."""
        count = self._document.get("photographs", 1)
        # A file has a list of them if there are several.
        return (len(count) or 1) if isinstance(count, list) else int(count)

    def of(self, photograph: int) -> Recovery:
        """The same for one of several photographs, counted from 0: ``photo``, ``rerendered``, ``camera``,
        ``exposure``, ``exposure_std``, ``photograph``, ``noise``, ``group_map``, ``valid`` and ``status_map`` are
        those of that photograph; otherwise they are those of the first."""
        if not 0 <= photograph < self.photographs:
            raise RequestError(f"there is no photograph {photograph}; there are {self.photographs}")
        shown = Recovery(
            self.materials,
            document=self._document,
            inner=self._inner,
            interrupted=self.interrupted,
            folder=self.folder,
        )
        shown._photograph = photograph
        return shown

    @property
    def exposure(self) -> NDArray[np.float32]:
        """Scene radiance per unit of linear pixel value, per channel, (3,)."""
        entry = self._taken or self.materials.document
        return np.array(entry.get("exposure") or [np.nan] * 3, dtype=np.float32)

    @property
    def exposure_std(self) -> NDArray[np.float32] | None:
        """Its standard deviation, if the exposure was unknown, (3,)."""
        taken = self._taken
        std = self._document.get("exposure_std") if taken is None else (taken.get("std") or {}).get("exposure")
        return None if std is None else np.array(std, dtype=np.float32)

    @property
    def lights(self) -> dict[str, dict[str, Any]]:
        """The lights whose brightness was unknown, by name: ``intensity`` and ``std``."""
        return self.materials.lights

    @property
    def photograph(self) -> dict[str, Any] | None:
        """The photometric parameters that were unknown: ``gamma``, ``vignetting``, ``corner``."""
        return self._taken or self.materials.document.get("photograph")

    @property
    def _taken(self) -> dict[str, Any] | None:
        """The results for this one of several photographs."""
        several = self.materials.document.get("photographs") or []
        return dict(several[self._photograph]) if several else None

    @property
    def seconds(self) -> float:
        """Its time, seconds."""
        return float(self.materials.document.get("seconds", np.nan))

    @property
    def termination(self) -> str:
        """Why it ended, a sentence."""
        return str(self.materials.document.get("termination", ""))

    @property
    def summary(self) -> str:
        """The table that the command prints."""
        return str(self._document.get("summary", ""))

    @property
    def warnings(self) -> list[str]:
        """The warnings about the input."""
        return list(self._document.get("warnings", []))

    @property
    def iterations(self) -> list[dict[str, Any]]:
        """The global re-renderings in their order, with the errors of the groups after each."""
        return list(self._document.get("iterations", []))

    @property
    def camera(self) -> Camera | None:
        """The camera that it used, which may have been moved to fit the photograph."""
        if self._inner is None:
            return None
        entry = json.loads(self._inner.camera(self._photograph))
        entry["world_from_camera"] = tuple(entry["world_from_camera"])
        return Camera(**entry)

    @cached_property
    def rerendered(self) -> Picture:
        """The photograph's view with the recovered materials: radiance, (H, W, 3)."""
        if self._inner is None and self.folder is not None:
            number = f"_{self._photograph + 1}" if self.photographs > 1 else ""
            return read_picture(self.folder / f"rerendered{number}.exr")
        return Picture(self._whole().picture("rerendered", self._photograph))

    @cached_property
    def photo(self) -> Picture:
        """The photograph as radiance, (H, W, 3); with exposure "auto", for an exposure of one."""
        return Picture(self._whole().picture("photo", self._photograph))

    @cached_property
    def noise(self) -> NDArray[np.float32]:
        """The standard deviation of the noise in the luminance of photograph minus re-rendering,
        radiance, (H, W)."""
        return self._whole().noise(self._photograph)

    @cached_property
    def group_map(self) -> NDArray[np.int32]:
        """The number of every pixel's group in the order of ``materials``, -1 for none, (H, W)."""
        return self._whole().group_map(self._photograph)

    @cached_property
    def valid(self) -> NDArray[np.bool_]:
        """Which pixels of the photograph were used, (H, W)."""
        return np.asarray(self.status_map == 0)

    @cached_property
    def status_map(self) -> NDArray[np.uint8]:
        """Why a pixel was not used, (H, W): 0 it was used, 1 no model there, 2 clipped or left out, 3
        too close to an edge, 4 a single bright pixel, 5 it shows something that the model lacks."""
        return self._whole().status_map(self._photograph)

    def texture(self, group: str) -> NDArray[np.float32] | None:
        """The texture of a group's rho_d, linear (H, W, 3); None if it has none."""
        return self.materials.texture(group)

    def seen_texels(self, group: str) -> NDArray[np.bool_] | None:
        """Which texels of a group's texture the photograph shows, (H, W)."""
        found = self._whole().texture(group)
        return None if found is None else found[1]

    @cached_property
    def covariance(self) -> Covariance | None:
        """The joint covariance of all refined parameters; None if nothing was refined."""
        found = self._whole().covariance()
        if found is None:
            return None
        names = [(name, owner, channel) for name, owner, channel in json.loads(found[0])]
        return Covariance(names, found[1])

    def scene(self) -> Scene:
        """The scene with the recovered materials and lights."""
        if self._inner is None and self.folder is not None:
            return Scene.read(self.folder / "scene.glb").with_materials(self.materials)
        return Scene._of(self._whole().scene())

    def save(self, out: StrPath) -> Path:
        """Writes the results into a folder as the command does: materials.json, pictures, scene.glb,
        report.html, run.json. Returns the folder's path."""
        self._whole().save(os.fspath(out))
        self.folder = Path(out)
        return self.folder

    @contextmanager
    def as_folder(self) -> Generator[Path, None, None]:
        """A folder of the results: its own, or a temporary one."""
        if self.folder is not None:
            yield self.folder
            return
        with tempfile.TemporaryDirectory(prefix="unrender-") as folder:
            place = Path(folder) / "results"
            self._whole().save(os.fspath(place))
            yield place

    def view(
        self,
        *,
        project: StrPath | None = None,
        spp: int = 64,
        seed: int = 0,
        progress: Progress = None,
        cancel: CancelToken | None = None,
    ) -> Page:
        """A page on which its lamps and colours are played with, which notebooks show inline; as
        :func:`unrender.view` makes it."""
        from .verbs import view

        return view(
            self,
            project=project,
            no_open=True,
            spp=spp,
            seed=seed,
            progress=progress,
            cancel=cancel,
        )

    def to_pandas(self) -> pandas.DataFrame:
        """A table with a row per group and a column per parameter; standard deviations are in
        ``std_*``."""
        return _tables.frame(self.materials)

    def to_xarray(self) -> xarray.Dataset:
        """The parameters over group and channel, their standard deviations, and the pictures over
        row, column and channel."""
        return _tables.dataset(self)

    def __getstate__(self) -> dict[str, Any]:
        """The state of the recovery, for processes with the same build: ``pickle`` and ``copy`` use
        it."""
        inner = None if self._inner is None else self._inner.to_bytes()
        return {**vars(self), "_inner": inner}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restores the recovery from such a state."""
        vars(self).update(state)
        inner = state["_inner"]
        self._inner = None if inner is None else _unrender.Recovered.from_bytes(inner)

    def _whole(self) -> _unrender.Recovered:
        if self._inner is None:
            raise RequestError(
                "this is not available for a recovery that was read from files or interrupted early"
            )
        return self._inner

    def __repr__(self) -> str:
        groups = (f"{name}: {entry.get('hypothesis')}" for name, entry in self.materials.items())
        return f"<Recovery {', '.join(groups)}; {self.termination}>"

    def _repr_html_(self) -> str:
        return _tables.recovery_html(self)

    def _repr_png_(self) -> bytes | None:
        if self._inner is None and self.folder is None:
            return None
        return Picture(np.asarray(self.rerendered) / self.exposure)._repr_png_()


def recover(
    project: Project | StrPath,
    *,
    out: StrPath | None = None,
    ladder: str = "default",
    paper_direction: str = "rerender",
    effort: str = "normal",
    seed: int = 0,
    spp: int | None = None,
    bounces: int | None = None,
    no_refine: bool = False,
    max_rung: str | None = None,
    refine_camera: bool = False,
    keep_camera: bool = False,
    no_filter: bool = False,
    picture: str = "worked",
    force: bool = False,
    progress: Progress = None,
    on_iteration: Callable[[Materials], object] | None = None,
    cancel: CancelToken | None = None,
    threads: int | None = None,
    allow_outside: bool = False,
    allow_missing: bool = False,
    input_memory: float | None = None,
) -> Recovery:
    """Recovers the materials of a project's groups from its photograph.

    The results equal those of ``unrender recover PROJECT.toml --out DIR`` with the same arguments
    to the bit, for any number of threads.

    Args:
        project: A project, or the path of its file.
        out: A folder for the results, as the command writes them; by default they are not written.
        ladder: The ladder of hypotheses: "default", or "paper" for the method of Boivin and
            Gagalowicz (2002).
        paper_direction: How the paper's ladder finds the anisotropy direction: "rerender" for the one of 64
            with the smallest difference of the re-rendering, or "text" for the mirror difference of the
            paper's text.
        effort: The amount of work: "draft" for a first answer with an eighth of the samples, "normal", or
            "high" for four times as many.
        seed: The seed of the renderings' noise.
        spp: Paths per pixel of the final re-rendering; by default 64, for a draft 16, above 512 x 512
            pixels fewer.
        bounces: The most reflections of a path; by default until it carries nothing more.
        no_refine: Leave out the joint refinement, and with it the standard deviations.
        max_rung: The most complex hypothesis that a group may have: "diffuse", "mirror",
            "partial-mirror", "diffuse-specular", "isotropic", "anisotropic" or "textured".
        refine_camera: Move the camera to the place where the model's edges fit the photograph's; by
            default only if a quick rendering is nearer to the photograph there.
        keep_camera: Keep the given camera.
        no_filter: Assume that the model fits to the pixel, and that it contains all that the
            photograph shows.
        picture: The size of ``rerendered`` and ``photo`` if a photograph of more than a megapixel is
            reduced to means of squares of its pixels: "worked", or "full" for that of the photograph.
        force: Continue if no reflectances explain the photograph, but a factor on all light would.
        progress: A callback ``f(done, message)``; or True for a bar of tqdm.
        on_iteration: A callback that receives the materials after an iteration, on this thread,
            while the recovery continues; if it is slow, iterations are skipped. The re-rendering
            with them is ``render(project=..., materials=...)``. Textures are left out.
        cancel: A token; when it is cancelled, the best state so far is returned, marked
            ``interrupted``.
        threads: How many threads to use; by default one per core.
        allow_outside: Whether scenes may name files outside their folder.
        allow_missing: Whether a scene is read without the files that it names and that are missing.
        input_memory: The memory that a scene or a picture may take while it is read, GiB.

    Raises:
        Error: If the input cannot be used or the results cannot be written.
        Interrupted: On Ctrl-C, within a second, with the best state so far in ``recovery``.
    """
    flags = {
        "out": "(in memory)",
        "ladder": ladder,
        "paper_direction": paper_direction,
        "effort": effort,
        "seed": seed,
        "spp": spp,
        "bounces": bounces,
        "no_refine": no_refine,
        "max_rung": max_rung,
        "refine_camera": refine_camera,
        "keep_camera": keep_camera,
        "no_filter": no_filter,
        "picture": picture,
        "force": force,
    }
    path: StrPath = project.path or "(in memory)" if isinstance(project, Project) else project
    parts = None
    if isinstance(project, Project) and project.path is None:
        parts = ProjectParts(project)
    folder = None if out is None else os.fspath(out)
    line = words("recover", [path], flags, allow_outside, input_memory, allow_missing)
    with control(progress, cancel, threads) as controls:
        if on_iteration is not None:
            controls.hear = lambda text: on_iteration(_sketched(json.loads(text)).materials)
        workers = WORKERS.get()
        inner, sketch, signalled = _unrender.recover(line, parts, folder, controls, workers)
    written = Path(folder) if folder is not None and inner is not None else None
    found = None
    if inner is not None:
        found = Recovery._of(inner, written)
    elif sketch is not None:
        found = _sketched(json.loads(sketch))
    if signalled or found is None:
        raise Interrupted(recovery=found)
    return found


def _sketched(document: dict[str, Any]) -> Recovery:
    """The state of a recovery when it was interrupted: its materials, without pictures."""
    materials = Materials()
    materials.document = document
    return Recovery(materials, interrupted=True)
