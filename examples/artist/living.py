"""A living room by day: the sky and the sun through a window, and a floor lamp."""

import textures
from materials import Paint, Palette, lamp
from modelling import at, box, curtain, cushion, panel, rounded, tube, turned
from photograph import camera, light, window_portal
from shell import Window, books, bowl, picture, plant, pot, shell, vase

WIDTH, DEPTH, HEIGHT = 4.8, 5.4, 2.65
WINDOW = Window("right", (1.9, 4.1), (0.55, 2.25))
SUN = (0.80, -0.32, 0.62)
OFF = "floor lamp"
"""The lamp that is off in the second photograph."""


def sky() -> textures.Picture:
    """A blue sky with clouds."""
    return textures.sky(11, (0.5, 0.9, 1.8), (1.7, 1.9, 2.1), 0.55, SUN, 1.2)


def materials(palette: Palette) -> None:
    """The groups."""
    draw, add = palette.texture, palette.add
    draw("oak planks", textures.planks(1, (0.20, 0.10, 0.045), (0.50, 0.30, 0.15)))
    draw("walnut", textures.wood(2, (0.055, 0.026, 0.014), (0.21, 0.11, 0.055)))
    draw("hills", textures.mountains(3))
    draw("wool rug", textures.carpet(4, (0.55, 0.50, 0.42), (0.30, 0.07, 0.05), (0.05, 0.07, 0.13)))
    draw("monstera", textures.leaf(5, (0.018, 0.07, 0.014), (0.10, 0.26, 0.05)))
    draw("knit", textures.normal_map(textures.knit_height(), 0.035), data=True)
    add("floor", Paint("oak planks", roughness=0.28))
    add("wall", Paint((0.74, 0.72, 0.67), roughness=0.8))
    add("ceiling", Paint((0.83, 0.83, 0.81), roughness=0.9))
    add("trim", Paint((0.78, 0.77, 0.74), roughness=0.3))
    add("sofa", Paint((0.085, 0.145, 0.17), roughness=0.95))
    add("cushion", Paint((0.62, 0.31, 0.05), roughness=0.9))
    add("rug", Paint("wool rug", roughness=1.0))
    add("poster", Paint("hills", roughness=0.45))
    add("brass", Paint((0.89, 0.68, 0.36), roughness=0.12, metallic=1.0))
    add("steel", Paint((0.56, 0.55, 0.53), roughness=0.38, metallic=1.0))
    add("table", Paint("walnut", roughness=0.2))
    add("sideboard", Paint((0.09, 0.20, 0.16), roughness=0.32))
    add("speaker", Paint((0.025, 0.025, 0.028), roughness=0.4))
    add("pot", Paint((0.42, 0.17, 0.085), roughness=0.7))
    add("leaf", Paint("monstera", roughness=0.4, cutout=True))
    add("pouf", Paint((0.58, 0.53, 0.46), roughness=0.9, normal="knit"))
    add("curtain", Paint((0.66, 0.62, 0.55), roughness=0.85))
    add("glass", Paint((1.0, 1.0, 1.0), roughness=0.0, transmission=1.0, ior=1.5))
    add("floor lamp", lamp((15.0, 10.5, 6.0)))


def build(palette: Palette) -> None:
    """The things."""
    shell(WIDTH, DEPTH, HEIGHT, WINDOW, 2.2)
    panel("rug", [(1.05, 1.9, 0.012), (3.55, 1.9, 0.012), (3.55, 3.75, 0.012), (1.05, 3.75, 0.012)], "rug")
    sofa()
    table(palette)
    sideboard()
    floor_lamp()
    with at((2.35, DEPTH, 1.72)):
        picture("poster", "poster", "brass", 1.25, 0.88)
    with at((4.32, 4.72, 0)):
        pot("pot", "pot", 0.2, 0.36)
        with at((0, 0, 0.3)):
            plant("monstera", 7, 21, 0.50, 0.66, 58, "leaf" if palette.shows("cutouts") else None, "sideboard")
    with at((3.75, 1.72, 0)):
        turned("pouf", rounded([(0.0, 0.0), (0.2, 0.0), (0.31, 0.09), (0.33, 0.2), (0.29, 0.33), (0.17, 0.40),
                                (0.0, 0.405)], 5), "pouf", repeat=(4, 1), shade="smooth")
    for k, (a, b) in enumerate([(1.45, 1.95), (4.05, 4.5)]):
        curtain(f"curtain {k}", (WIDTH - 0.09, b, 0.03), (WIDTH - 0.09, a, 0.03), 2.42, "curtain", folds=5)
    tube("curtain rod", (WIDTH - 0.09, 1.3, 2.44), (WIDTH - 0.09, 4.7, 2.44), 0.014, "steel")


