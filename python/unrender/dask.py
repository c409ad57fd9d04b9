"""Work on a cluster, by Dask's ``distributed``: many projects, or one picture or one recovery over all
workers.

Workers need this package in the same version. For :func:`batch` and :func:`render` they see the files of
scenes and projects under the same paths; what is in memory goes to them by itself, and so does everything
in :func:`recover`.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Generator, Iterable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _tables
from ._control import Progress, StrPath, control, warn
from ._workers import Workers
from .errors import Error, RequestError
from .materials import Materials
from .pictures import Picture
from .project import Project
from .recovery import WORKERS, Recovery
from .recovery import recover as recover_here
from .rendering import merge
from .rendering import render as render_here
from .scene import Scene
from .verbs import report

if TYPE_CHECKING:
    import pandas
    from distributed import Client

__all__ = ["Batch", "Result", "batch", "recover", "render"]

PARTS_A_WORKER = 4
"""Into how many parts the work of a worker is cut. With half of it, a slow worker keeps the others
waiting for a quarter of the time; with double, twice the parts are sent and added."""


@dataclass(frozen=True)
class Result:
    """What came of one project.

    Attributes:
        project: The path of the project file.
        materials: Its materials; None if it failed.
        folder: The folder of its results, if they were written.
        error: Why it failed, if it did.
    """

    project: Path
    materials: Materials | None
    folder: Path | None = None
    error: Error | None = None


@dataclass
class Batch:
    """The recoveries of many projects: an iterable of :class:`Result`, in the order in which they end.

    Attributes:
        results: Those that have ended.
    """

    _futures: list[Any] = field(repr=False)
    results: list[Result] = field(default_factory=list[Result])

    def __iter__(self) -> Generator[Result, None, None]:
        waiting, self._futures = self._futures, []
        yield from list(self.results)
        for future in _as_completed(waiting):
            result: Result = future.result()
            self.results.append(result)
            yield result

    def wait(self) -> list[Result]:
        """All results."""
        for _ in self:
            pass
        return self.results

    def table(self) -> pandas.DataFrame:
        """A row a project and group, a column a number; projects that failed have an ``error``."""
        import pandas

        rows: dict[tuple[str, str], dict[str, Any]] = {}
        for result in self.wait():
            project = os.fspath(result.project)
            for group, entry in (result.materials or {}).items():
                rows[project, group] = _tables.row(entry)
            if result.error is not None:
                rows[project, ""] = {"note": str(result.error)}
        index = pandas.MultiIndex.from_tuples(list(rows), names=["project", "group"])
        return pandas.DataFrame(list(rows.values()), index=index)

    def report(self, out: StrPath) -> Path:
        """One page that compares all recoveries whose results were written."""
        folders = [result.folder for result in self.wait() if result.folder is not None]
        if not folders:
            raise RequestError("there are no results to report; give the batch a folder (out=)")
        return report(list(folders), out=out)


def batch(
    projects: Iterable[StrPath],
    *,
    client: Client,
    out: StrPath | None = None,
    retries: int = 2,
    **options: Any,
) -> Batch:
    """Recovers many projects, one future a project.

    Args:
        projects: The project files.
        client: A client of ``distributed``.
        out: A folder, in which each project gets a folder of results by its number and name.
        retries: How often a project is tried again whose worker was lost.
        options: Those of :func:`unrender.recover`.
    """
    jobs: list[tuple[str, str | None]] = []
    for number, project in enumerate(projects, 1):
        path = Path(project).absolute()
        name = f"{number:04d}_{path.parent.name}_{path.stem}"
        jobs.append((os.fspath(path), None if out is None else os.fspath(Path(out).absolute() / name)))
    futures = client.map(_recovered, jobs, options=options, retries=retries, pure=False)
    return Batch(list(futures))


def render(
    scene: Scene | StrPath,
    *,
    client: Client,
    materials: Materials | Recovery | Mapping[str, Any] | StrPath | None = None,
    spp: int = 64,
    parts: int | None = None,
    retries: int = 3,
    progress: Progress = None,
    **options: Any,
) -> Picture:
    """Renders one picture over all workers, with the bits of one machine.

    The samples are cut into ranges; the workers' exact sums are added. Workers may come and go: what a
    lost one had is rendered again.

    Args:
        scene: A scene, or the path of its file.
        client: A client of ``distributed``.
        materials: As of :func:`unrender.render`.
        spp: Samples a pixel.
        parts: Into how many ranges they are cut; by default four a worker.
        retries: How often a range is tried again whose worker was lost.
        progress: A callback ``f(done, message)``; or True for a bar of tqdm.
        options: Those of :func:`unrender.render`, such as ``width`` and ``seed``.
    """
    if parts is None:
        workers: dict[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
        parts = PARTS_A_WORKER * max(1, len(workers))
    parts = max(1, min(parts, spp))
    edges = [spp * k // parts for k in range(parts + 1)]
    ranges = list(zip(edges, edges[1:], strict=False))
    with tempfile.TemporaryDirectory(prefix="unrender-") as folder:
        scatter: Any = client.scatter
        given = scatter(_packed(scene, materials, Path(folder)), broadcast=True)
        futures = client.map(
            _samples, ranges, given=given, options=options, retries=retries, pure=False
        )
        files: list[StrPath] = []
        with control(progress, None, None) as controls:
            for future in _as_completed(list(futures)):
                files.append(Path(folder) / f"part{len(files)}.exr")
                Path(files[-1]).write_bytes(future.result())
                done = len(files)
                controls.progress(f"{done} of {len(ranges)} parts", done / len(ranges))
        return merge(files, out=Path(folder) / "picture.exr")


def recover(
    project: Project | StrPath,
    *,
    client: Client,
    counted: Callable[[Workers], object] | None = None,
    **options: Any,
) -> Recovery:
    """Recovers one project over all workers, with the bits of one machine.

    The workers hold the scene and render; fits and decisions are made here, once. Workers may come and
    go: what a lost one had is rendered again. Where none is left for a minute, the recovery warns and goes
    on by itself. This process sends its requests straight to the workers' addresses, which it has to
    reach; they need no files.

    Args:
        project: A project, or the path of its file, here.
        client: A client of ``distributed``.
        counted: Hears at the end what was sent: ``requests``, ``sent`` and ``received`` bytes, ``lost``
            requests.
        options: Those of :func:`unrender.recover`.

    Raises:
        Error: As :func:`unrender.recover`.
        Interrupted: On Ctrl-C, within a second, with the best state so far in ``recovery``.
    """
    doubts: list[str] = []
    workers = Workers(client, doubts.append)
    before = WORKERS.set(workers)
    try:
        return recover_here(project, **options)
    finally:
        WORKERS.reset(before)
        if counted is not None:
            counted(workers)
        for doubt in doubts:
            warn(doubt)


Packed = tuple[str | bytes, str | dict[str, bytes] | None]
"""The path of the scene or the bytes of a .glb; the path of the materials or their files by name."""


def _packed(scene: Any, materials: Any, folder: Path) -> Packed:
    """What workers need that lies in no file."""
    if isinstance(scene, Scene) and scene.path is None:
        scene.save(folder / "scene.glb")
        model: str | bytes = (folder / "scene.glb").read_bytes()
    else:
        path: Any = scene.path if isinstance(scene, Scene) else scene
        model = os.fspath(Path(path).absolute())
    if materials is None:
        return model, None
    if isinstance(materials, (str, os.PathLike)):
        path = Path(materials).absolute()
        return model, os.fspath(path / "materials.json" if path.is_dir() else path)
    found = materials.materials if isinstance(materials, Recovery) else Materials.of(materials)
    place = folder / "materials"
    place.mkdir()
    found.write(place / "materials.json")
    return model, {file.name: file.read_bytes() for file in place.iterdir()}


def _as_completed(futures: list[Any]) -> Generator[Any, None, None]:
    """The futures in the order in which they end."""
    distributed: Any = import_module("distributed")
    yield from distributed.as_completed(futures)


def _samples(samples: tuple[int, int], given: Packed, options: dict[str, Any]) -> bytes:
    """On a worker: the part of a picture with these samples."""
    model, materials = given
    with tempfile.TemporaryDirectory(prefix="unrender-") as name:
        folder = Path(name)
        if isinstance(model, bytes):
            (folder / "scene.glb").write_bytes(model)
            model = os.fspath(folder / "scene.glb")
        if isinstance(materials, dict):
            for file, data in materials.items():
                (folder / file).write_bytes(data)
            materials = os.fspath(folder / "materials.json")
        part = folder / "part.exr"
        words = {"materials": materials, **options, "samples": samples, "out": part}
        render_here(model, **words)
        return part.read_bytes()


def _recovered(job: tuple[str, str | None], options: dict[str, Any]) -> Result:
    """On a worker: what came of a project. Errors of the project are results, not failures."""
    project, out = job
    try:
        recovery = recover_here(project, out=out, **options)
    except Error as error:
        return Result(Path(project), None, error=error)
    return Result(Path(project), recovery.materials, recovery.folder)
