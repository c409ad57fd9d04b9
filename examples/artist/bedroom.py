"""A bedroom under an overcast sky, with a lamp at the bed and one at the ceiling."""


import textures
from materials import Paint, Palette, lamp
from modelling import at, ball, box, curtain, cushion, panel, rounded, tube, turned
from photograph import camera, light, window_portal
from shell import Window, globe_lamp, picture, plant, pot, sheet, shell, vase

WIDTH, DEPTH, HEIGHT = 4.4, 4.6, 2.6
WINDOW = Window("left", (1.7, 3.3), (0.8, 2.2))
OFF = "bedside lamp"
"""The lamp that is off in the second photograph."""


def sky() -> textures.Picture:
    """A grey sky in the late afternoon."""
    return textures.sky(41, (1.4, 1.65, 2.1), (2.0, 2.1, 2.3), 1.3, (-1.0, 0.3, 0.35), 0.8)


def materials(palette: Palette) -> None:
    """The groups."""
    draw, add = palette.texture, palette.add
    draw("parquet", textures.parquet(51, (0.13, 0.055, 0.022), (0.36, 0.19, 0.085)))
    draw("cherry", textures.wood(52, (0.16, 0.055, 0.022), (0.34, 0.14, 0.06)))
    draw("plaid", textures.plaid(53, (0.48, 0.44, 0.37), (0.08, 0.13, 0.16), (0.55, 0.24, 0.06)))
    draw("shapes", textures.shapes(59))
    draw("palm", textures.leaf(54, (0.02, 0.06, 0.025), (0.09, 0.22, 0.09), 0.13))
    draw("quilt", textures.normal_map(textures.quilt_height(), 0.05), data=True)
    add("floor", Paint("parquet", roughness=0.22))
    add("wall", Paint((0.47, 0.55, 0.58), roughness=0.7))
    add("ceiling", Paint((0.82, 0.82, 0.80), roughness=0.9))
    add("trim", Paint((0.77, 0.76, 0.73), roughness=0.3))
    add("linen", Paint((0.76, 0.74, 0.70), roughness=0.95))
    add("blanket", Paint("plaid", roughness=1.0))
    add("headboard", Paint((0.24, 0.12, 0.15), roughness=0.7, normal="quilt"))
    add("bed", Paint("cherry", roughness=0.3))
    add("pillow", Paint((0.33, 0.14, 0.13), roughness=0.9))
    add("wardrobe", Paint((0.60, 0.58, 0.53), roughness=0.2))
    add("mirror", Paint((0.92, 0.92, 0.92), roughness=0.0, metallic=1.0))
    add("brass", Paint((0.88, 0.66, 0.34), roughness=0.15, metallic=1.0))
    add("iron", Paint((0.42, 0.41, 0.40), roughness=0.45, metallic=1.0))
    add("rug", Paint((0.58, 0.53, 0.45), roughness=1.0))
    add("stool", Paint((0.05, 0.16, 0.15), roughness=0.5))
    add("poster", Paint("shapes", roughness=0.4))
    add("leaf", Paint("palm", roughness=0.4, cutout=True))
    add("curtain", Paint((0.55, 0.50, 0.44), roughness=0.9))
    add("glass", Paint((1.0, 1.0, 1.0), roughness=0.0, transmission=1.0, ior=1.5))
    add("bedside lamp", lamp((26.0, 17.0, 8.5)))
    add("ceiling lamp", lamp((6.0, 5.0, 3.8)))


def build(palette: Palette) -> None:
    """The things."""
    shell(WIDTH, DEPTH, HEIGHT, WINDOW, 1.8)
    panel("rug", [(0.75, 1.35, 0.012), (3.05, 1.35, 0.012), (3.05, 2.35, 0.012), (0.75, 2.35, 0.012)], "rug")
    bed()
    for k, x in enumerate((0.86, 3.34)):
        with at((x, DEPTH - 0.24, 0)):
            nightstand(f"nightstand {k}")
    with at((0.86, DEPTH - 0.24, 0.52)):
        bedside_lamp()
    with at((3.34, DEPTH - 0.24, 0.52)):
        if palette.shows("glass"):
            vase("carafe", "glass", [(0.05, 0.0), (0.075, 0.04), (0.065, 0.12), (0.028, 0.18), (0.036, 0.23)])
        with at((-0.13, -0.10, 0.0), 12):
            box("book", (-0.06, -0.08, 0.0), (0.06, 0.08, 0.03), "pillow", bevel=0.003)
    wardrobe()
    with at((2.1, DEPTH, 1.78)):
        picture("poster", "poster", "brass", 1.0, 0.66)
    with at((0.40, 3.72, 0)):
        pot("pot", "trim", 0.17, 0.34)
        with at((0, 0, 0.29)):
            plant("palm", 55, 22, 0.58, 0.75, 46, "leaf" if palette.shows("cutouts") else None, "stool")
    with at((1.05, 1.72, 0), 24):
        box("stool", (-0.21, -0.21, 0.10), (0.21, 0.21, 0.42), "stool", shade="smooth")
        for k, (x, y) in enumerate([(-0.16, -0.16), (0.16, -0.16), (-0.16, 0.16), (0.16, 0.16)]):
            tube(f"stool foot {k}", (x, y, 0), (x, y, 0.11), 0.014, "brass", to=0.02)
    radiator()
    for k, (a, b) in enumerate([(1.28, 1.72), (3.28, 3.70)]):
        curtain(f"curtain {k}", (0.16, a, 0.04), (0.16, b, 0.04), 2.38, "curtain", folds=5)
    tube("curtain rod", (0.16, 1.2, 2.40), (0.16, 3.8, 2.40), 0.013, "brass")
    with at((2.1, 2.2, HEIGHT)):
        globe_lamp("ceiling lamp", 0.19, "ceiling lamp", "iron", 0.42)


