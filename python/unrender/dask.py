"""Work on a cluster with Dask's ``distributed``: many projects, or one picture or one recovery over
all workers.

Workers need this package in the same version. For :func:`batch` and :func:`render` they must see files
under the same paths as this process; data in memory are sent to them, and so is everything in
:func:`recover`.
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
from .project import IN_MEMORY, Project
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
"""The number of parts per worker. With half of it, the others wait for a slow worker for a quarter
of the time; with double, twice as many parts are sent and added."""


@dataclass(frozen=True)
class Result:
    """The result of one project.

    Attributes:
        project: The path of the project file; or the project, if it is in memory.
        materials: Its materials; None if it failed.
        folder: The folder of its results, if they were written.
        error: The error, if it failed.
        number: The number of the project, counted from 1.
    """

    project: Path | Project
    materials: Materials | None
    folder: Path | None = None
    error: Error | None = None
    number: int = 0


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
        """A row per project and group, a column per parameter; projects that failed have a
        ``note``."""
        import pandas

        rows: dict[tuple[str, str], dict[str, Any]] = {}
        for result in self.wait():
            is_file = isinstance(result.project, Path)
            project = str(result.project) if is_file else f"{IN_MEMORY} {result.number}"
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
    projects: Iterable[Project | StrPath],
    *,
    client: Client,
    out: StrPath | None = None,
    retries: int = 2,
    **options: Any,
) -> Batch:
    """Recovers many projects, one future per project.

    Args:
        projects: Projects, or the paths of their files.
        client: A client of ``distributed``.
        out: A folder, in which each project gets a folder of results by its number and name.
        retries: How often a project is tried again if its worker was lost.
        options: Those of :func:`unrender.recover`.
    """
    jobs: list[_Job] = []
    for number, project in enumerate(projects, 1):
        given = _there(project)
        named = f"{given.parent.name}_{given.stem}" if isinstance(given, Path) else "in_memory"
        place = None if out is None else Path(out).absolute() / f"{number:04d}_{named}"
        jobs.append((number, given, place))
    futures = client.map(_recovered, jobs, options=options, retries=retries, pure=False)
    return Batch(list(futures))


def render(
    scene: Scene | StrPath | None = None,
    *,
    client: Client,
    project: Project | StrPath | None = None,
    materials: Materials | Recovery | Mapping[str, Any] | StrPath | None = None,
    spp: int = 64,
    parts: int | None = None,
    retries: int = 3,
    progress: Progress = None,
    **options: Any,
) -> Picture:
    """Renders one picture over all workers, with the bits of one machine; of a scene, or of a project.

    The samples are divided into ranges; the workers' exact sums are added. Workers may come and go:
    the ranges of a lost one are rendered again.

    Args:
        scene: A scene, or the path of its file.
        client: A client of ``distributed``.
        project: Instead of a scene, as in :func:`unrender.render`.
        materials: As in :func:`unrender.render`.
        spp: Samples per pixel.
        parts: The number of ranges; by default four per worker.
        retries: How often a range is tried again if its worker was lost.
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
        given = scatter(_Given(_there(scene), _there(project), _there(materials)), broadcast=True)
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

    The workers hold the scene and render; fits and decisions are made here, once. Workers may come and go:
    the work of a lost one is done again. If none is left for a minute, the recovery warns and continues
    alone. This process sends its requests directly to the workers' addresses, which it must be able to
    reach; they need no files.

    Args:
        project: A project, or the path of its file on this machine.
        client: A client of ``distributed``.
        counted: A callback that receives at the end ``requests``, ``sent`` and ``received`` bytes, and
            ``lost`` requests.
        options: Those of :func:`unrender.recover`.

    Raises:
        Error: As in :func:`unrender.recover`.
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


@dataclass(frozen=True)
class _Given:
    """The arguments of a worker's rendering: paths, or data in memory."""

    scene: Path | Scene | None
    project: Path | Project | None
    materials: Path | Materials | None


def _there(given: Any) -> Any:
    """The form in which an argument is sent to a worker: the path of a file, or data in memory."""
    if isinstance(given, Project):
        return given if given.path is None else given.path.absolute()
    if given is None or isinstance(given, Scene):
        return given
    if isinstance(given, (str, os.PathLike)):
        return Path(given).absolute()
    return given.materials if isinstance(given, Recovery) else Materials.of(given)


def _as_completed(futures: list[Any]) -> Generator[Any, None, None]:
    """The futures in the order in which they end."""
    distributed: Any = import_module("distributed")
    yield from distributed.as_completed(futures)


def _samples(samples: tuple[int, int], given: _Given, options: dict[str, Any]) -> bytes:
    """On a worker: the part of a picture with these samples."""
    with tempfile.TemporaryDirectory(prefix="unrender-") as folder:
        part = Path(folder) / "part.exr"
        words = {"project": given.project, "materials": given.materials, **options}
        render_here(given.scene, **words, samples=samples, out=part)
        return part.read_bytes()


_Job = tuple[int, Path | Project, Path | None]
"""The number of a project, the project, and the folder of its results."""


def _recovered(job: _Job, options: dict[str, Any]) -> Result:
    """On a worker: the result of a project. Errors of the project are results, not failures."""
    number, project, out = job
    try:
        recovery = recover_here(project, out=out, **options)
    except Error as error:
        return Result(project, None, error=error, number=number)
    return Result(project, recovery.materials, recovery.folder, number=number)
