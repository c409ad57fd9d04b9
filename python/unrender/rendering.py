"""The command ``unrender render`` as a function, and further functions of pictures."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from . import _unrender
from ._control import CancelToken, Control, Progress, Samples, StrPath, control, words
from ._files import materials_file, panorama_file, project_file, temporary
from .errors import Cancelled, Interrupted, RequestError
from .materials import Materials, Parts
from .pictures import Picture, read_picture
from .project import IN_MEMORY, Project
from .recovery import Recovery
from .scene import Camera, Scene

__all__ = ["merge", "merge_exposures", "relight", "render"]


def render(
    scene: Scene | StrPath | None = None,
    *,
    project: Project | StrPath | None = None,
    photo: int | None = None,
    materials: Materials | Recovery | Mapping[str, Any] | StrPath | None = None,
    light_units: str | None = None,
    environment: ArrayLike | StrPath | None = None,
    environment_rotation: float = 0.0,
    environment_scale: float = 1.0,
    camera: Camera | str | None = None,
    width: int | None = None,
    height: int | None = None,
    denoise: bool = False,
    layers: bool = False,
    aov: bool = False,
    colour_space: str | None = None,
    exposure: float | None = None,
    spp: int | None = None,
    time: float | None = None,
    noise: float | None = None,
    adaptive: bool = False,
    samples: Samples | None = None,
    checkpoint: StrPath | None = None,
    seed: int = 0,
    independent: bool = False,
    bounces: int | None = None,
    out: StrPath | None = None,
    progress: Progress = None,
    cancel: CancelToken | None = None,
    threads: int | None = None,
    allow_outside: bool = False,
    allow_missing: bool = False,
    input_memory: float | None = None,
) -> Picture:
    """Renders a scene, or the scene of a project.

    The picture equals that of ``unrender render --out FILE.exr`` with the same arguments to the
    bit, for any number of threads.

    Args:
        scene: A scene, or the path of its file.
        project: Instead of a scene: a project's scene with its lights and its environment, by its
            camera, as large as its photograph.
        photo: The number of a project's photograph, from 1: its camera and size, and the lamps that were on;
            by default the first.
        materials: Materials for the scene's groups: the path of a materials.json or of a folder of
            results, a dict like it or like its groups, Materials, or a Recovery.
        light_units: The units of a glTF file's lights: "blender-standard", "unitless",
            "blender-raw" or "radiometric"; by default as its generator writes them.
        environment: A panorama that lights the scene from all around (.hdr, .exr); or an array
            (H, W, 3) of its radiance.
        environment_rotation: Turns it about +y, counter-clockwise seen from above, degrees.
        environment_scale: Multiplies its radiance.
        camera: A camera, or the name of one of the scene; by default the project's, else the
            scene's first.
        width: Pixels in a row; by default by the height and the camera's aspect.
        height: Rows; by default by the width and the camera's aspect, else 512.
        denoise: Remove noise from the picture, for a small bias. Its ``noise`` is then the relative error
            with the bias, from two halves of the samples.
        layers: Also write the contribution of each light, as layers of the file ``out``, a .exr;
            with these :func:`relight` makes lights brighter and darker.
        aov: Also write what compositing programs want, as layers of the file ``out``, a .exr: the contribution
            of each light, direct and indirect light, albedo, normal, position, depth, and Cryptomatte by group.
        colour_space: The colour space of the file ``out``, a .exr: "lin-rec709", "acescg", "lin-p3d65",
            "lin-rec2020" or "aces2065-1"; by default the first. The result has that of Rec. 709 in any case.
        exposure: Makes the picture brighter by this many stops; by default none.
        spp: Samples per pixel, on average; with ``time`` or ``noise`` the most. By default 64
            without those.
        time: Stop after this many seconds; the number of samples then depends on the machine.
        noise: Stop when the relative standard error of the picture is at most this.
        adaptive: Take more samples where the picture is noisy.
        samples: Render only the samples (A, B), B not included. With ``out``, then a .exr file, the
            result is a part that :func:`merge` merges with others.
        checkpoint: Keep the samples in this .exr file, and continue from there.
        seed: The seed of the noise.
        independent: Trace paths for every pixel alone.
        bounces: The most reflections of a path; by default until it carries nothing more.
        out: A file for the picture: .exr, .hdr or .png.
        progress: A callback ``f(done, message)``; or True for a bar of tqdm.
        cancel: A token; when it is cancelled, the picture is returned with its samples so far.
        threads: How many threads to use; by default one per core.
        allow_outside: Whether scenes and materials may name files outside their folder.
        allow_missing: Whether a scene is read without the files that it names and that are missing.
        input_memory: The memory that a scene or a picture may take while it is read, GiB.

    Returns:
        Radiance in W sr^-1 m^-2 per channel of linear RGB: float32, (H, W, 3), the top row first.

    Raises:
        Error: If the input cannot be used.
        Interrupted: On Ctrl-C, with the samples so far in ``picture``.
    """
    if (scene is None) == (project is None):
        raise RequestError("give either a scene or a project")
    flags: dict[str, object] = {
        "photo": photo,
        "light_units": light_units,
        "width": width,
        "height": height,
        "denoise": denoise,
        "layers": layers,
        "aov": aov,
        "colour_space": colour_space,
        "exposure": exposure,
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
    if environment is not None or (environment_rotation, environment_scale) != (0.0, 1.0):
        flags["environment_rotation"] = environment_rotation
        flags["environment_scale"] = environment_scale
    if isinstance(camera, Camera):
        if project is not None:
            raise RequestError("a project has its own camera; name one of its scene, or give a scene")
        scene = _scene(scene, light_units, allow_outside, allow_missing).with_camera(camera)
        flags["light_units"] = None
        flags["camera"] = camera.name
    else:
        flags["camera"] = camera
    if (layers or aov) and out is None:
        raise RequestError("light layers are written to a file: give out")
    if colour_space is not None and out is None:
        raise RequestError("a colour space is that of a file: give out")
    inner = scene._inner if isinstance(scene, Scene) else None
    positional = [] if scene is None else [IN_MEMORY if isinstance(scene, Scene) else scene]
    with ExitStack() as stack:
        controls = stack.enter_context(control(progress, cancel, threads))
        place = stack.enter_context(temporary())
        flags["project"] = stack.enter_context(project_file(project))
        flags["environment"] = panorama_file(environment, place / "environment.exr")
        if out is not None and (layers or aov or colour_space is not None or samples is not None):
            # The command makes samples, light layers and other colour spaces, from files.
            flags["materials"] = materials_file(materials, place / "materials.json")
            flags["out"] = os.fspath(out)
            line = words("render", positional, flags, allow_outside, input_memory, allow_missing)
            return _written(line, inner, out, controls)
        parts = None if materials is None else Parts(_materials(materials))
        flags["out"] = f"{IN_MEMORY}.exr"
        line = words("render", positional, flags, allow_outside, input_memory, allow_missing)
        return _rendered(line, (inner, parts), out, controls)


def merge(
    parts: list[StrPath] | list[str] | list[Path],
    *,
    allow_gaps: bool = False,
    out: StrPath,
) -> Picture:
    """Merges parts of a rendering into the picture of one run, to the bit.

    Args:
        parts: The files that ``render(..., samples=(A, B), out=...)`` wrote, in any order.
        allow_gaps: Allow missing samples between the parts.
        out: The picture to write: .exr, .hdr or .png.

    Returns:
        The picture in that file, (H, W, 3).
    """
    with control(None, None, None) as controls:
        line = words("merge", list(parts), {"allow_gaps": allow_gaps, "out": out})
        _unrender.call(line, controls)
    return read_picture(out)


def relight(
    layers: StrPath,
    *,
    light: Mapping[str, float | Sequence[float]] | None = None,
    only: list[str] | None = None,
    colour_space: str | None = None,
    exposure: float | None = None,
    out: StrPath,
    allow_outside: bool = False,
    input_memory: float | None = None,
) -> Picture:
    """Makes lights of a rendering brighter or darker, at once: by the sum of its light layers.

    Args:
        layers: The file that ``render(..., layers=True, out=...)`` wrote, or one with ``aov=True``.
        light: The factor on the brightness of lights, by name: one for all channels, or three for
            red, green and blue. 0 is off; lights that are not named stay as they are.
        only: The lights that are on; all others are off.
        colour_space: The colour space of a .exr file, as in :func:`render`.
        exposure: Makes the picture brighter by this many stops.
        out: The picture to write: .exr, .hdr or .png.
        allow_outside: Whether files outside their folder may be named.
        input_memory: The memory that the layers may take while they are read, GiB.

    Returns:
        The picture in that file, (H, W, 3).
    """
    factors = (
        (name, factor if isinstance(factor, Sequence) else [factor]) for name, factor in (light or {}).items()
    )
    flags = {
        "light": [f"{name}={','.join(map(str, numbers))}" for name, numbers in factors],
        "only": only,
        "colour_space": colour_space,
        "exposure": exposure,
        "out": out,
    }
    with control(None, None, None) as controls:
        _unrender.call(words("relight", [layers], flags, allow_outside, input_memory), controls)
    return read_picture(out)


def merge_exposures(
    photos: list[StrPath] | list[str] | list[Path],
    *,
    times: list[float] | list[str] | None = None,
    response: StrPath | None = None,
    black_level: float = 0.0,
    white_level: float | None = None,
    response_out: StrPath | None = None,
    out: StrPath,
    allow_outside: bool = False,
    input_memory: float | None = None,
) -> Picture:
    """Merges photographs of several exposures into one linear picture.

    Args:
        photos: The photographs, in any order: of one scene by one camera that did not move.
        times: Their exposure times in the same order, seconds or "1/60"; by default exposure time, ISO
            number and f-number by EXIF.
        response: The camera's response: "srgb", "linear", or a file as for projects; by default it is
            found from the photographs.
        black_level: The pixel value of no light, where 1 is white.
        white_level: The pixel value from which on the photographs are clipped; by default the greatest of
            the file, none for floating-point files.
        response_out: A .csv file for the response that was found, for use as ``response``.
        out: The picture to write, .exr: with its variances, which a project that has it as its photo uses.
        allow_outside: Whether files outside their folder may be named.
        input_memory: The memory that a picture may take while it is read, GiB.

    Returns:
        The picture in that file, (H, W, 3): 1 is the white of the best exposed photograph.
    """
    flags = {
        "times": None if times is None else ",".join(map(str, times)),
        "response": response,
        "black_level": black_level,
        "white_level": white_level,
        "response_out": response_out,
        "out": out,
    }
    with control(None, None, None) as controls:
        line = words("merge-exposures", list(photos), flags, allow_outside, input_memory)
        _unrender.call(line, controls)
    return read_picture(out)


def _rendered(
    line: list[str],
    given: tuple[_unrender.Scene | None, Parts | None],
    out: StrPath | None,
    controls: Control,
) -> Picture:
    radiance, _, _, _, signalled = _unrender.render(line, *given, controls)
    picture = None if radiance is None else Picture(radiance)
    if signalled or picture is None:
        raise Interrupted(picture=picture)
    if out is not None:
        picture.save(out)
    return picture


def _written(
    line: list[str], scene: _unrender.Scene | None, out: StrPath, controls: Control
) -> Picture:
    _, succeeded, signalled = _unrender.call(line, controls, scene)
    if signalled:
        raise Interrupted
    if not succeeded:
        raise Cancelled("the work was cancelled before it had a result")
    return read_picture(out)


def _scene(
    scene: Scene | StrPath | None, light_units: str | None, allow_outside: bool, allow_missing: bool
) -> Scene:
    if isinstance(scene, Scene):
        return scene
    if scene is None:
        raise RequestError("give a scene")
    return Scene.read(
        scene, light_units=light_units, allow_outside=allow_outside, allow_missing=allow_missing
    )


def _materials(value: Materials | Recovery | Mapping[str, Any] | StrPath) -> Materials:
    return value.materials if isinstance(value, Recovery) else Materials.of(value)
