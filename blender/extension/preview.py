# SPDX-License-Identifier: GPL-3.0-or-later
"""The re-rendering during a recovery, with its present materials: first noisy, then cleaner."""

import os
import time
import warnings

import numpy as np
import unrender

SHARE = 0.1
"""The share of the time that previews may take: half of it shows half as many, double noticeably slows
the recovery."""

FINEST = 16
"""The most samples per pixel. The first preview has one, each further one twice as many as the one
before: as the materials settle, the picture gets clear. Half of it stays noisy, double makes the
last ones rare."""


class Preview:
    """Renders the project of a recovery with the materials of an iteration, as often as the limit
    of time allows."""

    def __init__(self, project, offer):
        """``offer(path)`` is called for each picture that was written beside the project."""
        self._project, self._offer = os.fspath(project), offer
        self._path = os.path.join(os.path.dirname(self._project), "preview.png")
        self._spp, self._next = 1, 0.0
        document = unrender.Project.read(project).document
        # Of several the last: that of step 1, if there is one.
        self._photo = len(document.get("photos", [])) or None
        exposure = document.get("exposure", "auto" if self._photo else 1.0)
        self._exposure = None if isinstance(exposure, str) else np.asarray(exposure, np.float32)

    def __call__(self, materials):
        """Runs on the thread of the work, which continues meanwhile."""
        begun = time.monotonic()
        if begun < self._next:
            return
        try:
            self._render(materials)
        except (unrender.Error, OSError):
            # It is only a preview: the recovery continues without it.
            self._next = float("inf")
            return
        self._spp = min(2 * self._spp, FINEST)
        self._next = time.monotonic() + (time.monotonic() - begun) / SHARE

    def _render(self, materials):
        with warnings.catch_warnings():
            # The recovery has shown these warnings already.
            warnings.simplefilter("ignore")
            seen = unrender.render(project=self._project, photo=self._photo, materials=materials, spp=self._spp)
        light = np.asarray(seen)
        # An unknown exposure is not found yet: the preview is as bright as a photograph usually is.
        exposure = self._exposure if self._exposure is not None else max(float(np.quantile(light, 0.98)), 1e-9)
        half = os.path.join(os.path.dirname(self._path), "preview.part.png")
        unrender.Picture(np.ascontiguousarray(light / exposure, dtype=np.float32)).save(half)
        # Blender may be reading the previous one.
        os.replace(half, self._path)
        self._offer(self._path)