def bed() -> None:
    """The bed with its head against the back wall."""
    left, right, foot, head = 1.25, 2.95, 2.48, DEPTH - 0.10
    box("bed side left", (left, foot, 0.14), (left + 0.05, head, 0.34), "bed", bevel=0.006, scale=0.8)
    box("bed side right", (right - 0.05, foot, 0.14), (right, head, 0.34), "bed", bevel=0.006, scale=0.8)
    box("bed foot", (left, foot - 0.05, 0.0), (right, foot, 0.42), "bed", bevel=0.008, scale=0.8)
    box("headboard", (left - 0.03, head, 0.0), (right + 0.03, DEPTH, 1.22), "bed", bevel=0.008, scale=0.8)
    panel("headboard quilt", [(left + 0.03, head - 0.006, 0.45), (right - 0.03, head - 0.006, 0.45),
                              (right - 0.03, head - 0.006, 1.16), (left + 0.03, head - 0.006, 1.16)], "headboard",
          ((right - left) / 0.71, 1.0))
    box("mattress", (left + 0.04, foot + 0.03, 0.26), (right - 0.04, head - 0.02, 0.54), "linen", bevel=0.06,
        segments=4)
    sheet("duvet", "linen", (left + 0.06, foot + 0.06), (right - 0.06, head - 0.62), 0.575, 0.10)
    sheet("blanket", "blanket", (left + 0.05, foot + 0.02), (right - 0.05, foot + 0.98), 0.59, 0.20, (2.2, 1.0))
    for k, x in enumerate((1.68, 2.52)):
        with at((x, head - 0.28, 0.65), 0, (28, 0)):
            cushion(f"white pillow {k}", (0.72, 0.46, 0.19), "linen")
    for k, (x, turn) in enumerate([(1.84, 9), (2.34, -7)]):
        with at((x, head - 0.50, 0.72), turn, (52, 0)):
            cushion(f"pillow {k}", (0.42, 0.40, 0.16), "pillow")


def nightstand(name: str) -> None:
    """A nightstand with a drawer."""
    box(name, (-0.23, -0.20, 0.14), (0.23, 0.20, 0.52), "bed", bevel=0.006, scale=1.1)
    box(f"{name} drawer", (-0.21, -0.215, 0.33), (0.21, -0.20, 0.50), "wardrobe", bevel=0.004)
    tube(f"{name} knob", (0, -0.215, 0.415), (0, -0.24, 0.415), 0.012, "brass")
    for k, (x, y) in enumerate([(-0.20, -0.17), (0.20, -0.17), (-0.20, 0.17), (0.20, 0.17)]):
        tube(f"{name} leg {k}", (x, y, 0), (x, y, 0.15), 0.014, "bed", to=0.02)


def bedside_lamp() -> None:
    """A ball of light on a turned foot."""
    turned("lamp foot", rounded([(0.0, 0.0), (0.085, 0.0), (0.08, 0.02), (0.022, 0.05), (0.034, 0.12), (0.05, 0.19),
                                 (0.018, 0.25), (0.014, 0.30)]), "brass")
    with at((0, 0, 0.385)):
        ball("bedside lamp", 0.095, "bedside lamp", segments=32)


def wardrobe() -> None:
    """A wardrobe at the right wall, one of its doors a mirror."""
    x0, x1, y0, y1, top = WIDTH - 0.58, WIDTH - 0.01, 1.25, 3.35, 2.2
    box("wardrobe", (x0, y0, 0.06), (x1, y1, top), "wardrobe", bevel=0.006)
    each = (y1 - y0) / 3
    for k in range(3):
        a, b = y0 + k * each + 0.004, y0 + (k + 1) * each - 0.004
        box(f"wardrobe door {k}", (x0 - 0.02, a, 0.09), (x0, b, top - 0.02), "wardrobe", bevel=0.005)
        tube(f"wardrobe knob {k}", (x0 - 0.02, b - 0.05, 1.08), (x0 - 0.045, b - 0.05, 1.08), 0.013, "brass")
    a, b = y0 + each + 0.07, y0 + 2 * each - 0.09
    panel("mirror", [(x0 - 0.0215, b, 0.25), (x0 - 0.0215, a, 0.25), (x0 - 0.0215, a, 2.02),
                     (x0 - 0.0215, b, 2.02)], "mirror")
    box("wardrobe plinth", (x0 + 0.03, y0 + 0.02, 0.0), (x1, y1 - 0.02, 0.06), "iron")


def radiator() -> None:
    """A radiator of bare iron under the window."""
    for k in range(14):
        y = 1.95 + 0.085 * k
        box(f"radiator rib {k}", (0.05, y, 0.14), (0.13, y + 0.062, 0.66), "iron", bevel=0.02, segments=3)
    tube("radiator pipe", (0.09, 1.85, 0.2), (0.09, 3.2, 0.2), 0.014, "iron")


def lights() -> None:
    """A point light in the corner behind the camera, and cameras."""
    light("bulb", "POINT", 18.0, (3.9, 0.35, 2.2), (0, 0, 0), (1.0, 0.82, 0.62))
    camera("camera", (3.30, 0.28, 1.52), (1.75, 3.6, 0.84), 21.0)
    camera("second view", (0.95, 0.40, 1.55), (2.55, 3.7, 0.80), 21.0)


def portal() -> None:
    """The window's portal."""
    (y0, y1), (z0, z1) = WINDOW.y, WINDOW.z
    window_portal((-0.2, y0, z0), (-0.2, y1, z1), 1.0)
