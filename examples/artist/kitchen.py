"""A kitchen in the evening: pendants, a lit strip under the cupboards, a spot, and dusk in the window."""

import math

import textures
from materials import Paint, Palette, lamp
from modelling import at, ball, box, panel, rounded, tube, turned
from photograph import camera, light, window_portal
from shell import Window, bowl, globe_lamp, handle, picture, plant, pot, shell, vase

WIDTH, DEPTH, HEIGHT = 4.2, 4.4, 2.55
WINDOW = Window("left", (1.5, 2.9), (1.0, 2.1))
OFF = "pendant"
"""The lamp that is off in the second photograph."""
TABLE = (1.95, 2.05)


def sky() -> textures.Picture:
    """Dusk."""
    return textures.sky(21, (0.012, 0.022, 0.06), (0.16, 0.11, 0.12), 0.4, (-1.0, 0.5, 0.02), 1.5)


def materials(palette: Palette) -> None:
    """The groups."""
    draw, add = palette.texture, palette.add
    draw("pine planks", textures.planks(31, (0.30, 0.16, 0.065), (0.60, 0.38, 0.19), rows=12))
    draw("marble", textures.marble(32, (0.70, 0.69, 0.67), (0.16, 0.16, 0.18)))
    draw("ash", textures.wood(33, (0.27, 0.16, 0.085), (0.55, 0.38, 0.23)))
    draw("shapes", textures.shapes(36))
    draw("basil", textures.leaf(34, (0.03, 0.12, 0.015), (0.14, 0.36, 0.07), 0.36))
    draw("metro", textures.normal_map(textures.metro_height(), 0.02), data=True)
    add("floor", Paint("pine planks", roughness=0.35))
    add("wall", Paint((0.66, 0.56, 0.42), roughness=0.75))
    add("ceiling", Paint((0.80, 0.79, 0.76), roughness=0.9))
    add("trim", Paint((0.74, 0.72, 0.68), roughness=0.3))
    add("cabinet", Paint((0.045, 0.13, 0.20), roughness=0.25))
    add("worktop", Paint("marble", roughness=0.15))
    add("tiles", Paint((0.62, 0.67, 0.63), roughness=0.12, normal="metro"))
    add("steel", Paint((0.58, 0.57, 0.55), roughness=0.32, metallic=1.0))
    add("copper", Paint((0.93, 0.55, 0.36), roughness=0.1, metallic=1.0))
    add("table", Paint("ash", roughness=0.4))
    add("chair", Paint((0.50, 0.06, 0.03), roughness=0.3))
    add("bowl", Paint((0.72, 0.70, 0.64), roughness=0.15))
    add("orange", Paint((0.72, 0.22, 0.015), roughness=0.45))
    add("tin", Paint((0.40, 0.43, 0.20), roughness=0.45))
    add("leaf", Paint("basil", roughness=0.45, cutout=True))
    add("poster", Paint("shapes", roughness=0.5))
    add("black", Paint((0.02, 0.02, 0.022), roughness=0.35))
    add("glass", Paint((1.0, 1.0, 1.0), roughness=0.0, transmission=1.0, ior=1.5))
    add("pendant", lamp((36.0, 27.0, 17.0)))
    add("strip", lamp((14.0, 12.0, 9.0)))


def build(palette: Palette) -> None:
    """The things."""
    shell(WIDTH, DEPTH, HEIGHT, WINDOW, 1.9)
    counter()
    on_the_counter(palette)
    fridge()
    table(palette)
    for k, (x, y, turn) in enumerate([(1.35, 1.42, 160), (2.62, 2.75, -20), (1.45, 2.72, 14)]):
        with at((x, y, 0), turn):
            chair(f"chair {k}")
    for k, x in enumerate((-0.42, 0.42)):
        with at((TABLE[0] + x, TABLE[1], HEIGHT)):
            globe_lamp(f"pendant {k}", 0.115, "pendant", "black", 0.78)
    with at((0, 3.30, 1.60), 90):
        picture("poster", "poster", "black", 0.52, 0.72)


