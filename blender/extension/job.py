# SPDX-License-Identifier: GPL-3.0-or-later
"""Work in the background: a thread, and a timer that passes its messages to the panel.

The package releases Python's lock while it works, so that Blender stays usable. Only the timer, which
Blender calls in its own thread, touches Blender's data.
"""

import threading
import time
import warnings

import bpy
import unrender

INTERVAL = 0.2
"""Seconds between two checks of the work: half of it draws the panel twice as often, double lags
visibly."""

current = None
"""The running work, or the last one."""


class Job:
    """One piece of work, for one scene."""

    def __init__(self, title, scene, work, done, look):
        """Starts ``work(progress, token)``. In Blender's thread, ``look()`` is called now and then, and
        ``done(job)`` at the end."""
        self.title, self.scene, self._done, self._look = title, scene.name, done, look
        self.token = unrender.CancelToken()
        self.fraction, self.message = 0.0, ""
        self.result, self.error, self.doubts = None, None, []
        self.is_over = False
        self._thread = threading.Thread(target=self._run, args=[work], daemon=True)
        scene.unrender.running, scene.unrender.progress = title, 0.0
        self._thread.start()

    def _run(self, work):
        try:
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always", unrender.UnrenderWarning)
                self.result = work(self._heard, self.token)
            self.doubts = [str(w.message) for w in told if issubclass(w.category, unrender.UnrenderWarning)]
        except Exception as error:  # The panel shows any error, as a thread has no caller.
            self.error = error

    def _heard(self, fraction, message):
        self.fraction, self.message = fraction, message

    def poll(self):
        """Passes progress to the panel, and at the end the result; returns whether the work
        continues."""
        if self.is_over:
            return False
        goes_on = self._thread.is_alive()
        scene = bpy.data.scenes.get(self.scene)
        if scene is not None and scene.unrender.running != self.title:
            # Another file was loaded, which has a scene of the same name.
            scene = None
        if scene is not None:
            scene.unrender.progress = self.fraction
            scene.unrender.message = self.message
            self._look()
        if not goes_on:
            self._thread.join()
            self.is_over = True
            if scene is not None:
                scene.unrender.running = ""
                if self.error is not None:
                    scene.unrender.message = f"{self.title}: {self.error}"
                else:
                    self._done(self)
        redraw()
        return goes_on

    def wait(self):
        """Waits until it has ended."""
        while self.poll():
            time.sleep(0.02)
        if self.error is not None:
            raise self.error


def start(title, scene, work, done, look=lambda: None):
    """Starts a job, and its timer."""
    global current
    current = Job(title, scene, work, done, look)
    made = current

    def look():
        return INTERVAL if made.poll() else None

    bpy.app.timers.register(look, first_interval=INTERVAL, persistent=True)
    return made


def is_running():
    """Whether work is running."""
    return current is not None and not current.is_over


def redraw():
    """Draws all panels again."""
    for window in getattr(bpy.context.window_manager, "windows", []):
        for area in window.screen.areas:
            if area.type in {"VIEW_3D", "IMAGE_EDITOR", "PROPERTIES"}:
                area.tag_redraw()


def finish(operator, job, waits):
    """The end of an operator that has started ``job``: without a window, timers do not run."""
    if not (waits or bpy.app.background):
        return {"FINISHED"}
    try:
        job.wait()
    except unrender.Error as error:
        operator.report({"ERROR"}, str(error))
        return {"CANCELLED"}
    return {"FINISHED"}
