# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's scene as scene and project of unrender."""

import dataclasses
import os
import tempfile

import bpy
import unrender

from . import frames, geometry, lights, shaders, world


class Missing(Exception):
    """What the user has to do first."""


BRDF = "ggx"
"""The lobe of Cycles' Glossy BSDF; with it, nothing is converted on the way back."""


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


def groups_of(materials, doubts):
    """The groups of materials by name."""
    return {name: shaders.group_of(material, doubts) for name, material in materials.items()}


def scene_of(context, wanted=geometry.is_modelled, ignored=frozenset(), with_lights=True):
    """The scene of unrender, its materials by the names of their groups, and doubts.

    Args:
        wanted: Which objects count.
        ignored: The names of groups that are left out.
        with_lights: Whether lamps and the world come along.
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
    """The project in the folder of the scene: (path, materials, doubts). Its files are written."""
    scene, settings = context.scene, context.scene.unrender
    photo, size = photo_of(scene)
    if scene.camera is None or scene.camera.data.type != "PERSP":
        raise Missing("Match the camera first: the scene has no perspective camera")
    folder = folder_of(scene)
    ignored = frozenset(geometry.group_name(g.material) for g in settings.groups if g.ignored)
    model, materials, groups, doubts = scene_of(context, ignored=ignored)
    known = {}
    for item in settings.groups:
        name = geometry.group_name(item.material)
        if item.known and name in groups and shaders.brightness(groups[name].emission) == 0.0:
            known[name] = {"known": shaders.known(groups[name])}
    camera = frames.camera_of(scene.camera, context.evaluated_depsgraph_get(), size)
    surroundings = world.environment(scene.world, os.path.join(folder, "world.exr"))
    recover = {"brdf": BRDF}
    if settings.max_rung != "all":
        recover["max_rung"] = settings.max_rung
    project = unrender.Project(
        model,
        photo,
        response=settings.response,
        exposure="auto" if settings.is_anchored else settings.exposure,
        anchor=anchor(settings, groups) if settings.is_anchored else None,
        groups=known or None,
        environment=surroundings,
        camera=camera,
        recover=recover,
    )
    return project.save(os.path.join(folder, "project.toml")), materials, doubts


def anchor(settings, groups):
    """The group that fixes the exposure, as its material has it in Blender."""
    if settings.anchor not in groups:
        raise Missing("Name a diffuse material whose colour is known as the anchor")
    return {"group": settings.anchor, "rho_d": list(groups[settings.anchor].rho_d)}