def counter() -> None:
    """Cabinets, worktop, tiles and cupboards along the back wall."""
    front, left, right = DEPTH - 0.60, 0.72, WIDTH
    box("plinth", (left, front + 0.05, 0.0), (right, DEPTH, 0.10), "black")
    box("cabinets", (left, front, 0.10), (right, DEPTH, 0.86), "cabinet")
    count = 6
    each = (right - left) / count
    for k in range(count):
        x = left + k * each
        box(f"cabinet door {k}", (x + 0.004, front - 0.018, 0.11), (x + each - 0.004, front, 0.855), "cabinet",
            bevel=0.004)
        handle(f"cabinet handle {k}", (x + 0.2 * each, front - 0.018, 0.79), (x + 0.8 * each, front - 0.018, 0.79),
               "steel", (0, -0.03, 0))
    box("worktop", (left, front - 0.03, 0.86), (right, DEPTH, 0.90), "worktop", bevel=0.005, scale=0.55)
    y = DEPTH - 0.004
    panel("tiles", [(left, y, 0.90), (right, y, 0.90), (right, y, 1.46), (left, y, 1.46)], "tiles",
          ((right - left) / 0.56, 1.0))
    deep = DEPTH - 0.33
    for k, (a, b) in enumerate([(left, 1.9), (2.86, right)]):
        box(f"cupboard {k}", (a, deep, 1.46), (b, DEPTH, 2.16), "trim")
        for i in range(2):
            x, half = a + i * (b - a) / 2, (b - a) / 2
            box(f"cupboard door {k}{i}", (x + 0.003, deep - 0.018, 1.46), (x + half - 0.003, deep, 2.158), "trim",
                bevel=0.004)
            foot = x + (half - 0.05 if i == 0 else 0.05)
            handle(f"cupboard handle {k}{i}", (foot, deep - 0.018, 1.52), (foot, deep - 0.018, 1.68), "steel",
                   (0, -0.028, 0))
        panel(f"strip {k}", [(a + 0.1, deep + 0.08, 1.455), (a + 0.1, deep + 0.11, 1.455),
                             (b - 0.1, deep + 0.11, 1.455), (b - 0.1, deep + 0.08, 1.455)], "strip")
    hood()


def hood() -> None:
    """The hood between the cupboards, above the hob."""
    with at((2.38, DEPTH - 0.25, 1.52)):
        turned("hood", [(0.0, 0.0), (0.44, 0.0), (0.44, 0.06), (0.15, 0.30), (0.15, 1.03)], "steel", segments=4)
    box("hob", (2.10, DEPTH - 0.55, 0.90), (2.66, DEPTH - 0.08, 0.908), "black", bevel=0.003)


def on_the_counter(palette: Palette) -> None:
    """A kettle, a pan, tins, a pot of basil and a glass jug."""
    top = 0.9
    with at((2.25, DEPTH - 0.22, top + 0.008)):
        kettle("kettle")
    with at((2.50, DEPTH - 0.36, top + 0.008)):
        turned("pan", [(0.0, 0.0), (0.105, 0.0), (0.11, 0.01), (0.11, 0.10), (0.104, 0.10), (0.104, 0.012),
                       (0.0, 0.012)], "steel")
        tube("pan handle", (0.10, -0.05, 0.085), (0.25, -0.15, 0.10), 0.011, "black")
    with at((1.28, DEPTH - 0.20, top), 10):
        box("bread bin", (-0.19, -0.11, 0.0), (0.19, 0.11, 0.20), "tin", shade="smooth")
    for k, (x, high) in enumerate([(3.12, 0.19), (3.26, 0.15), (3.38, 0.12)]):
        with at((x, DEPTH - 0.18, top)):
            turned(f"tin {k}", [(0.0, 0.0), (0.055, 0.0), (0.055, high), (0.0, high)], "tin")
            turned(f"lid {k}", [(0.0, high), (0.057, high), (0.057, high + 0.02), (0.012, high + 0.02),
                                (0.012, high + 0.04), (0.0, high + 0.04)], "table")
    with at((3.72, DEPTH - 0.25, top)):
        pot("pot", "chair", 0.085, 0.14)
        with at((0, 0, 0.11)):
            plant("basil", 35, 17, 0.15, 0.72, 50, "leaf" if palette.shows("cutouts") else None, "tin")
    with at((1.70, DEPTH - 0.33, top)):
        box("board", (-0.16, -0.10, 0.0), (0.16, 0.10, 0.018), "table", bevel=0.004, scale=1.4)
        for k, (x, y) in enumerate([(-0.05, 0.02), (0.04, -0.02)]):
            with at((x, y, 0.055)):
                ball(f"orange on the board {k}", 0.038, "orange", flat=0.95)


def kettle(name: str) -> None:
    """A kettle of copper."""
    turned(name, rounded([(0.0, 0.0), (0.10, 0.0), (0.115, 0.05), (0.085, 0.13), (0.04, 0.165), (0.0, 0.17)]), "copper")
    with at((0, 0, 0.178)):
        ball(f"{name} knob", 0.014, "black", segments=20)
    tube(f"{name} spout", (0.08, -0.03, 0.07), (0.155, -0.06, 0.15), 0.022, "copper", to=0.012)
    handle(f"{name} handle", (-0.065, 0, 0.14), (0.065, 0, 0.14), "black", (0, 0, 0.10), 0.009)


