"""Meshes as a modeller makes them: bevelled boxes, turned things, tubes, cushions, curtains, leaves.

Lengths are metres, z is up. ``at`` places what is built within it.
"""

import contextlib
import math
from collections.abc import Callable, Iterator, Sequence

import bmesh
import bpy
from mathutils import Euler, Matrix, Vector

Point = Sequence[float]

SHARP = math.radians(35)
"""Edges sharper than this stay edges, as Blender's *Shade Auto Smooth* has them."""

_places: list[Matrix] = [Matrix()]


@contextlib.contextmanager
def at(where: Point, turn: float = 0.0, tilt: Point = (0.0, 0.0)) -> Iterator[None]:
    """Builds about ``where``, turned by ``turn`` degrees about the upright axis after a tilt about x and y."""
    angles = Euler((math.radians(tilt[0]), math.radians(tilt[1]), math.radians(turn)))
    _places.append(_places[-1] @ Matrix.Translation(where) @ angles.to_matrix().to_4x4())
    try:
        yield
    finally:
        _places.pop()


def placed(name: str, mesh: bpy.types.Mesh, material: str) -> bpy.types.Object:
    """An object of a mesh in the place of the day."""
    thing = bpy.data.objects.new(name, mesh)
    thing.matrix_world = _places[-1]
    bpy.context.scene.collection.objects.link(thing)
    mesh.materials.append(bpy.data.materials[material])
    return thing


def finished(name: str, made: bmesh.types.BMesh, material: str, shade: str, scale: float) -> bpy.types.Object:
    """The object of a bmesh: ``shade`` is "flat", "auto" (by angle) or "smooth"; texture coordinates that are
    not there yet are projected along the axes, ``scale`` to a metre.
    """
    if not made.loops.layers.uv:
        projected(made, scale)
    mesh = bpy.data.meshes.new(name)
    made.to_mesh(mesh)
    made.free()
    for polygon in mesh.polygons:
        polygon.use_smooth = shade != "flat"
    if shade == "auto":
        mesh.set_sharp_from_angle(angle=SHARP)
    thing = placed(name, mesh, material)
    if shade == "auto":
        # Without it a bevel bends the normals of the flat faces beside it.
        weighted = thing.modifiers.new("WeightedNormal", "WEIGHTED_NORMAL")
        weighted.keep_sharp = True
    return thing


def projected(made: bmesh.types.BMesh, scale: float) -> None:
    """Texture coordinates along the axis that a face is turned to; the longer side of a thing is u on top."""
    layer = made.loops.layers.uv.new("UVMap")
    for face in made.faces:
        face.normal_update()
        x, y, z = (abs(c) for c in face.normal)
        for loop in face.loops:
            p = loop.vert.co * scale
            loop[layer].uv = (p.x, p.y) if z >= max(x, y) else (p.y, p.z) if x >= y else (p.x, p.z)


def box(name: str, low: Point, high: Point, material: str, *, bevel: float = 0.0, shade: str = "auto",
        scale: float = 1.0, segments: int = 2) -> bpy.types.Object:
    """A box between two corners with rounded edges."""
    made = bmesh.new()
    size = [b - a for a, b in zip(low, high, strict=True)]
    middle = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
    bmesh.ops.create_cube(made, size=1.0, matrix=Matrix.Translation(middle) @ Matrix.Diagonal((*size, 1.0)))
    if bevel > 0.0:
        bmesh.ops.bevel(made, geom=made.edges[:], offset=bevel, segments=segments, profile=0.5, affect="EDGES")
    return finished(name, made, material, shade, scale)


def panel(name: str, corners: Sequence[Point], material: str, repeat: Point = (1.0, 1.0)) -> bpy.types.Object:
    """A quadrilateral, front counter-clockwise; the texture stands upright from its first corner."""
    made = bmesh.new()
    layer = made.loops.layers.uv.new("UVMap")
    face = made.faces.new([made.verts.new(corner) for corner in corners])
    for loop, (u, v) in zip(face.loops, [(0, 0), (1, 0), (1, 1), (0, 1)], strict=True):
        loop[layer].uv = (u * repeat[0], v * repeat[1])
    return finished(name, made, material, "flat", 1.0)


def surface(name: str, material: str, rows: int, columns: int, point: Callable[[float, float], Point], *,
            closed: bool = False, repeat: Point = (1.0, 1.0), shade: str = "auto") -> bpy.types.Object:
    """A grid of ``point(u, v)``; ``closed`` joins u = 1 to u = 0. Its front is du x dv."""
    made = bmesh.new()
    layer = made.loops.layers.uv.new("UVMap")
    across = columns if closed else columns + 1
    grid = [[made.verts.new(point(i / columns, j / rows)) for i in range(across)] for j in range(rows + 1)]
    for j in range(rows):
        for i in range(columns):
            ring = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            face = made.faces.new([grid[b][a % across] for a, b in ring])
            for loop, (a, b) in zip(face.loops, ring, strict=True):
                loop[layer].uv = (a / columns * repeat[0], b / rows * repeat[1])
    bmesh.ops.remove_doubles(made, verts=made.verts[:], dist=1e-6)
    return finished(name, made, material, shade, 1.0)


