# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts Blender's scene to a scene and a project of unrender."""

import dataclasses
import os
import tempfile

import bpy
import unrender

from . import frames, geometry, lights, shaders, world


class Missing(Exception):
    """A step that the user has to do first."""


BRDF = "ggx"
"""The lobe of Cycles' Glossy BSDF; with it, results need no conversion."""


def folder_of(scene):
    """The folder of project and results: the user's, or one beside the .blend file."""
    settings = scene.unrender
    if not settings.folder:
        saved = bpy.data.filepath
        stem = os.path.splitext(os.path.basename(saved))[0]
        settings.folder = f"//{stem}_unrender" if saved else tempfile.mkdtemp(prefix="unrender-")
    folder = os.path.abspath(bpy.path.abspath(settings.folder))
    os.makedirs(folder, exist_ok=True)
    return folder


def photo_of(scene):
    """The path of the photograph and its size."""
    settings = scene.unrender
    path = os.path.abspath(bpy.path.abspath(settings.photo)) if settings.photo else ""
    if not os.path.isfile(path):
        raise Missing("Load the photograph first")
    return path, (int(settings.size[0]), int(settings.size[1]))


def photographs(context):
    """All photographs: for each its path, its response and its camera; that of step 1, if there is one, is the last."""
    scene, settings = context.scene, context.scene.unrender
    taken = [(shot.photo, tuple(shot.size), shot.response, shot.camera) for shot in settings.shots]
    if settings.photo or not taken:
        photo, size = photo_of(scene)
        taken.append((photo, size, settings.response, scene.camera))
    found = []
    for photo, size, response, camera in taken:
        path = os.path.abspath(bpy.path.abspath(photo))
        if not os.path.isfile(path):
            raise Missing(f"{path}: there is no such file")
        if camera is None or camera.data.type != "PERSP":
            name = "the scene" if len(taken) == 1 else bpy.path.basename(path)
            raise Missing(f"Match the camera first: {name} has no perspective camera")
        found.append((path, response, frames.camera_of(camera, context.evaluated_depsgraph_get(), size)))
    return found


def groups_of(materials, doubts):
    """The groups of materials by name."""
    return {name: shaders.group_of(material, doubts) for name, material in materials.items()}


def scene_of(context, wanted=geometry.is_modelled, ignored=frozenset(), with_lights=True):
    """The scene of unrender, its materials by the names of their groups, and warnings.

    Args:
        wanted: Selects the objects.
        ignored: The names of groups that are left out.
        with_lights: Whether lamps and the world are included.
    """
    depsgraph = context.evaluated_depsgraph_get()
    meshes, materials = geometry.meshes(depsgraph, wanted, ignored)
    doubts = []
    groups = groups_of(materials, doubts)
    points = []
    if with_lights:
        lamps, emitting, points, more = lights.lights(depsgraph, wanted)
        taken = {name: geometry.unused(name, groups) for name in emitting}
        groups.update({taken[name]: group for name, group in emitting.items()})
        meshes += [dataclasses.replace(lamp, group=taken[lamp.group]) for lamp in lamps]
        doubts += more
    if not meshes:
        raise Missing("There is no surface that is rendered")
    cameras = []
    if context.scene.camera is not None and context.scene.camera.data.type == "PERSP":
        size = tuple(context.scene.unrender.size)
        size = size if min(size) > 0 else (16, 9)
        cameras = [frames.camera_of(context.scene.camera, depsgraph, size)]
    scene = unrender.Scene(meshes, groups=groups, lights=points, cameras=cameras)
    return scene, materials, groups, doubts


def project_of(context):
    """Writes the project and its files into the folder of the scene; returns (path, materials,
    warnings)."""
    scene, settings = context.scene, context.scene.unrender
    taken = photographs(context)
    folder = folder_of(scene)
    ignored = frozenset(geometry.group_name(g.material) for g in settings.groups if g.ignored)
    model, materials, groups, doubts = scene_of(context, ignored=ignored)
    known = {}
    for item in settings.groups:
        name = geometry.group_name(item.material)
        if item.known and name in groups and shaders.brightness(groups[name].emission) == 0.0:
            known[name] = {"known": shaders.known(groups[name])}
    surroundings = world.environment(scene.world, os.path.join(folder, "world.exr"))
    recover = {"brdf": BRDF}
    if settings.max_rung != "all":
        recover["max_rung"] = settings.max_rung
    exposure = "auto" if settings.is_anchored else settings.exposure
    photo, response, camera = taken[0]
    several = [
        {"photo": photo, "response": response, "camera": camera, "exposure": "auto" if number else exposure}
        for number, (photo, response, camera) in enumerate(taken)
    ]
    of_one = {"photo": photo, "response": response, "exposure": exposure, "camera": camera}
    project = unrender.Project(
        model,
        anchor=anchor(settings, groups) if settings.is_anchored else None,
        groups=known or None,
        environment=surroundings,
        recover=recover,
        **(of_one if len(taken) == 1 else {"photos": several}),
    )
    return project.save(os.path.join(folder, "project.toml")), materials, doubts


def anchor(settings, groups):
    """The group that fixes the exposure, with the colour of its material in Blender."""
    if settings.anchor not in groups:
        raise Missing("Name a diffuse material whose colour is known as the anchor")
    return {"group": settings.anchor, "rho_d": list(groups[settings.anchor].rho_d)}
