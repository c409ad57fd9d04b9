"""The shell of a room: floor, ceiling, walls, a window with its frame, skirting boards; and common things."""

import dataclasses
import math
import random

from modelling import at, ball, box, leaf_card, panel, rounded, surface, tube, turned

DEEP = 0.24
"""Thickness of the window's wall, metres."""


@dataclasses.dataclass(frozen=True)
class Window:
    """An opening in the wall at x = 0 ("left") or x = width ("right")."""

    side: str
    y: tuple[float, float]
    z: tuple[float, float]


def shell(width: float, depth: float, height: float, window: Window, tile: float, ceiling: str = "ceiling",
          trim: str = "trim") -> None:
    """Groups floor, wall, ``ceiling`` and ``trim``; the floor's texture spans ``tile`` metres."""
    w, d, h = width, depth, height
    panel("floor", [(0, 0, 0), (w, 0, 0), (w, d, 0), (0, d, 0)], "floor", (w / tile, d / tile))
    panel("ceiling", [(0, 0, h), (0, d, h), (w, d, h), (w, 0, h)], ceiling)
    panel("wall back", [(0, d, 0), (w, d, 0), (w, d, h), (0, d, h)], "wall")
    panel("wall front", [(0, 0, 0), (0, 0, h), (w, 0, h), (w, 0, 0)], "wall")
    left = [(0, 0, 0), (0, d, 0), (0, d, h), (0, 0, h)]
    right = [(w, 0, 0), (w, 0, h), (w, d, h), (w, d, 0)]
    if window.side == "left":
        panel("wall right", right, "wall")
        outer, inner, sill, out = -DEEP, 0.0, 0.05, -1
    else:
        panel("wall left", left, "wall")
        outer, inner, sill, out = w, w + DEEP, -0.05, 1
    (y0, y1), (z0, z1) = window.y, window.z
    for name, (ya, yb), (za, zb) in [("below", (0, d), (0, z0)), ("above", (0, d), (z1, h)),
                                     ("before", (0, y0), (z0, z1)), ("behind", (y1, d), (z0, z1))]:
        box(f"wall {name} window", (outer, ya, za), (inner, yb, zb), "wall", shade="flat")
    face = 0.0 if out < 0 else w
    frame = face + out * 0.16
    thin = 0.045
    bars = [((y0, y0 + thin), (z0, z1)), ((y1 - thin, y1), (z0, z1)), ((y0, y1), (z0, z0 + thin)),
            ((y0, y1), (z1 - thin, z1)), (((y0 + y1 - thin) / 2, (y0 + y1 + thin) / 2), (z0, z1))]
    for k, ((ya, yb), (za, zb)) in enumerate(bars):
        box(f"window frame {k}", (min(frame, frame + out * 0.05), ya, za), (max(frame, frame + out * 0.05), yb, zb),
            trim, bevel=0.004)
    ends = sorted((face + sill, face + out * 0.16))
    box("window sill", (ends[0], y0 - 0.04, z0 - 0.03), (ends[1], y1 + 0.04, z0 + 0.004), trim, bevel=0.006)
    box("skirting back", (0, d - 0.015, 0), (w, d, 0.09), trim, bevel=0.004)
    box("skirting left", (0, 0, 0), (0.015, d, 0.09), trim, bevel=0.004)
    box("skirting right", (w - 0.015, 0, 0), (w, d, 0.09), trim, bevel=0.004)


def picture(name: str, poster: str, frame: str, width: float, height: float, thick: float = 0.03) -> None:
    """A framed poster that hangs in the plane y = 0 and faces -y, its middle at the origin."""
    x, z, b = width / 2, height / 2, 0.03
    panel(name, [(-x, -0.012, -z), (x, -0.012, -z), (x, -0.012, z), (-x, -0.012, z)], poster)
    for k, (low, high) in enumerate([((-x - b, -z - b), (x + b, -z)), ((-x - b, z), (x + b, z + b)),
                                     ((-x - b, -z), (-x, z)), ((x, -z), (x + b, z))]):
        box(f"{name} frame {k}", (low[0], -thick, low[1]), (high[0], 0, high[1]), frame, bevel=0.006)


def vase(name: str, material: str, points: list[tuple[float, float]], wall: float = 0.005) -> None:
    """A vessel of glass: its outer profile, then the inner one a wall away."""
    outer = rounded(points)
    inner = [(max(r - wall, 0.0), max(z, points[0][1] + 2.5 * wall)) for r, z in reversed(outer)]
    turned(name, [(0.0, points[0][1]), *outer, *inner, (0.0, inner[-1][1])], material, segments=64)


def pot(name: str, material: str, radius: float, height: float) -> None:
    """A flower pot with a rim, filled to a hand's breadth below it with what it is made of."""
    profile = [(0.0, 0.0), (0.72 * radius, 0.0), (0.93 * radius, 0.8 * height), (radius, 0.8 * height),
               (1.02 * radius, height), (0.90 * radius, height), (0.86 * radius, 0.86 * height),
               (0.0, 0.87 * height)]
    turned(name, profile, material)


