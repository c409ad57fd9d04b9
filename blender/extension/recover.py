# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 3, recover: in the background, with progress and a way to cancel."""

import os

import bpy
import unrender

from . import job, model, pictures, prepare
from .preview import Preview

RERENDERED = "unrender re-rendering"
PARAMETERS = ("rho_d", "rho_s", "alpha_x", "alpha_y", "theta_deg")


class UNRENDER_OT_recover(bpy.types.Operator):
    """Recover the materials from the photograph, in the background"""

    bl_idname = "unrender.recover"
    bl_label = "Recover"

    wait: bpy.props.BoolProperty(default=False, options={"SKIP_SAVE", "HIDDEN"})

    @classmethod
    def poll(cls, context):
        settings = context.scene.unrender
        return bool(settings.photo or settings.shots) and not job.is_running()

    def execute(self, context):
        if not context.scene.unrender.groups:
            prepare.refresh(context)
        try:
            path, _, doubts = model.project_of(context)
        except (unrender.Error, model.Missing) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        out, spp = os.path.join(os.path.dirname(path), "result"), context.scene.unrender.spp

        offered = []

        def work(progress, token):
            look = Preview(path, offered.append)
            return unrender.recover(path, out=out, spp=spp, progress=progress, on_iteration=look, cancel=token)

        def look():
            if offered:
                pictures.show(pictures.load(offered.pop(), RERENDERED))
                offered.clear()

        started = job.start("Recover", context.scene, work, lambda ended: show(ended, doubts), look)
        return job.finish(self, started, self.wait)


class UNRENDER_OT_cancel(bpy.types.Operator):
    """End the work; of a recovery, the best state so far stays"""

    bl_idname = "unrender.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, context):
        return job.is_running()

    def execute(self, context):
        job.current.token.cancel()
        return {"FINISHED"}


def show(ended, doubts):
    """The recovery in the panel, its re-rendering in the image editor."""
    scene = bpy.data.scenes[ended.scene]
    settings, recovery = scene.unrender, ended.result
    settings.results.clear()
    made = {m.unrender_original: m for m in bpy.data.materials if m.unrender_original is not None}
    for name, entry in recovery.materials.items():
        material = by_full_name(name)
        if material is None or entry.get("status") in ("known", "ignored"):
            continue
        item = settings.results.add()
        item.name, item.material = name, material
        item.made = made.get(material)
        item.hypothesis, item.status = entry.get("hypothesis", ""), entry.get("status", "")
        item.note, item.numbers = entry.get("note") or "", "\n".join(numbers(entry))
    settings.messages = "\n".join(dict.fromkeys([*doubts, *ended.doubts, *recovery.warnings]))
    settings.message = recovery.termination
    # Of several the last: that of step 1, if there is one.
    count = recovery.photographs
    name = "rerendered.png" if count < 2 else f"rerendered_{count}.png"
    picture = recovery.folder / name if recovery.folder else None
    if picture is not None and picture.is_file():
        pictures.show(pictures.load(str(picture), RERENDERED))


def by_full_name(name):
    """The material of this name, those of libraries included."""
    return next((m for m in bpy.data.materials if m.name_full == name), None)


def numbers(entry):
    """The parameters of a group with their standard deviations, a line each."""
    std = entry.get("std") or {}
    for name in PARAMETERS:
        values = entry.get(name)
        if values is None or (name != "rho_d" and not is_free(entry, name)):
            continue
        yield f"{name} {texts(values)}" + (f" ± {texts(std[name])}" if std.get(name) is not None else "")
    if entry.get("texture"):
        yield "with a texture"


def is_free(entry, name):
    """Whether a parameter has a meaning for this group."""
    if max(entry.get("rho_s") or [0.0]) == 0.0:
        return False
    is_rough = entry.get("alpha_x", 0.0) > 0.0
    is_round = entry.get("alpha_x") == entry.get("alpha_y")
    return {"rho_s": True, "alpha_x": is_rough}.get(name, is_rough and not is_round)


def texts(values):
    """Numbers with three significant digits."""
    return " ".join(f"{v:.3g}" for v in (values if isinstance(values, list) else [values]))


CLASSES = (UNRENDER_OT_recover, UNRENDER_OT_cancel)


def register():
    bpy.types.Material.unrender_original = bpy.props.PointerProperty(
        type=bpy.types.Material, name="Made from", description="The material from which this one was made"
    )
    for made in CLASSES:
        bpy.utils.register_class(made)


def unregister():
    for made in reversed(CLASSES):
        bpy.utils.unregister_class(made)
    del bpy.types.Material.unrender_original
