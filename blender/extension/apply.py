# SPDX-License-Identifier: GPL-3.0-or-later
"""Step 4, apply: recovered materials as node trees beside the old ones, and the way back in one
click."""

import json
import os
import tempfile
import warnings

import bpy
import unrender

from . import job, model, nodes

SUFFIX = " (recovered)"
KEYS = ("rho_d", "rho_s", "alpha_x", "alpha_y", "theta_deg", "emission")


class UNRENDER_OT_apply(bpy.types.Operator):
    """Assign the recovered materials to the objects, as new materials beside the old ones"""

    bl_idname = "unrender.apply"
    bl_label = "Apply"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return bool(context.scene.unrender.results) and not job.is_running()

    def execute(self, context):
        settings = context.scene.unrender
        result = os.path.join(model.folder_of(context.scene), "result")
        try:
            with tempfile.TemporaryDirectory(prefix="unrender-") as folder:
                entries = exported(result, folder)
                for item in settings.results:
                    if item.name in entries:
                        make(item, *entries[item.name], folder)
        except (unrender.Error, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        swaps = {item.material: item.made for item in settings.results if item.made}
        missed = exchange(swaps)
        settings.is_applied = True
        if missed:
            names = ", ".join(sorted(missed))
            self.report({"WARNING"}, f"no object has a slot with {names}: nodes or a library set it")
        return {"FINISHED"}


class UNRENDER_OT_revert(bpy.types.Operator):
    """Assign the old materials again; the recovered ones stay in the file"""

    bl_idname = "unrender.revert"
    bl_label = "Back"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.scene.unrender.is_applied

    def execute(self, context):
        settings = context.scene.unrender
        exchange({item.made: item.material for item in settings.results if item.made})
        settings.is_applied = False
        return {"FINISHED"}


def exported(result, folder):
    """The description of every group for Cycles, with its parameters: (entry, group) by name."""
    recovery = unrender.Recovery.read(result)
    with warnings.catch_warnings():
        # The warnings are about parts that an exported scene lacks; lamps and world exist here.
        warnings.simplefilter("ignore", unrender.UnrenderWarning)
        unrender.export(result, to="blender", out=os.path.join(folder, "export"))
    with open(os.path.join(folder, "export", "scene.json"), encoding="utf-8") as file:
        document = json.load(file)
    found = {}
    for entry in document["groups"]:
        material = recovery.materials.get(entry["name"])
        if material is not None:
            known = {**{"theta_deg": 0.0, "alpha_x": 0.0, "alpha_y": 0.0}, **material}
            group = {key: known[key] for key in KEYS if known.get(key) is not None}
            found[entry["name"]] = entry, {**group, "emission": entry["emission"]}
    return found


def make(item, entry, group, folder):
    """The new material of a result, or the existing one, with new nodes."""
    if item.made is None:
        item.made = bpy.data.materials.new(item.material.name + SUFFIX)
        item.made.unrender_original = item.material
        # It stays in the file without users when the old one is assigned again.
        item.made.use_fake_user = True
    both = {item.material, item.made}
    users = [thing for thing in bpy.data.objects if has_one_of(thing, both)]
    has_uvs = any(getattr(thing.data, "uv_layers", None) for thing in users)
    nodes.build(item.made, entry, group, os.path.join(folder, "export"), has_uvs)


def has_one_of(thing, materials):
    """Whether an object has one of the materials in a slot."""
    return any(slot.material in materials for slot in thing.material_slots)


def exchange(swaps):
    """Replaces materials in the slots; returns the names of those that no slot has afterwards."""
    missed = {made: material.name for material, made in swaps.items()}
    for thing in bpy.data.objects:
        for slot in thing.material_slots:
            made = swaps.get(slot.material)
            if made is not None and thing.library is None:
                if slot.link == "DATA" and thing.data.library is not None:
                    # The slot is linked to the object, which is not in a library.
                    slot.link = "OBJECT"
                slot.material = made
            missed.pop(slot.material, None)
    return set(missed.values())


CLASSES = (UNRENDER_OT_apply, UNRENDER_OT_revert)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