def plant(name: str, seed: int, leaves: int, length: float, width: float, spread: float,
          card: str | None, stalk: str) -> None:
    """Stalks from the origin upwards, each with a leaf on a card (group ``card``; None leaves the cards out)."""
    rng = random.Random(seed)
    for k in range(leaves):
        turn = 137.5 * k + rng.uniform(-15, 15)
        share = (k + 0.5) / leaves
        lean = spread * (0.25 + 0.75 * share)
        rise = length * rng.uniform(0.6, 1.0) * (1.15 - 0.5 * share)
        tip = (0.0, rise * math.sin(math.radians(lean)), rise * math.cos(math.radians(lean)))
        with at((0, 0, 0), turn):
            tube(f"{name} stalk {k}", (0, 0.01, 0), tip, 0.0035 + 0.004 * length, stalk, to=0.003, segments=8)
            if card is not None:
                size = rng.uniform(0.8, 1.15) * length
                with at(tip, rng.uniform(-20, 20), (-lean - 12, rng.uniform(-12, 12))):
                    leaf_card(f"{name} leaf {k}", size, width * size, rng.uniform(0.5, 1.1), card)


def globe_lamp(name: str, radius: float, glow: str, holder: str, drop: float) -> None:
    """A ball of light that hangs ``drop`` below the origin."""
    tube(f"{name} cord", (0, 0, -drop + radius), (0, 0, 0), 0.006, holder, segments=10)
    tube(f"{name} cap", (0, 0, -drop + 0.9 * radius), (0, 0, -drop + 1.35 * radius), 0.35 * radius, holder,
         to=0.15 * radius)
    with at((0, 0, -drop)):
        ball(name, radius, glow, segments=32)


def bowl(name: str, material: str, radius: float, height: float, wall: float = 0.006) -> None:
    """A round bowl that stands on the origin."""
    steps = [math.pi / 2 * k / 8 for k in range(9)]
    outer = [(0.35 * radius + 0.65 * radius * math.sin(a), height * (1 - math.cos(a))) for a in steps]
    inner = [(max(r - wall, 0.0), max(z, wall) + (0.0 if k == 0 else 0.001)) for k, (r, z) in
             enumerate(reversed(outer))]
    turned(name, [(0.0, 0.0), *outer, *inner, (0.0, wall)], material, segments=56)


def handle(name: str, start: tuple[float, float, float], end: tuple[float, float, float], material: str,
           out: tuple[float, float, float], radius: float = 0.006) -> None:
    """A bar handle with two feet; ``out`` leads from the front to the bar."""
    far = [tuple(a + b for a, b in zip(p, out, strict=True)) for p in (start, end)]
    tube(f"{name} bar", far[0], far[1], radius, material, segments=12)
    for k, (near, tip) in enumerate(zip((start, end), far, strict=True)):
        tube(f"{name} foot {k}", near, tip, 0.8 * radius, material, segments=10)


def books(name: str, seed: int, count: int, groups: list[str], tall: float = 0.24) -> None:
    """A row of books from the origin along +x, their backs towards -y."""
    rng = random.Random(seed)
    x = 0.0
    for k in range(count):
        thick, high = rng.uniform(0.02, 0.045), tall * rng.uniform(0.78, 1.0)
        box(f"{name} {k}", (x, 0.0, 0.0), (x + thick - 0.002, 0.16 * rng.uniform(0.9, 1.0), high),
            groups[k % len(groups)], bevel=0.003)
        x += thick


def sheet(name: str, material: str, low: tuple[float, float], high: tuple[float, float], z: float, drop: float,
          repeat: tuple[float, float] = (1.0, 1.0), wave: float = 0.006) -> None:
    """Cloth spread over a mattress, hanging down at its long sides by ``drop``."""
    half = (high[0] - low[0]) / 2
    middle = (high[0] + low[0]) / 2
    total = 2 * (half + drop)

    def point(u: float, v: float) -> tuple[float, float, float]:
        s = (u - 0.5) * total
        over = max(abs(s) - half, 0.0)
        bend = 0.06
        turn = min(over / bend, math.pi / 2)
        x = math.copysign(min(abs(s), half) + bend * math.sin(turn), s)
        fall = bend * (1 - math.cos(turn)) + max(over - bend * math.pi / 2, 0.0)
        y = low[1] + (high[1] - low[1]) * v
        ripple = wave * math.sin(9 * v + 3 * u) * math.sin(14 * u + 2)
        hang = wave * 3 * math.sin(26 * v) * min(fall / max(drop, 1e-6), 1.0)
        return (middle + x + math.copysign(hang, s), y, z + ripple - fall)

    surface(name, material, 48, 64, point, repeat=repeat, shade="smooth")
