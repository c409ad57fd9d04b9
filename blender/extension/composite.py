# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 5, composite: inserts objects into the photograph, with their shadows and reflections."""

import json
import os

import bpy
import unrender
from bpy.props import BoolProperty

from . import geometry, job, model, pictures

COMPOSITE = "unrender composite"


class UNRENDER_OT_mark_inserted(bpy.types.Operator):
    """Mark the selected objects as missing in the photograph: they are not part of the model, and Composite
    inserts them into the photograph"""

    bl_idname = "unrender.mark_inserted"
    bl_label = "Not in the photograph"
    bl_options = {"REGISTER", "UNDO"}

    clear: BoolProperty(name="Take back", description="The photograph does show them")

    @classmethod
    def poll(cls, context):
        return bool(context.selected_objects)

    def execute(self, context):
        for thing in context.selected_objects:
            if not self.clear:
                thing[geometry.INSERTED] = True
            elif geometry.INSERTED in thing:
                del thing[geometry.INSERTED]
        return {"FINISHED"}


class UNRENDER_OT_composite(bpy.types.Operator):
    """Insert the selected objects that are marked as not in the photograph into it"""

    bl_idname = "unrender.composite"
    bl_label = "Composite"

    wait: BoolProperty(default=False, options={"SKIP_SAVE", "HIDDEN"})

    @classmethod
    def poll(cls, context):
        return bool(context.scene.unrender.results) and not job.is_running()

    def execute(self, context):
        settings, folder = context.scene.unrender, model.folder_of(context.scene)
        try:
            doubts = write_edit(context, folder)
        except (unrender.Error, model.Missing) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        options = {"spp": settings.spp, "grain": settings.grain, "composite": True}
        edit, out = os.path.join(folder, "insert.toml"), os.path.join(folder, "composite")

        def work(progress, token):
            return unrender.restage(edit, out=out, progress=progress, cancel=token, **options)

        started = job.start("Composite", context.scene, work, lambda ended: show(ended, doubts))
        return job.finish(self, started, self.wait)


def write_edit(context, folder):
    """Writes the edit file with the selected objects as a model; returns warnings."""
    chosen = {thing for thing in context.selected_objects if thing.get(geometry.INSERTED)}
    if not chosen:
        raise model.Missing("Select objects, and mark them as not in the photograph")
    if not os.path.isfile(os.path.join(folder, "result", "materials.json")):
        raise model.Missing("Recover the materials first")

    def wanted(thing, owner):
        return thing in chosen or owner in chosen

    inserted, *_, doubts = model.scene_of(context, wanted, with_lights=False)
    inserted.save(os.path.join(folder, "inserted.glb"))
    # JSON strings are valid in TOML, too.
    lines = [
        f"recovered = {json.dumps('result')}",
        f"project = {json.dumps('project.toml')}",
        "[[insert]]",
        f"file = {json.dumps('inserted.glb')}",
        "position = [0.0, 0.0, 0.0]",
    ]
    with open(os.path.join(folder, "insert.toml"), "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    return doubts


def show(ended, doubts):
    """The composite in the image editor."""
    scene = bpy.data.scenes[ended.scene]
    scene.unrender.messages = "\n".join(dict.fromkeys([*doubts, *ended.doubts]))
    picture = ended.result.folder / "composite.png"
    if not picture.is_file():
        scene.unrender.message = "Composite: cancelled"
        return
    image = pictures.load(str(picture), COMPOSITE)
    pictures.show(image)
    scene.unrender.message = f"Composite: {picture}"


CLASSES = (UNRENDER_OT_mark_inserted, UNRENDER_OT_composite)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