def sofa() -> None:
    """A sofa against the back wall, with cushions."""
    with at((2.35, 4.72, 0)):
        box("sofa base", (-1.05, -0.42, 0.14), (1.05, 0.44, 0.30), "sofa", bevel=0.03, segments=3)
        for k, x in enumerate((-0.5, 0.5)):
            box(f"sofa seat {k}", (x - 0.44, -0.46, 0.30), (x + 0.44, 0.26, 0.47), "sofa", bevel=0.05, segments=4)
            with at((x, 0.30, 0.44), tilt=(-9, 0)):
                box(f"sofa back {k}", (-0.44, -0.10, 0.0), (0.44, 0.09, 0.44), "sofa", bevel=0.07, segments=4)
        for k, x in enumerate((-1.0, 1.0)):
            box(f"sofa arm {k}", (x - 0.09, -0.44, 0.14), (x + 0.09, 0.44, 0.62), "sofa", bevel=0.05, segments=4)
        for k, (x, y) in enumerate([(-0.95, -0.36), (0.95, -0.36), (-0.95, 0.36), (0.95, 0.36)]):
            tube(f"sofa foot {k}", (x, y, 0), (x, y, 0.15), 0.018, "brass", to=0.026)
        for k, (x, turn) in enumerate([(-0.68, 16), (0.66, -12)]):
            with at((x, 0.07, 0.66), turn, (68, 0)):
                cushion(f"cushion {k}", (0.44, 0.42, 0.17), "cushion")


def table(palette: Palette) -> None:
    """The coffee table with what stands on it."""
    with at((2.3, 2.95, 0.012)):
        box("table top", (-0.58, -0.34, 0.37), (0.58, 0.34, 0.41), "table", bevel=0.008, scale=0.9)
        box("table shelf", (-0.50, -0.28, 0.14), (0.50, 0.28, 0.16), "table", bevel=0.004, scale=0.9)
        for k, (x, y) in enumerate([(-0.52, -0.28), (0.52, -0.28), (-0.52, 0.28), (0.52, 0.28)]):
            tube(f"table leg {k}", (x, y, 0), (x, y, 0.37), 0.016, "steel")
        with at((-0.3, 0.06, 0.41)):
            if palette.shows("glass"):
                vase("vase", "glass", [(0.055, 0.0), (0.085, 0.05), (0.075, 0.14), (0.04, 0.21), (0.052, 0.26)])
        with at((0.22, -0.06, 0.41)):
            bowl("brass bowl", "brass", 0.14, 0.085)
        with at((-0.02, 0.14, 0.41), 18):
            box("book one", (-0.13, -0.09, 0.0), (0.13, 0.09, 0.028), "pot", bevel=0.003)
        with at((-0.02, 0.14, 0.438), 7):
            box("book two", (-0.10, -0.075, 0.0), (0.10, 0.075, 0.022), "speaker", bevel=0.003)


def sideboard() -> None:
    """A sideboard at the left wall, with a speaker whose cube is shaded smooth all over, and books."""
    with at((0.235, 3.75, 0)):
        box("sideboard", (-0.21, -0.85, 0.14), (0.21, 0.85, 0.66), "sideboard", bevel=0.008)
        for k in range(3):
            y = -0.84 + 0.56 * k
            box(f"sideboard door {k}", (0.21, y + 0.005, 0.16), (0.228, y + 0.555, 0.64), "sideboard", bevel=0.005)
            tube(f"sideboard knob {k}", (0.228, y + 0.48, 0.42), (0.25, y + 0.48, 0.42), 0.013, "brass")
        for k, (x, y) in enumerate([(-0.15, -0.75), (0.15, -0.75), (-0.15, 0.75), (0.15, 0.75)]):
            tube(f"sideboard leg {k}", (x, y, 0), (x, y, 0.14), 0.02, "steel")
        with at((0.0, 0.50, 0.66), -8):
            box("speaker", (-0.12, -0.12, 0.0), (0.12, 0.12, 0.36), "speaker", shade="smooth")
        with at((-0.08, -0.62, 0.66), 90):
            books("book", 3, 9, ["pot", "cushion", "trim", "speaker"])
        with at((0.02, 0.08, 0.66)):
            turned("vessel", rounded([(0.0, 0.0), (0.05, 0.0), (0.095, 0.09), (0.07, 0.18), (0.03, 0.23),
                                      (0.04, 0.26)]), "trim")


def floor_lamp() -> None:
    """A lamp with a glowing shade beside the sofa."""
    with at((0.72, 4.95, 0)):
        turned("lamp foot", [(0.0, 0.0), (0.15, 0.0), (0.15, 0.018), (0.03, 0.028), (0.0, 0.028)], "steel")
        tube("lamp stem", (0, 0, 0.02), (0, 0, 1.42), 0.011, "steel")
        turned("floor lamp", [(0.0, 1.36), (0.17, 1.36), (0.13, 1.62), (0.0, 1.62)], "floor lamp")


def lights() -> None:
    """Sun and cameras."""
    light("sun", "SUN", 6.0, SUN, (0, 0, 0), (1.0, 0.93, 0.80))
    camera("camera", (0.75, 0.35, 1.45), (2.75, 3.9, 0.92), 23.0)
    camera("second view", (3.9, 0.5, 1.6), (1.2, 4.2, 0.75), 22.0)


def portal() -> None:
    """The window's portal."""
    (y0, y1), (z0, z1) = WINDOW.y, WINDOW.z
    window_portal((WIDTH + 0.2, y0, z0), (WIDTH + 0.2, y1, z1), -1.0)
