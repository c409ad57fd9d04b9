"""From one photograph and a 3D scene to the reflectance of every surface.

The verbs are those of the command ``unrender``, with its options as keyword arguments:

>>> import unrender
>>> recovery = unrender.recover("room.toml", progress=True)   # doctest: +SKIP
>>> recovery.materials["floor"]["rho_d"]                       # doctest: +SKIP
[0.1, 0.1, 0.1]
>>> picture = unrender.render("room.glb", materials=recovery)  # doctest: +SKIP

Pictures are ``float32`` arrays (H, W, 3) of linear RGB, the top row first. Lengths are metres, y is up,
radiance is in W sr^-1 m^-2 per channel.
"""

from __future__ import annotations

from ._control import Bar, CancelToken
from .errors import (
    CalibrateError,
    Cancelled,
    Error,
    FileError,
    Interrupted,
    RecoverError,
    RequestError,
    SceneError,
    UnrenderWarning,
)
from .materials import Materials
from .page import Page
from .pictures import Picture, read_picture
from .project import Project
from .recovery import Covariance, Recovery, recover
from .rendering import merge, merge_exposures, relight, render
from .scene import Camera, Group, Light, Mesh, Scene
from .verbs import (
    Calibration,
    Checkup,
    Plan,
    Proposed,
    Restaging,
    Score,
    calibrate,
    check,
    export,
    fit_brdf,
    init,
    plan,
    report,
    restage,
    score,
    split,
    view,
)

__all__ = [
    "Bar",
    "CalibrateError",
    "Calibration",
    "Camera",
    "Cancelled",
    "CancelToken",
    "Checkup",
    "Covariance",
    "Error",
    "FileError",
    "Group",
    "Interrupted",
    "Light",
    "Materials",
    "Mesh",
    "Page",
    "Picture",
    "Plan",
    "Proposed",
    "Project",
    "RecoverError",
    "Recovery",
    "RequestError",
    "Restaging",
    "Scene",
    "SceneError",
    "Score",
    "UnrenderWarning",
    "calibrate",
    "check",
    "export",
    "fit_brdf",
    "init",
    "merge",
    "merge_exposures",
    "plan",
    "read_picture",
    "recover",
    "relight",
    "render",
    "report",
    "restage",
    "score",
    "split",
    "view",
]