def turned(name: str, profile: Sequence[tuple[float, float]], material: str, *, segments: int = 48,
           repeat: Point = (1.0, 1.0), shade: str = "auto") -> bpy.types.Object:
    """A thing from the lathe: (radius, height), outside from the bottom upwards."""
    last = len(profile) - 1

    def point(u: float, v: float) -> Point:
        radius, height = profile[round(v * last)]
        angle = 2 * math.pi * u
        return (radius * math.cos(angle), radius * math.sin(angle), height)

    return surface(name, material, last, segments, point, closed=True, repeat=repeat, shade=shade)


def ball(name: str, radius: float, material: str, *, flat: float = 1.0, segments: int = 40,
         repeat: Point = (1.0, 1.0)) -> bpy.types.Object:
    """A sphere, ``flat`` times as high as it is wide."""
    count = segments // 2
    angles = [math.pi * k / count for k in range(count + 1)]
    profile = [(radius * math.sin(a) if 0 < k < count else 0.0, -flat * radius * math.cos(a))
               for k, a in enumerate(angles)]
    return turned(name, profile, material, segments=segments, repeat=repeat, shade="smooth")


def rounded(points: Sequence[tuple[float, float]], steps: int = 6) -> list[tuple[float, float]]:
    """A profile through ``points`` without corners (Catmull and Rom)."""
    ends = [points[0], *points, points[-1]]
    made = []
    for k in range(len(points) - 1):
        a, b, c, d = ends[k:k + 4]
        for step in range(steps):
            t = step / steps
            made.append(tuple(
                0.5 * (2 * q + (r - p) * t + (2 * p - 5 * q + 4 * r - s) * t * t + (3 * q - p - 3 * r + s) * t**3)
                for p, q, r, s in zip(a, b, c, d, strict=True)))
    return [(max(radius, 0.0), height) for radius, height in [*made, points[-1]]]


def tube(name: str, start: Point, end: Point, radius: float, material: str, *, to: float | None = None,
         segments: int = 20) -> bpy.types.Object:
    """A round bar with closed ends, ``to`` its radius at the end."""
    along = Vector(end) - Vector(start)
    turn = along.to_track_quat("Z", "Y").to_matrix().to_4x4()
    _places.append(_places[-1] @ Matrix.Translation(start) @ turn)
    tip = radius if to is None else to
    try:
        profile = [(0.0, 0.0), (radius, 0.0), (tip, along.length), (0.0, along.length)]
        return turned(name, profile, material, segments=segments)
    finally:
        _places.pop()


def cushion(name: str, size: Point, material: str, repeat: Point = (1.0, 1.0)) -> bpy.types.Object:
    """A pillow that lies flat, thick in the middle and thin at its seam."""
    width, depth, height = size

    def point(side: float) -> Callable[[float, float], Point]:
        def at_side(u: float, v: float) -> Point:
            x, y = 2 * u - 1, 2 * v - 1
            swell = ((1 - x**4) * (1 - y**4)) ** 0.5
            draw = 1.0 - 0.07 * (1 - x * x) * y * y - 0.07 * (1 - y * y) * x * x
            return (0.5 * width * x * draw, side * 0.5 * depth * y * draw, side * 0.5 * height * swell)
        return at_side

    surface(f"{name} below", material, 16, 16, point(-1.0), repeat=repeat, shade="smooth")
    return surface(name, material, 16, 16, point(1.0), repeat=repeat, shade="smooth")


def curtain(name: str, start: Point, end: Point, top: float, material: str, folds: int = 7,
            depth: float = 0.05) -> bpy.types.Object:
    """Cloth in folds from ``start`` to ``end``, hanging from the height ``top``."""
    low, high = Vector(start), Vector(end)
    across = (high - low).normalized().cross(Vector((0, 0, 1)))

    def point(u: float, v: float) -> Point:
        wave = math.sin(2 * math.pi * folds * u) + 0.3 * math.sin(2 * math.pi * (2.3 * folds * u + 0.2))
        p = low.lerp(high, u) + across * (depth * (1.0 - 0.35 * v) * wave)
        return (p.x, p.y, low.z + (top - low.z) * v)

    return surface(name, material, 6, 16 * folds, point, shade="smooth")


def leaf_card(name: str, length: float, width: float, bend: float, material: str) -> bpy.types.Object:
    """A leaf's rectangle that rises along +z and bends over towards +y."""
    def point(u: float, v: float) -> Point:
        angle = bend * v
        reach = length * v if bend == 0.0 else length * math.sin(angle) / bend
        over = 0.0 if bend == 0.0 else length * (1 - math.cos(angle)) / bend
        return (width * (u - 0.5), over + 0.3 * width * (2 * u - 1) ** 2, reach)

    return surface(name, material, 8, 4, point, shade="smooth")
