# SPDX-License-Identifier: GPL-3.0-or-later
"""Picks a pair with the mouse: a vertex in the 3D view, then its place in the photograph."""

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

from . import geometry
from .pictures import PHOTO

REACH = 20.0
"""Pixels of the screen within which a vertex is picked: half of it needs careful aiming, double picks
a neighbour in dense meshes."""


def nearest_vertex(depsgraph, view, size, mouse, wanted=geometry.is_modelled, reach=REACH):
    """The vertex nearest to the mouse, in world space; None if none is within reach.

    Args:
        view: The matrix from world space to clip space.
        size: The region's width and height.
        mouse: (x, y) from its lower left corner.
    """
    best, found = reach**2, None
    for thing, matrix in geometry.surfaces(depsgraph, wanted):
        mesh = thing.to_mesh()
        if mesh is None or len(mesh.vertices) == 0:
            continue
        positions = geometry.read(mesh.vertices, "co", (len(mesh.vertices), 3))
        thing.to_mesh_clear()
        rows = np.hstack([positions, np.ones((len(positions), 1))]) @ np.array(matrix).T
        clip = rows @ np.array(view).T
        ahead = clip[:, 3] > 1e-9
        if not ahead.any():
            continue
        rows, clip = rows[ahead], clip[ahead]
        places = (clip[:, :2] / clip[:, 3:] + 1.0) * 0.5 * np.array(size)
        distance = np.sum((places - np.array(mouse)) ** 2, axis=1)
        at = int(np.argmin(distance))
        # Of vertices behind each other, which differ by less than a pixel, the front one is picked.
        near = np.flatnonzero(distance < distance[at] + 1.0)
        at = int(near[np.argmin(clip[near, 3])])
        if distance[at] < best:
            best, found = float(distance[at]), Vector(rows[at, :3])
    return found


def pixel_of(fraction, size):
    """The pixel at a place of the picture, as fractions from its lower left corner."""
    return (fraction[0] * size[0], (1.0 - fraction[1]) * size[1])


def through_camera(scene, region, region_3d, mouse):
    """The place in the camera's frame under the mouse, as fractions from its lower left corner."""
    camera = scene.camera
    corners = [camera.matrix_world @ corner for corner in camera.data.view_frame(scene=scene)]
    places = [location_3d_to_region_2d(region, region_3d, corner) for corner in corners]
    low = [min(p[k] for p in places) for k in (0, 1)]
    high = [max(p[k] for p in places) for k in (0, 1)]
    return [(mouse[k] - low[k]) / (high[k] - low[k]) for k in (0, 1)]


class UNRENDER_OT_pick_pair(bpy.types.Operator):
    """Click a vertex in the 3D view, then its place in the photograph: in an image editor that shows it, or
    in the view through the camera"""

    bl_idname = "unrender.pick_pair"
    bl_label = "Pick pair"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return bool(context.scene.unrender.photo) and context.window is not None

    def invoke(self, context, event):
        self.vertex = None
        self.tell(context, "Click a vertex in the 3D view; Esc ends")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type in {"ESC", "RIGHTMOUSE"}:
            self.tell(context, None)
            return {"CANCELLED"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        area, region = under(context.window, event.mouse_x, event.mouse_y)
        if region is None:
            return {"PASS_THROUGH"}
        mouse = (event.mouse_x - region.x, event.mouse_y - region.y)
        if self.vertex is None:
            self.take_vertex(context, area, region, mouse)
            return {"RUNNING_MODAL"}
        fraction = self.place(context, area, region, mouse)
        if fraction is None or not all(0.0 <= f <= 1.0 for f in fraction):
            return {"RUNNING_MODAL"}
        size = context.scene.unrender.size
        bpy.ops.unrender.add_pair(point=self.vertex, pixel=pixel_of(fraction, size))
        self.vertex = None
        self.tell(context, "The next vertex; Esc ends")
        return {"RUNNING_MODAL"}

    def take_vertex(self, context, area, region, mouse):
        if area.type != "VIEW_3D":
            return
        view = area.spaces.active.region_3d.perspective_matrix
        depsgraph = context.evaluated_depsgraph_get()
        self.vertex = nearest_vertex(depsgraph, view, (region.width, region.height), mouse)
        if self.vertex is not None:
            self.tell(context, "Now its place in the photograph: image editor, or view through the camera")

    def place(self, context, area, region, mouse):
        space = area.spaces.active
        if area.type == "IMAGE_EDITOR" and space.image is not None and space.image.name == PHOTO:
            return region.view2d.region_to_view(*mouse)
        if area.type == "VIEW_3D" and space.region_3d.view_perspective == "CAMERA":
            return through_camera(context.scene, region, space.region_3d, mouse)
        return None

    def tell(self, context, text):
        context.workspace.status_text_set(text)


def under(window, x, y):
    """The area and its main region under the mouse."""
    for area in window.screen.areas:
        for region in area.regions:
            inside = 0 <= x - region.x < region.width and 0 <= y - region.y < region.height
            if region.type == "WINDOW" and inside:
                return area, region
    return None, None


def register():
    bpy.utils.register_class(UNRENDER_OT_pick_pair)


def unregister():
    bpy.utils.unregister_class(UNRENDER_OT_pick_pair)