def fridge() -> None:
    """A fridge of brushed steel in the corner."""
    box("fridge", (0.03, DEPTH - 0.66, 0.03), (0.70, DEPTH - 0.02, 1.92), "steel", bevel=0.01)
    box("fridge door", (0.03, DEPTH - 0.70, 0.72), (0.70, DEPTH - 0.665, 1.92), "steel", bevel=0.012)
    box("fridge drawer", (0.03, DEPTH - 0.70, 0.05), (0.70, DEPTH - 0.665, 0.71), "steel", bevel=0.012)
    handle("fridge handle", (0.63, DEPTH - 0.70, 0.95), (0.63, DEPTH - 0.70, 1.55), "black", (0, -0.045, 0), 0.011)
    handle("drawer handle", (0.2, DEPTH - 0.70, 0.63), (0.53, DEPTH - 0.70, 0.63), "black", (0, -0.045, 0), 0.011)


def table(palette: Palette) -> None:
    """The table with a bowl of oranges and a vase."""
    with at((*TABLE, 0)):
        box("table top", (-0.78, -0.42, 0.71), (0.78, 0.42, 0.75), "table", bevel=0.008, scale=0.8)
        box("table rail", (-0.68, -0.34, 0.62), (0.68, 0.34, 0.71), "table", scale=0.8)
        for k, (x, y) in enumerate([(-0.66, -0.32), (0.66, -0.32), (-0.66, 0.32), (0.66, 0.32)]):
            tube(f"table leg {k}", (x * 1.04, y * 1.04, 0), (x, y, 0.66), 0.022, "table", to=0.034)
        with at((-0.12, 0.10, 0.75)):
            bowl("bowl", "bowl", 0.17, 0.085)
            for k in range(5):
                a = 2 * math.pi * k / 4
                where = (0.062 * math.cos(a), 0.062 * math.sin(a), 0.055) if k < 4 else (0.0, 0.0, 0.107)
                with at(where):
                    ball(f"orange {k}", 0.04, "orange", flat=0.95)
        if palette.shows("glass"):
            with at((-0.55, 0.14, 0.75)):
                vase("vase", "glass", [(0.05, 0.0), (0.065, 0.06), (0.045, 0.15), (0.032, 0.20), (0.05, 0.25)])
        for k, (x, y) in enumerate([(-0.42, -0.24), (0.36, -0.25)]):
            with at((x, y, 0.75)):
                turned(f"plate {k}", [(0.0, 0.0), (0.07, 0.0), (0.125, 0.016), (0.125, 0.019), (0.07, 0.006),
                                      (0.0, 0.006)], "bowl", segments=56)
        with at((0.33, 0.10, 0.75), 200):
            kettle("coffee pot")
        with at((0.60, 0.02, 0.75)):
            turned("cup", [(0.0, 0.0), (0.033, 0.0), (0.042, 0.03), (0.044, 0.085), (0.040, 0.085), (0.038, 0.03),
                           (0.0, 0.008)], "chair")


def chair(name: str) -> None:
    """A chair of lacquered wood that faces +y."""
    box(f"{name} seat", (-0.20, -0.20, 0.43), (0.20, 0.20, 0.46), "chair", bevel=0.012, segments=3)
    for k, (x, y) in enumerate([(-0.17, -0.17), (0.17, -0.17), (-0.17, 0.17), (0.17, 0.17)]):
        tube(f"{name} leg {k}", (1.15 * x, 1.15 * y, 0), (x, y, 0.44), 0.013, "chair", to=0.017)
    for k, x in enumerate((-0.175, 0.175)):
        tube(f"{name} post {k}", (x, 0.17, 0.45), (1.05 * x, 0.24, 0.88), 0.014, "chair")
    for k, z in enumerate((0.60, 0.70, 0.80)):
        y = 0.17 + 0.07 * (z - 0.45) / 0.43
        box(f"{name} rail {k}", (-0.18, y - 0.008, z), (0.18, y + 0.010, z + 0.055), "chair", bevel=0.006)


def lights() -> None:
    """A spot and cameras."""
    light("spot", "SPOT", 45.0, (3.3, 2.9, 2.5), (3.35, 4.05, 0.9), (1.0, 0.86, 0.68), 60.0)
    camera("camera", (3.55, 0.30, 1.55), (1.72, 3.3, 0.98), 22.0)
    camera("second view", (0.55, 0.35, 1.65), (2.7, 3.5, 0.95), 22.0)


def portal() -> None:
    """The window's portal."""
    (y0, y1), (z0, z1) = WINDOW.y, WINDOW.z
    window_portal((-0.2, y0, z0), (-0.2, y1, z1), 1.0)
