# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures in Blender: in the image editor, and behind the 3D view through the camera."""

import os

import bpy

PHOTO = "unrender photograph"


def load(path, name):
    """The picture in the file ``path`` as Blender's image ``name``, which is read again if it
    exists."""
    image = bpy.data.images.get(name)
    if image is None:
        image = bpy.data.images.load(path)
        image.name = name
    else:
        image.filepath = path
        image.reload()
    if os.path.splitext(path)[1].lower() in {".exr", ".hdr"}:
        image.colorspace_settings.name = "Linear Rec.709"
    return image


def show(image):
    """Shows the image in every image editor that has none, or one of ours."""
    for window in getattr(bpy.context.window_manager, "windows", []):
        for area in window.screen.areas:
            space = area.spaces.active
            if area.type == "IMAGE_EDITOR" and space.mode == "VIEW":
                if space.image is None or space.image.name.startswith("unrender"):
                    space.image = image


def behind(camera, image, depth, alpha):
    """Shows the image behind (``BACK``) or in front of (``FRONT``) the scene in the camera's
    view."""
    camera.show_background_images = True
    found = [entry for entry in camera.background_images if entry.image == image]
    entry = found[0] if found else camera.background_images.new()
    entry.image, entry.alpha, entry.display_depth = image, alpha, depth
    entry.frame_method = "STRETCH"
    entry.show_background_image = True
    return entry


def through(scene, image, size):
    """Shows a photograph of this size behind the scene in its camera's view, and sets the output to its
    size."""
    render = scene.render
    render.resolution_x, render.resolution_y = size
    render.resolution_percentage = 100
    render.pixel_aspect_x = render.pixel_aspect_y = 1.0
    behind(scene.camera.data, image, "BACK", 1.0)
    show(image)
