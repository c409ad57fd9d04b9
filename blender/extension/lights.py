# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights of Blender as lights of unrender.

Watts are the power that a light emits into all directions. An area light of power P and area A has the
radiance P/(pi A); a point light emits P/(4 pi) watts per steradian, and with a radius r is a sphere of
the radiance P/(4 pi^2 r^2). [Blender manual, Light Objects]
"""

import math

import numpy as np
import unrender
from mathutils import Vector

from .frames import y_up, y_up_one
from .geometry import unused

DISK_CORNERS = 64
"""A disk is a polygon of this many corners: half as many give a rim that is off by 0.5 % of the radius,
twice as many change no pixel."""
SPHERE_RINGS = 16
"""Rings of a spherical lamp: half as many are visible in its mirror images, twice as many change
nothing."""


def lights(depsgraph, wanted):
    """The lamps of the scene: meshes that emit, their groups, lights without a surface, and
    warnings."""
    made, groups, points, doubts = [], {}, [], []
    for instance in depsgraph.object_instances:
        thing = instance.object
        owner = instance.parent if instance.is_instance else thing
        if thing.type != "LIGHT" or not wanted(thing.original, owner.original):
            continue
        light, matrix = thing.data, instance.matrix_world.copy()
        colour = colour_of(light, thing.name, doubts)
        name = unused(thing.original.name, groups)
        if light.type == "AREA":
            mesh, radiance = area(light, matrix, colour, name, doubts)
        elif light.type == "SUN":
            points.append(sun(light, matrix, colour, name))
            continue
        elif light.type == "SPOT":
            points.append(spot(light, matrix, colour, name, doubts))
            continue
        elif light.shadow_soft_size > 0.0:
            mesh, radiance = sphere(light, matrix, colour, name)
        else:
            at = y_up_one(matrix.translation)
            points.append(unrender.Light("point", colour / (4 * math.pi), position=at, name=name))
            continue
        made.append(mesh)
        groups[name] = unrender.Group(rho_d=(0, 0, 0), emission=tuple(radiance))
    return made, groups, points, doubts


def colour_of(light, name, doubts):
    """Power or irradiance per channel; of nodes, only a plain emission is read."""
    colour = np.array(light.color, dtype=float) * light.energy * 2.0 ** getattr(light, "exposure", 0.0)
    # Blender has temperature and the switch of normalisation since 4.5.
    if getattr(light, "use_temperature", False):
        colour *= np.array(light.temperature_color)
    if not getattr(light, "normalize", True):
        doubts.append(f'light "{name}": its power is taken as normalised by its area')
    if light.use_nodes and light.node_tree is not None:
        nodes = [node for node in light.node_tree.nodes if node.type == "EMISSION"]
        linked = any(link.to_node.type == "EMISSION" for link in light.node_tree.links)
        if len(nodes) == 1 and not linked:
            strength = nodes[0].inputs["Strength"].default_value
            colour *= np.array(nodes[0].inputs["Color"].default_value[:3]) * strength
        elif nodes:
            doubts.append(f'light "{name}": its nodes are more than an emission and were not read')
    return colour


def area(light, matrix, colour, name, doubts):
    """An area light is a mesh that emits from its front, along its -z."""
    width = light.size
    height = light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
    if light.shape in {"SQUARE", "RECTANGLE"}:
        rim = [(-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)]
        share = 1.0
    else:
        turn = -2.0 * math.pi / DISK_CORNERS
        rim = [(0.5 * math.cos(turn * k), 0.5 * math.sin(turn * k)) for k in range(DISK_CORNERS)]
        share = math.pi / 4.0
    if light.spread < math.pi - 1e-3:
        doubts.append(f'light "{name}": its spread is taken as 180 degrees')
    corners = [matrix @ Vector((x * width, y * height, 0.0)) for x, y in rim]
    faces = [(0, k, k + 1) for k in range(1, len(corners) - 1)]
    # The lamp's scale changes its size, not its power.
    across, along = matrix.col[0].to_3d(), matrix.col[1].to_3d()
    size = across.cross(along).length * width * height * share
    mesh = unrender.Mesh(name, y_up(corners), np.array(faces), name=name)
    return mesh, colour / (math.pi * max(size, 1e-12))


def sphere(light, matrix, colour, name):
    """A point light with a radius is a sphere that emits."""
    radius, centre = light.shadow_soft_size, np.array(matrix.translation)
    angles = np.linspace(0.0, math.pi, SPHERE_RINGS + 1)
    turns = np.linspace(0.0, 2.0 * math.pi, 2 * SPHERE_RINGS, endpoint=False)
    rows = [
        [math.sin(a) * math.cos(t), math.sin(a) * math.sin(t), math.cos(a)] for a in angles for t in turns
    ]
    across, faces = len(turns), []
    for ring in range(SPHERE_RINGS):
        for k in range(across):
            a, b = ring * across + k, ring * across + (k + 1) % across
            if ring > 0:
                faces.append((a, a + across, b))
            if ring < SPHERE_RINGS - 1:
                faces.append((b, a + across, b + across))
    points = np.array(rows) * radius + centre
    triangles = points[np.array(faces)]
    crosses = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    # The projected area of a convex body, averaged over all directions, is a quarter of its surface.
    shown = 0.5 * np.linalg.norm(crosses, axis=1).sum() / 4.0
    mesh = unrender.Mesh(name, y_up(points), np.array(faces), name=name)
    return mesh, colour / (4.0 * math.pi * shown)


def sun(light, matrix, colour, name):
    """The energy of a sun is its irradiance."""
    direction = -matrix.col[2].to_3d().normalized()
    return unrender.Light("directional", tuple(colour), direction=y_up_one(direction), name=name)


def spot(light, matrix, colour, name, doubts):
    """A spot is a point light with a cone; the blend is a part of the cone's height."""
    half = 0.5 * light.spot_size
    inner = math.acos(min(1.0, math.cos(half) + (1.0 - math.cos(half)) * light.spot_blend))
    if light.spot_blend > 0.05:
        doubts.append(f'spot "{name}": the rim of its cone falls off slightly differently from Blender')
    return unrender.Light(
        "spot",
        tuple(colour / (4 * math.pi)),
        position=y_up_one(matrix.translation),
        direction=y_up_one(-matrix.col[2].to_3d().normalized()),
        inner_deg=math.degrees(min(inner, half * 0.999)),
        outer_deg=math.degrees(half),
        name=name,
    )
