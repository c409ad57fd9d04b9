# SPDX-License-Identifier: GPL-3.0-or-later
"""Several photographs: the kept ones beside that of step 1, each with its camera."""

import bpy

from . import pictures


class UNRENDER_OT_keep_photo(bpy.types.Operator):
    """Keep this photograph with its camera, and begin with another one of the same scene"""

    bl_idname = "unrender.keep_photo"
    bl_label = "Keep, and add another"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return bool(context.scene.unrender.photo) and context.scene.camera is not None

    def execute(self, context):
        keep(context.scene)
        context.scene.camera = None
        return {"FINISHED"}


class UNRENDER_OT_use_photo(bpy.types.Operator):
    """Continue with this photograph and its camera, and keep the present one"""

    bl_idname = "unrender.use_photo"
    bl_label = "Work on this one"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        settings = context.scene.unrender
        return 0 <= settings.shot < len(settings.shots)

    def execute(self, context):
        scene, settings = context.scene, context.scene.unrender
        index = settings.shot
        shot = settings.shots[index]
        taken = shot.photo, tuple(shot.size), shot.response, shot.camera
        image = shot.image
        settings.shots.remove(index)
        if settings.photo and scene.camera is not None:
            keep(scene)
            # It takes the place of the other one: so a first photograph stays the first.
            settings.shots.move(len(settings.shots) - 1, index)
        settings.photo, settings.size, settings.response, scene.camera = taken
        if image is None:
            image = pictures.load(settings.photo, pictures.PHOTO)
        image.name = pictures.PHOTO
        if scene.camera is not None:
            pictures.through(scene, image, settings.size)
        return {"FINISHED"}


class UNRENDER_OT_forget_photo(bpy.types.Operator):
    """Leave this photograph out; its camera stays"""

    bl_idname = "unrender.forget_photo"
    bl_label = "Forget photograph"
    bl_options = {"REGISTER", "UNDO"}

    poll = UNRENDER_OT_use_photo.poll

    def execute(self, context):
        settings = context.scene.unrender
        settings.shots.remove(settings.shot)
        settings.shot = max(0, min(settings.shot, len(settings.shots) - 1))
        return {"FINISHED"}


def keep(scene):
    """Adds the photograph of step 1 to the kept ones."""
    settings = scene.unrender
    shot = settings.shots.add()
    shot.name = bpy.path.basename(settings.photo)
    shot.photo, shot.size, shot.response = settings.photo, settings.size, settings.response
    shot.camera = scene.camera
    image = bpy.data.images.get(pictures.PHOTO)
    if image is not None:
        # It stays behind its camera, and the next one becomes a new image.
        image.name, shot.image = f"unrender {shot.name}", image
    settings.photo, settings.focal = "", ""
    settings.pairs.clear()


CLASSES = (UNRENDER_OT_keep_photo, UNRENDER_OT_use_photo, UNRENDER_OT_forget_photo)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
