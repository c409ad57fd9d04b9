# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel "unrender" in the sidebar of the 3D view: five steps, in the order of the work."""

import textwrap

import bpy

from . import match
from .geometry import INSERTED
from .properties import UNKNOWN

COLUMNS = 44
"""Characters of a line of text in a sidebar of the default width."""


def lines(layout, text, icon="NONE"):
    """Text in lines as long as the sidebar is wide."""
    column = layout.column(align=True)
    for paragraph in text.splitlines():
        for line in textwrap.wrap(paragraph, COLUMNS) or [""]:
            column.label(text=line, icon=icon)
            icon = "BLANK1" if icon != "NONE" else "NONE"


class UNRENDER_UL_pairs(bpy.types.UIList):
    """Pairs, with their errors; wrong ones are red."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        row = layout.row(align=True)
        row.alert = item.rejected
        row.prop(item, "name", text="", emboss=False)
        row.label(text="" if item.error == UNKNOWN else f"{item.error:.1f} px")
        row.label(text="wrong" if item.rejected else "", icon="ERROR" if item.rejected else "NONE")


class UNRENDER_UL_shots(bpy.types.UIList):
    """Photographs that are kept, with their cameras."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        row = layout.row(align=True)
        row.label(text=item.name, icon="IMAGE_DATA")
        row.label(text=item.camera.name if item.camera is not None else "no camera")


class UNRENDER_UL_groups(bpy.types.UIList):
    """Materials, with ticks."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        row = layout.row(align=True)
        row.label(text=item.name, icon="LIGHT" if item.emits else "MATERIAL")
        row.label(text=f"{item.pixels} px" if item.pixels else "")
        row.prop(item, "known")
        row.prop(item, "ignored")


class UNRENDER_UL_results(bpy.types.UIList):
    """The results; doubtful ones are red."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        row = layout.row(align=True)
        row.alert = item.status == "doubtful"
        row.label(text=item.name, icon="MATERIAL")
        row.label(text=item.hypothesis)
        row.label(text=item.status)


class Step:
    """The common part of the steps."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "unrender"


class UNRENDER_PT_match(Step, bpy.types.Panel):
    """Step 1."""

    bl_label = "1. Match camera"

    def draw(self, context):
        layout, settings = self.layout, context.scene.unrender
        if settings.shots:
            row = layout.row()
            row.template_list("UNRENDER_UL_shots", "", settings, "shots", settings, "shot", rows=2)
            column = row.column(align=True)
            column.operator("unrender.use_photo", text="", icon="OUTLINER_OB_CAMERA")
            column.operator("unrender.forget_photo", text="", icon="REMOVE")
        layout.operator("unrender.load_photo", icon="IMAGE_DATA")
        if not settings.photo:
            return
        width, height = settings.size
        layout.label(text=f"{bpy.path.basename(settings.photo)}, {width} x {height}")
        row = layout.row(align=True)
        row.operator("unrender.lines_camera", icon="AXIS_FRONT")
        row.prop(settings, "camera_height")
        row = layout.row()
        row.template_list("UNRENDER_UL_pairs", "", settings, "pairs", settings, "pair", rows=4)
        column = row.column(align=True)
        column.operator("unrender.pick_pair", text="", icon="EYEDROPPER")
        column.operator("unrender.remove_pair", text="", icon="REMOVE").index = -1
        row = layout.row()
        row.prop(settings, "held_fov")
        row.prop(settings, "principal_point")
        missing = match.least(settings) - len(settings.pairs)
        if missing > 0:
            layout.label(text=f"{missing} more pairs needed, better twice as many", icon="INFO")
        layout.operator("unrender.match_camera", icon="CAMERA_DATA").keep = False
        lines(layout, settings.focal)
        layout.operator("unrender.keep_photo", icon="ADD")


class UNRENDER_PT_prepare(Step, bpy.types.Panel):
    """Step 2."""

    bl_label = "2. Prepare"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = self.layout, context.scene.unrender
        layout.prop(settings, "folder")
        layout.prop(settings, "response")
        layout.prop(settings, "is_anchored")
        if settings.is_anchored:
            layout.prop_search(settings, "anchor", settings, "groups")
        else:
            layout.prop(settings, "exposure")
        layout.operator("unrender.list_groups", icon="FILE_REFRESH")
        layout.template_list("UNRENDER_UL_groups", "", settings, "groups", settings, "group", rows=4)
        row = layout.row(align=True)
        row.operator("unrender.check", icon="CHECKMARK")
        row.operator("unrender.toggle_overlay", icon="OVERLAY")
        for message in settings.messages.splitlines():
            lines(layout, message, icon="ERROR")


class UNRENDER_PT_recover(Step, bpy.types.Panel):
    """Step 3."""

    bl_label = "3. Recover"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = self.layout, context.scene.unrender
        layout.prop(settings, "max_rung")
        layout.prop(settings, "spp")
        if settings.running:
            layout.progress(factor=settings.progress, text=f"{settings.running} {settings.progress:.0%}")
            layout.operator("unrender.cancel", icon="CANCEL")
        else:
            layout.operator("unrender.recover", icon="PLAY")
        lines(layout, settings.message)


class UNRENDER_PT_apply(Step, bpy.types.Panel):
    """Step 4."""

    bl_label = "4. Apply"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = self.layout, context.scene.unrender
        layout.template_list("UNRENDER_UL_results", "", settings, "results", settings, "result", rows=4)
        if 0 <= settings.result < len(settings.results):
            item = settings.results[settings.result]
            lines(layout, item.numbers)
            if item.note:
                lines(layout, item.note, icon="ERROR" if item.status == "doubtful" else "INFO")
        row = layout.row(align=True)
        row.operator("unrender.apply", icon="MATERIAL")
        row.operator("unrender.revert", icon="LOOP_BACK")


class UNRENDER_PT_composite(Step, bpy.types.Panel):
    """Step 5."""

    bl_label = "5. Composite"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = self.layout, context.scene.unrender
        marked = sum(bool(thing.get(INSERTED)) for thing in context.selected_objects)
        layout.label(text=f"{marked} selected objects are not in the photograph")
        row = layout.row(align=True)
        row.operator("unrender.mark_inserted").clear = False
        row.operator("unrender.mark_inserted", text="", icon="X").clear = True
        layout.prop(settings, "grain")
        layout.operator("unrender.composite", icon="IMAGE_RGB_ALPHA")


CLASSES = (
    UNRENDER_UL_pairs,
    UNRENDER_UL_shots,
    UNRENDER_UL_groups,
    UNRENDER_UL_results,
    UNRENDER_PT_match,
    UNRENDER_PT_prepare,
    UNRENDER_PT_recover,
    UNRENDER_PT_apply,
    UNRENDER_PT_composite,
)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
