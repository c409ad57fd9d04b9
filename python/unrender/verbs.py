"""The other subcommands as functions; their options are those of the command line."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _unrender
from ._control import CancelToken, Control, Progress, Samples, StrPath, control, words
from ._files import (
    AnyMaterials,
    given_scene,
    is_path,
    materials_file,
    panorama_file,
    project_file,
    results_folder,
    temporary,
)
from .errors import Cancelled, Interrupted, RequestError
from .page import Page
from .pictures import Picture, read_picture
from .project import Project
from .recovery import Recovery
from .scene import Camera, Scene

__all__ = [
    "BrdfFits",
    "Calibration",
    "Checkup",
    "Plan",
    "Proposed",
    "Restaging",
    "Score",
    "calibrate",
    "check",
    "export",
    "fit_brdf",
    "init",
    "plan",
    "report",
    "restage",
    "score",
    "split",
    "view",
]


@dataclass(frozen=True)
class Calibration:
    """The camera of a photograph.

    Attributes:
        camera: The camera.
        summary: The errors of the pairs and the standard deviations, as the command prints them.
    """

    camera: Camera
    summary: str


def calibrate(
    photo: ArrayLike | StrPath | None = None,
    *,
    scene: Scene | StrPath | None = None,
    points: StrPath | tuple[ArrayLike, ArrayLike] | None = None,
    lines: StrPath | None = None,
    camera_height: float | None = None,
    show_lines: StrPath | None = None,
    save_lines: StrPath | None = None,
    fspy: StrPath | None = None,
    fspy_up: str | None = None,
    principal_point: bool = False,
    distortion: bool = False,
    fov_y_deg: float | None = None,
    seed: int = 0,
    name: str = "calibrated",
    out: StrPath | None = None,
    allow_outside: bool = False,
    allow_missing: bool = False,
    input_memory: float | None = None,
) -> Calibration:
    """Finds the camera of a photograph from points of the scene that it shows, or from lines along its axes.

    Args:
        photo: The photograph, a path or an array (H, W, 3) as in a :class:`Project`; by default that of
            the project in ``out``.
        scene: A scene, or the path of its file; by default that of the project in ``out``.
        points: The path of a CSV file (x_px,y_px,x_m,y_m,z_m,name); or two arrays: pixels (N, 2),
            (0, 0) the photo's top left corner, and the same points in the scene, metres (N, 3).
        lines: The path of a CSV file (axis,x1_px,y1_px,x2_px,y2_px,length_m,name) of lines along the axes of
            a scene, which needs no model then; or "auto" to find them in the photograph.
        camera_height: With ``lines``, the camera's height above the origin, metres.
        show_lines: A picture (.png) to write, with the lines over the photograph.
        save_lines: A CSV file to write the lines to, such as those that were found.
        fspy: Take the camera of an fSpy project instead.
        fspy_up: The axis of the fSpy project that points upwards, "y" or "z".
        principal_point: Find the principal point too.
        distortion: Find the radial distortion k1, k2 too.
        fov_y_deg: The vertical field of view, degrees, if it is known.
        seed: The seed of the subsets of pairs that are tried.
        name: The camera's name in a .glb.
        out: A project file (.toml), which is made or whose camera is replaced, or the scene with the
            camera in it (.glb), with ``lines`` also a new scene of the camera and a square metre; by default nothing is written. Data in
            memory are written beside a new project.
        allow_outside: Whether scenes may name files outside their folder.
        allow_missing: Whether a scene is read without the files that it names and that are missing.
        input_memory: The memory that a scene or a picture may take while it is read, GiB.

    Raises:
        CalibrateError: If the points or lines do not determine a camera.
    """
    with ExitStack() as stack:
        place = stack.enter_context(temporary())
        if isinstance(points, tuple):
            points = _points_file(place / "points.csv", *points)
        # Lines need no scene, and a project needs one.
        needs_scene = lines is None or scene is not None
        if not (needs_scene or photo is None or is_path(photo)):
            raise RequestError("lines without a scene take the path of the photo")
        target = place / ("project.toml" if needs_scene else "camera.glb") if out is None else Path(out)
        made = None
        if isinstance(scene, Scene) or not (photo is None or is_path(photo)):
            made = _project_in_memory(photo, scene, target)
            file = made.save(place / "project.toml")
            if target.suffix == ".toml":
                photo, scene, target = None, None, file
            else:
                stated = Project.read(file)
                photo, scene = (stated.folder / stated.document[key] for key in ("photo", "scene"))
        flags: dict[str, object] = {
            "scene": scene,
            "points": points,
            "lines": lines,
            "camera_height": camera_height,
            "show_lines": show_lines,
            "save_lines": save_lines,
            "fspy": fspy,
            "fspy_up": fspy_up,
            "principal_point": principal_point,
            "distortion": distortion,
            "fov_y_deg": fov_y_deg,
            "seed": seed if fspy is None else None,
            "name": name,
            "out": target,
        }
        positional: list[Any] = [] if photo is None else [photo]
        line = words("calibrate", positional, flags, allow_outside, input_memory, allow_missing)
        summary = _called(line, None, None, None)
        if made is not None and out is not None and target != Path(out):
            made.document["camera"] = Project.read(target).document["camera"]
            made.save(out)
        if target.suffix == ".toml":
            camera = Camera(**Project.read(target).document["camera"])
        else:
            camera = next(c for c in Scene.read(target).cameras if c.name == name)
    return Calibration(camera, summary)


def _project_in_memory(photo: Any, scene: Scene | StrPath | None, target: Path) -> Project:
    """The project of a photograph and a scene, one or both of which are in memory."""
    if target.suffix == ".toml" and target.exists():
        raise RequestError(f"{target}: is a project already, which names its photo and its scene")
    if photo is None or scene is None:
        raise RequestError("give photo and scene")
    return Project(scene, photo)


def _points_file(path: Path, pixels: ArrayLike, metres: ArrayLike) -> Path:
    seen, there = np.asarray(pixels, dtype=float), np.asarray(metres, dtype=float)
    if seen.ndim != 2 or seen.shape[1] != 2 or there.shape != (len(seen), 3):
        raise RequestError(
            f"points are pixels (N, 2) and metres (N, 3), not {seen.shape} and {there.shape}"
        )
    rows = np.column_stack([seen, there]).tolist()
    lines = (",".join(map(repr, row)) + f",point {k}" for k, row in enumerate(rows, 1))
    path.write_text("\n".join(["x_px,y_px,x_m,y_m,z_m,name", *lines]) + "\n", encoding="utf-8")
    return path


@dataclass(frozen=True)
class Checkup:
    """The problems of a project that would spoil its recovery.

    Attributes:
        document: The output of ``unrender check --json``; for several photographs that of the first, with those
            of the others in a list ``further``.
        edges: The model's edges over the photo: green where the photo has them too; red where it
            has them elsewhere, which is yellow; blue where it shows none.
    """

    document: dict[str, Any]
    edges: Picture = field(repr=False)

    @property
    def warnings(self) -> list[str]:
        """The warnings, each with its remedy."""
        return list(self.document.get("warnings", []))

    def _repr_png_(self) -> bytes | None:
        return self.edges._repr_png_()


def check(
    project: Project | StrPath,
    *,
    out: StrPath | None = None,
    threads: int | None = None,
    allow_outside: bool = False,
    allow_missing: bool = False,
    input_memory: float | None = None,
) -> Checkup:
    """Checks a project before it is recovered, and says what to mend.

    Args:
        project: A project, or the path of its file.
        out: A .png file for the picture of the model's edges; by default it is not written.
        threads: How many threads to use; by default one per core.
        allow_outside: Whether scenes may name files outside their folder.
        allow_missing: Whether a scene is read without the files that it names and that are missing.
        input_memory: The memory that a scene or a picture may take while it is read, GiB.
    """
    with ExitStack() as stack:
        place = stack.enter_context(temporary())
        path = stack.enter_context(project_file(project))
        picture = place / "check.png" if out is None else Path(out)
        line = words("check", [str(path)], {"out": picture, "json": True}, allow_outside, input_memory, allow_missing)
        document = json.loads(_called(line, None, None, threads))
        return Checkup(document, read_picture(picture))


@dataclass(frozen=True)
class Proposed:
    """A project that was made for a scene and a photograph.

    Attributes:
        path: The project file.
        summary: What was guessed, what looks wrong, and what to do next, as the command prints it.
    """

    path: Path
    summary: str


def init(
    scene: StrPath,
    photo: StrPath,
    *,
    out: StrPath | None = None,
    threads: int | None = None,
    allow_outside: bool = False,
    allow_missing: bool = False,
    input_memory: float | None = None,
) -> Proposed:
    """Makes a project file for a scene and a photograph.

    Args:
        scene: The path of the scene's file.
        photo: The path of the photograph.
        out: The project file to write, which must not exist; by default project.toml in the present folder.
        threads: How many threads to use; by default one per core.
        allow_outside: Whether scenes may name files outside their folder.
        allow_missing: Whether a scene is read without the files that it names and that are missing.
        input_memory: The memory that a scene or a picture may take while it is read, GiB.
    """
    path = Path("project.toml" if out is None else out)
    line = words("init", [os.fspath(scene), os.fspath(photo)], {"out": path}, allow_outside, input_memory, allow_missing)
    return Proposed(path, _called(line, None, None, threads))


@dataclass(frozen=True)
class Plan:
    """What further photographs would add to the existing ones.

    Attributes:
        candidates: The best first; each with its ``name``, the ``ratio`` of all standard deviations to the present
            ones, its ``camera`` (a table ``[camera]`` of a project), ``lights_off``, and for each of the ``groups``
            its own ``ratio`` and whether it ``is_new``: not shown by any photograph so far.
    """

    candidates: list[dict[str, Any]]


def plan(
    project: Project | StrPath,
    *,
    recovered: Recovery | StrPath,
    effort: str = "draft",
    seed: int = 0,
    progress: Progress = None,
    cancel: CancelToken | None = None,
    threads: int | None = None,
    allow_outside: bool = False,
    allow_missing: bool = False,
    input_memory: float | None = None,
) -> Plan:
    """Suggests which photograph to take next, after a recovery.

    Args:
        project: The project, or the path of its file.
        recovered: Its recovery, or the folder of the results.
        effort: How much work to spend on each candidate: "draft", "normal" or "high".
        seed: The seed of the renderings' noise.
        progress: A callback ``f(done, message)``; or True for a bar of tqdm.
        cancel: A token; when it is cancelled, :class:`Cancelled` is raised.
        threads: How many threads to use; by default one per core.
        allow_outside: Whether scenes may name files outside their folder.
        allow_missing: Whether a scene is read without the files that it names and that are missing.
        input_memory: The memory that a scene or a picture may take while it is read, GiB.
    """
    with ExitStack() as stack:
        path = stack.enter_context(project_file(project))
        folder = stack.enter_context(results_folder(recovered))
        flags = {"recovered": folder, "effort": effort, "seed": seed, "json": True}
        line = words("plan", [str(path)], flags, allow_outside, input_memory, allow_missing)
        return Plan(json.loads(_called(line, progress, cancel, threads))["candidates"])


@dataclass(frozen=True)
class Restaging:
    """New pictures of a recovered scene.

    Attributes:
        pictures: The pictures by the names of their files without extension, linear (H, W, 3).
        folder: The folder to which they were written, if they were kept.
    """

    pictures: dict[str, Picture] = field(repr=False)
    folder: Path | None

    def _repr_png_(self) -> bytes | None:
        return next(iter(self.pictures.values()))._repr_png_() if self.pictures else None


def restage(
    edits: StrPath | None = None,
    *,
    out: StrPath | None = None,
    composite: bool = False,
    grain: bool = False,
    denoise: bool = False,
    aov: bool = False,
    colour_space: str | None = None,
    recovered: Recovery | StrPath | None = None,
    project: Project | StrPath | None = None,
    scene: Scene | StrPath | None = None,
    light_units: str | None = None,
    materials: AnyMaterials | None = None,
    remove: list[str] | None = None,
    repaint: list[str] | None = None,
    light: list[str] | None = None,
    environment: ArrayLike | StrPath | None = None,
    insert: list[str] | None = None,
    camera: str | None = None,
    width: int | None = None,
    height: int | None = None,
    frames: Samples | None = None,
    parts: list[StrPath] | None = None,
    spp: int | None = None,
    time: float | None = None,
    noise: float | None = None,
    adaptive: bool = False,
    samples: Samples | None = None,
    checkpoint: StrPath | None = None,
    seed: int = 0,
    independent: bool = False,
    bounces: int | None = None,
    progress: Progress = None,
    cancel: CancelToken | None = None,
    threads: int | None = None,
    allow_outside: bool = False,
    allow_missing: bool = False,
    input_memory: float | None = None,
) -> Restaging:
    """Renders a recovered scene with edits, or composites the edits into its photograph.

    Args:
        edits: The edit file, as in ``unrender restage --help``.
        out: A folder for the pictures; by default they are not kept.
        composite: Composite the change into the photograph, and leave the rest of it as it is.
        grain: Add the noise of the photograph to the synthetic parts of the composite.
        denoise: Remove noise from the pictures, for a small bias.
        aov: Also write passes.exr for compositing programs, of a composite with shadows and reflections.
        colour_space: The colour space of .exr files, as in :func:`render`.
        recovered: A recovery to start from, or the folder of one.
        project: The project that was recovered, or the path of its file, for its photograph.
        scene: Start from a scene, or from the path of its file.
        light_units: The units of a glTF file's lights.
        materials: Materials for the scene's groups, as in :func:`render`.
        remove: Objects, or groups with all their objects, to remove.
        repaint: Changes of materials of groups: "GROUP: rho_d = [0.5, 0.1, 0.1]".
        light: Changes of lights: "NAME: scale = 0.5".
        environment: A panorama: "FILE.hdr: rotation_deg = 90"; or an array (H, W, 3) of its radiance.
        insert: Models to insert into the scene: "FILE: on = 'GROUP', at = [x, z]".
        camera: The camera of the scene; by default the photograph's.
        width: Pixels in a row; by default the photograph's.
        height: Rows; by default the photograph's.
        frames: Only the pictures (A, B) of a sequence, counted from 1, B not included.
        parts: Use the samples of these parts instead of rendering.
        spp: Samples per pixel; by default 64 without ``time`` and ``noise``.
        time: Stop after this many seconds.
        noise: Stop at this relative standard error.
        adaptive: Take more samples where the picture is noisy.
        samples: Render only the samples (A, B), as a part in ``out``.
        checkpoint: Keep the samples in this .exr file, and continue from there.
        seed: The seed of the noise.
        independent: Trace paths for every pixel alone.
        bounces: The most reflections of a path.
        progress: A callback ``f(done, message)``; or True for a bar of tqdm.
        cancel: A token that ends the work.
        threads: How many threads to use; by default one per core.
        allow_outside: Whether scenes may name files outside their folder.
        allow_missing: Whether a scene is read without the files that it names and that are missing.
        input_memory: The memory that a scene or a picture may take while it is read, GiB.
    """
    with ExitStack() as stack:
        given = stack.enter_context(temporary())
        place = given / "out" if out is None else Path(out)
        name, inner = given_scene(scene, light_units)
        flags: dict[str, object] = {
            "out": place,
            "composite": composite,
            "grain": grain,
            "denoise": denoise,
            "aov": aov,
            "colour_space": colour_space,
            "recovered": stack.enter_context(results_folder(recovered)),
            "project": stack.enter_context(project_file(project)),
            "scene": name,
            "light_units": light_units,
            "materials": materials_file(materials, given / "materials.json"),
            "remove": remove,
            "repaint": repaint,
            "light": light,
            "environment": panorama_file(environment, given / "environment.exr"),
            "insert": insert,
            "camera": camera,
            "width": width,
            "height": height,
            "frames": frames,
            "parts": parts,
            "spp": spp,
            "time": time,
            "noise": noise,
            "adaptive": adaptive,
            "samples": samples,
            "checkpoint": checkpoint,
            "seed": seed,
            "independent": independent,
            "bounces": bounces,
        }
        line = words("restage", [] if edits is None else [edits], flags, allow_outside, input_memory, allow_missing)
        _called(line, progress, cancel, threads, scene=inner)
        files = sorted(place.glob("*.exr")) if samples is None else []
        pictures = {file.stem: read_picture(file) for file in files}
        return Restaging(pictures, None if out is None else place)


def export(
    results: Recovery | StrPath | None = None,
    *,
    scene: Scene | StrPath | None = None,
    materials: AnyMaterials | None = None,
    light_units: str | None = None,
    to: str,
    out: StrPath,
    environment: str | None = None,
    camera: str | None = None,
    width: int | None = None,
    height: int | None = None,
    allow_outside: bool = False,
    allow_missing: bool = False,
    input_memory: float | None = None,
) -> Path:
    """Writes a scene and its materials for another program.

    Args:
        results: A recovery, or the folder of one.
        scene: A scene, or the path of its file, instead of a recovery.
        materials: Materials for the groups of ``scene``, as in :func:`render`.
        light_units: The units of a glTF file's lights.
        to: "blender", "gltf", "materialx", "mitsuba", "pbrt", "radiance" or "usd".
        out: The folder to write; for gltf the .glb file, for usd the .usda, .usdc or .usdz file.
        environment: A panorama instead of the scene's or the recovered environment, as in
            ``"sky.exr: rotation_deg = 90, scale = 0.7"``.
        camera: The camera's name; by default the photograph's, else the scene's first.
        width: Pixels in a row; by default the photograph's.
        height: Rows; by default the photograph's.
        allow_outside: Whether scenes may name files outside their folder.
        allow_missing: Whether a scene is read without the files that it names and that are missing.
        input_memory: The memory that a scene may take while it is read, GiB.

    Returns:
        The path that was written.
    """
    with ExitStack() as stack:
        given = stack.enter_context(temporary())
        folder = stack.enter_context(results_folder(results))
        name, inner = given_scene(scene, light_units)
        flags = {
            "scene": name,
            "materials": materials_file(materials, given / "materials.json"),
            "light_units": light_units,
            "to": to,
            "out": out,
            "environment": environment,
            "camera": camera,
            "width": width,
            "height": height,
        }
        positional = [] if folder is None else [folder]
        line = words("export", positional, flags, allow_outside, input_memory, allow_missing)
        _called(line, None, None, None, scene=inner)
    return Path(out)


@dataclass(frozen=True)
class Score:
    """Recovered materials against the truth.

    Attributes:
        document: The output of ``unrender score --json``.
    """

    document: dict[str, Any]

    @property
    def groups(self) -> Any:
        """The errors of every group."""
        return self.document["groups"]

    @property
    def worst(self) -> dict[str, Any]:
        """The worst errors of all groups that count."""
        worst: dict[str, Any] = self.document["worst"]
        return worst

    @property
    def exceeded(self) -> list[str]:
        """The errors above their limits, a sentence each."""
        return list(self.document["exceeded"])


def score(
    results: AnyMaterials,
    truth: AnyMaterials,
    *,
    max_rho: float | None = None,
    max_alpha_percent: float | None = None,
    max_degrees: float | None = None,
    allow_outside: bool = False,
    input_memory: float | None = None,
) -> Score:
    """Compares the materials of a recovery with known ones.

    Args:
        results: A recovery, its materials, the folder of results, or its materials.json.
        truth: The true materials, in the same forms.
        max_rho: The largest accepted error of rho_d and rho_s.
        max_alpha_percent: The largest accepted error of alpha_x and alpha_y, percent.
        max_degrees: The largest accepted error of the anisotropy direction, degrees.
        allow_outside: Whether materials may name files outside their folder.
        input_memory: The memory that a texture may take while it is read, GiB.
    """
    limits: dict[str, object] = {
        "max_rho": max_rho,
        "max_alpha_percent": max_alpha_percent,
        "max_degrees": max_degrees,
        "json": True,
    }
    with ExitStack() as stack:
        place = stack.enter_context(temporary())
        both = [
            materials_file(value, place / f"{name}.json")
            for value, name in ((results, "results"), (truth, "truth"))
        ]
        line = words("score", [str(path) for path in both], limits, allow_outside, input_memory)
        return Score(json.loads(_called(line, None, None, None, may_fail=True)))


@dataclass(frozen=True)
class BrdfFits:
    """Materials that were fitted to a measured BRDF.

    Attributes:
        document: The output of ``unrender fit-brdf --json``.
    """

    document: dict[str, Any]

    @property
    def fits(self) -> list[dict[str, Any]]:
        """The fits, the simplest first."""
        fits: list[dict[str, Any]] = self.document["fits"]
        return fits

    @property
    def chosen(self) -> dict[str, Any]:
        """The simplest whose error is at most 2 % above the least."""
        chosen: dict[str, Any] = self.fits[self.document["chosen"]]
        return chosen

    @property
    def project(self) -> str:
        """The lines of a project file that state it."""
        project: str = self.document["project"]
        return project


def fit_brdf(
    file: StrPath,
    *,
    model: str | None = None,
    group: str | None = None,
    out: StrPath | None = None,
    threads: int | None = None,
    input_memory: float | None = None,
) -> BrdfFits:
    """Fits the materials of this program to a measured BRDF.

    Args:
        file: The measured BRDF, in MERL's binary format.
        model: Fit this BRDF model alone: "principled", "ggx", "ward-gmd", "ward-1992" or "ward-duer"; by default all.
        group: The group that has the material; by default the name of the file.
        out: A folder for the fits and their picture, or a file for the fits alone (.json); by default nothing is written.
        threads: The number of threads; by default one per core.
        input_memory: The memory that the table may take while it is read, GiB.
    """
    flags: dict[str, object] = {"model": model, "group": group, "out": out, "json": True}
    line = words("fit-brdf", [str(file)], flags, False, input_memory)
    return BrdfFits(json.loads(_called(line, None, None, threads)))


def split(results: Recovery | StrPath, *, out: StrPath, group: str | None = None) -> Path:
    """Writes the scene with those groups split that contain two materials.

    Args:
        results: A recovery, or the folder of one.
        out: The .glb file to write.
        group: Only this group; by default all that have several materials.

    Returns:
        The path that was written.
    """
    flags = {"group": group, "out": out}
    with results_folder(results) as folder:
        positional = [] if folder is None else [folder]
        _called(words("split", positional, flags, False, None), None, None, None)
    return Path(out)


def report(
    runs: Recovery | StrPath | Sequence[Recovery | StrPath],
    *,
    out: StrPath | None = None,
) -> Path:
    """Makes the page of a recovery again, or one that compares several.

    Args:
        runs: A recovery, or the folder of one; or a list of several.
        out: The page (.html); by default, for a single folder: its report.html.

    Returns:
        The path of the page.
    """
    if isinstance(runs, Recovery) and runs.folder is None and out is None:
        raise RequestError("this recovery has no folder; name the page by out=, or save it first")
    with ExitStack() as stack:
        several = [runs] if isinstance(runs, (Recovery, str, os.PathLike)) else list(runs)
        found = [stack.enter_context(results_folder(run)) for run in several]
        folders = [folder for folder in found if folder is not None]
        _called(words("report", folders, {"out": out}), None, None, None)
        return Path(out) if out is not None else folders[0] / "report.html"


def view(
    result: Recovery | StrPath,
    *,
    project: StrPath | None = None,
    out: StrPath | None = None,
    no_open: bool = False,
    spp: int = 64,
    seed: int = 0,
    threads: int | None = None,
    input_memory: float | None = None,
    progress: Progress = None,
    cancel: CancelToken | None = None,
) -> Page:
    """Makes a page on which the lamps and the colours of a result are played with.

    Args:
        result: A recovery, or the folder of one.
        project: Its project; by default the one that it names, else its own scene and photograph.
        out: The page (.html); by default view.html in the folder of the result.
        no_open: Do not open the page in a browser.
        spp: Samples per pixel.
        seed: Chooses the noise.
        threads: The number of threads; by default one a core.
        input_memory: The memory that a picture may take while it is read, GiB.
        progress: As of :func:`render`.
        cancel: Cancels the work from another thread.

    Returns:
        The page; a recovery without a folder leaves no file.
    """
    with results_folder(result) as folder:
        assert folder is not None
        page = Path(out) if out is not None else folder / "view.html"
        is_kept = out is not None or not isinstance(result, Recovery) or result.folder is not None
        # A browser would open a file that is gone by then.
        no_open = no_open or not is_kept
        flags = {"project": project, "out": out, "no_open": no_open, "spp": spp, "seed": seed}
        _called(words("view", [folder], flags, False, input_memory), progress, cancel, threads)
        return Page(page.read_text(encoding="utf-8"), page if is_kept else None)


def _called(
    line: list[str],
    progress: Progress,
    cancel: CancelToken | None,
    threads: int | None,
    may_fail: bool = False,
    scene: _unrender.Scene | None = None,
) -> str:
    """The output of a command; a ``scene`` in memory replaces its scene file."""
    controls: Control
    with control(progress, cancel, threads) as controls:
        text, succeeded, signalled = _unrender.call(line, controls, scene)
    if signalled:
        raise Interrupted
    if not succeeded and not may_fail:
        raise Cancelled("the work was cancelled before it had a result")
    return text
