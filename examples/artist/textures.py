"""Textures of the rooms, drawn by numpy: colours, cut-outs, normal maps and skies.

Colours are linear until they are encoded; arrays are (rows, columns, channels) with the top row first. Every
texture repeats without a seam and depends on its seed alone.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Picture = NDArray[np.float64]

SIZE = 1024
"""Texels along a side. Half of it blurs the grain in the foreground of a 768-pixel photograph; twice as much
makes scene files of 30 MB and shows nothing more."""


def encoded(linear: Picture) -> Picture:
    """The sRGB curve, IEC 61966-2-1."""
    clipped = np.clip(linear, 0.0, 1.0)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)


def mixed(low: ArrayLike, high: ArrayLike, share: Picture) -> Picture:
    """From colour ``low`` at share 0 to ``high`` at 1, by texel."""
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    return low + (high - low) * np.clip(share, 0.0, 1.0)[..., None]


def texels(size: int = SIZE) -> tuple[Picture, Picture]:
    """Texel centres, 0 to 1: to the right and downwards."""
    line = (np.arange(size) + 0.5) / size
    across, down = np.meshgrid(line, line)
    return across, down


def noise(rng: np.random.Generator, cells: tuple[int, int], size: int = SIZE) -> Picture:
    """Periodic value noise from 0 to 1 with ``cells`` (down, across)."""
    lattice = rng.random(cells)

    def spread(values: Picture, axis: int) -> Picture:
        count = values.shape[axis]
        at = np.arange(size) * count / size
        low = at.astype(int)
        share = at - low
        share = share * share * (3.0 - 2.0 * share)
        shape = (-1, 1) if axis == 0 else (1, -1)
        weight = share.reshape(shape)
        first = np.take(values, low % count, axis=axis)
        return first + (np.take(values, (low + 1) % count, axis=axis) - first) * weight

    return spread(spread(lattice, 0), 1)


def fractal(rng: np.random.Generator, cells: tuple[int, int], octaves: int, size: int = SIZE) -> Picture:
    """Octaves of noise, each of twice the cells and half the amplitude; mean about 0.5."""
    total, weight = np.zeros((size, size)), 0.0
    for octave in range(octaves):
        share = 0.5**octave
        scaled = (cells[0] * 2**octave, cells[1] * 2**octave)
        total += share * noise(rng, scaled, size)
        weight += share
    return total / weight


def grain(rng: np.random.Generator, size: int = SIZE) -> Picture:
    """Wood grain along the rows, 0 to 1."""
    wide = fractal(rng, (16, 2), 3, size)
    fine = fractal(rng, (128, 4), 2, size)
    rings = 0.5 + 0.5 * np.sin(2 * np.pi * (7.0 * wide + 0.6 * fine))
    return np.clip(0.45 * rings + 0.55 * fine, 0.0, 1.0)


def shifted(values: Picture, down: NDArray[np.int64], across: NDArray[np.int64]) -> Picture:
    """``values`` read at another place for every texel."""
    rows, columns = np.indices(values.shape)
    return values[(rows + down) % values.shape[0], (columns + across) % values.shape[1]]


def planks(seed: int, dark: ArrayLike, light: ArrayLike, rows: int = 10) -> Picture:
    """Floorboards along the rows, two to a row, with dark joints."""
    rng = np.random.default_rng(seed)
    across, down = texels()
    row = (down * rows).astype(int)
    joints = 0.5 * rng.random(rows)
    along = (across - joints[row]) % 1.0
    board = 2 * row + (along >= 0.5)
    tone = rng.random(2 * rows)[board]
    offset = rng.integers(0, SIZE, size=(2, 2 * rows))
    figure = shifted(grain(rng), offset[0][board], offset[1][board])
    colour = mixed(dark, light, 0.15 + 0.45 * tone + 0.4 * figure)
    edge = np.minimum(down * rows - row, 1.0 - (down * rows - row)) / rows
    end = np.minimum(along % 0.5, 0.5 - along % 0.5)
    joint = (edge < 0.0016) | (end < 0.0012)
    return np.where(joint[..., None], 0.25 * np.asarray(dark, dtype=float), colour)


def parquet(seed: int, dark: ArrayLike, light: ArrayLike, length: int = 5, repeats: int = 2) -> Picture:
    """Herringbone: blocks of ``length`` squares, laid in both directions."""
    rng = np.random.default_rng(seed)
    period = 2 * length
    squares = period * repeats
    across, down = texels()
    x, y = across * squares, down * squares
    column, line = x.astype(int), y.astype(int)
    step = (column - line) % period
    lying = step < length
    start_x = np.where(lying, column - step, column)
    start_y = np.where(lying, line, line - (period - 1 - step))
    along = np.where(lying, x - start_x, y - start_y)
    beside = np.where(lying, y - start_y, x - start_x)
    block = (start_x % squares) * squares + start_y % squares
    tone = rng.random(squares * squares)[block]
    figure = grain(rng)
    texel = SIZE // squares
    offset = rng.integers(0, SIZE, size=(2, squares * squares))
    rows = ((beside * texel).astype(int) + offset[0][block]) % SIZE
    columns = ((along * texel).astype(int) + offset[1][block]) % SIZE
    colour = mixed(dark, light, 0.1 + 0.5 * tone + 0.4 * figure[rows, columns])
    joint = np.minimum(np.minimum(beside, 1 - beside), np.minimum(along, length - along)) < 0.025
    return np.where(joint[..., None], 0.3 * np.asarray(dark, dtype=float), colour)


def wood(seed: int, dark: ArrayLike, light: ArrayLike) -> Picture:
    """One board, grain along the rows."""
    return mixed(dark, light, grain(np.random.default_rng(seed)))


def marble(seed: int, ground: ArrayLike, vein: ArrayLike) -> Picture:
    """Veins where a fractal passes its middle value."""
    rng = np.random.default_rng(seed)
    cloud = fractal(rng, (3, 3), 6)
    veins = np.exp(-np.abs(fractal(rng, (2, 2), 6) - 0.5) / 0.012)
    veins = np.maximum(veins, 0.6 * np.exp(-np.abs(fractal(rng, (4, 4), 5) - 0.5) / 0.01))
    return mixed(ground, vein, 0.75 * veins * cloud * 1.6 + 0.25 * cloud)


def carpet(seed: int, ground: ArrayLike, figure: ArrayLike, border: ArrayLike) -> Picture:
    """A woven rug: diamonds within a border, and the unevenness of wool."""
    rng = np.random.default_rng(seed)
    across, down = texels()
    wave = np.abs((across * 6) % 1.0 - 0.5) + np.abs((down * 4) % 1.0 - 0.5)
    diamond = ((wave * 4).astype(int) % 2 == 1).astype(float)
    colour = mixed(ground, figure, diamond)
    rim = np.minimum(np.minimum(across, 1 - across) * 1.4, np.minimum(down, 1 - down))
    colour = np.where((rim < 0.07)[..., None], np.asarray(border, dtype=float), colour)
    colour = np.where(((rim > 0.035) & (rim < 0.045))[..., None], np.asarray(ground, dtype=float), colour)
    return colour * (0.75 + 0.5 * fractal(rng, (96, 96), 3))[..., None]


def plaid(seed: int, ground: ArrayLike, stripe: ArrayLike, thin: ArrayLike) -> Picture:
    """A blanket of crossing stripes."""
    rng = np.random.default_rng(seed)
    across, down = texels()
    broad = 0.5 * ((across * 4) % 1.0 < 0.45) + 0.5 * ((down * 4) % 1.0 < 0.45)
    colour = mixed(ground, stripe, broad)
    line = (np.abs((across * 4) % 1.0 - 0.7) < 0.02) | (np.abs((down * 4) % 1.0 - 0.7) < 0.02)
    colour = np.where(line[..., None], np.asarray(thin, dtype=float), colour)
    return colour * (0.8 + 0.4 * fractal(rng, (128, 128), 2))[..., None]


def mountains(seed: int) -> Picture:
    """A poster: the sun above ranges of hills, a white margin and lines like print."""
    rng = np.random.default_rng(seed)
    across, down = texels()
    colour = mixed((0.85, 0.42, 0.22), (0.80, 0.70, 0.45), down * 1.6)
    sun = (across - 0.63) ** 2 + ((down - 0.34) * 1.25) ** 2 < 0.016
    colour = np.where(sun[..., None], np.array((0.82, 0.16, 0.07)), colour)
    shades = [(0.22, 0.33, 0.42), (0.10, 0.20, 0.28), (0.04, 0.10, 0.13)]
    for number, shade in enumerate(shades):
        crest = 0.42 + 0.13 * number + 0.22 * (fractal(rng, (1, 4 + number), 5)[0] - 0.5)
        colour = np.where((down > crest)[..., None], np.array(shade), colour)
    margin = np.minimum(np.minimum(across, 1 - across), np.minimum(down, 0.86 - down)) < 0.06
    colour = np.where(margin[..., None], np.array((0.80, 0.78, 0.72)), colour)
    words = (np.abs(down - 0.90) < 0.018) & (np.abs((across * 14) % 1.0 - 0.5) < 0.33)
    words &= (across > 0.2) & (across < 0.8)
    return np.where(words[..., None], np.array((0.05, 0.05, 0.06)), colour)


def shapes(seed: int) -> Picture:
    """A poster of plain shapes."""
    rng = np.random.default_rng(seed)
    across, down = texels()
    colour = np.broadcast_to(np.array((0.78, 0.72, 0.60)), (SIZE, SIZE, 3)).copy()
    palette = [(0.70, 0.09, 0.05), (0.04, 0.12, 0.33), (0.80, 0.48, 0.06), (0.03, 0.03, 0.04),
               (0.10, 0.35, 0.30)]
    for number in range(5):
        x, y = 0.2 + 0.6 * rng.random(2)
        radius = 0.10 + 0.14 * rng.random()
        here = (across - x) ** 2 + (down - y) ** 2 < radius**2
        if number % 2:
            here &= (across - x) * np.cos(number) + (down - y) * np.sin(number) > 0
        colour = np.where(here[..., None], np.array(palette[number]), colour)
    bar = np.abs((across - 0.5) * 0.8 + (down - 0.5) * 0.6) < 0.012
    colour = np.where(bar[..., None], np.array(palette[3]), colour)
    margin = np.minimum(np.minimum(across, 1 - across), np.minimum(down, 1 - down)) < 0.05
    return np.where(margin[..., None], np.array((0.82, 0.80, 0.76)), colour)


def leaf(seed: int, dark: ArrayLike, light: ArrayLike, width: float = 0.24) -> Picture:
    """A leaf with its stem at the lower edge: colour and coverage, (rows, columns, 4)."""
    rng = np.random.default_rng(seed)
    size = SIZE // 2
    across, down = texels(size)
    up, beside = 1.0 - down, across - 0.5
    half = width * np.sin(np.pi * np.clip((up - 0.12) / 0.86, 0.0, 1.0)) ** 0.7
    inside = (np.abs(beside) < half) & (up > 0.12)
    stem = (np.abs(beside) < 0.014) & (up <= 0.2)
    rib = np.exp(-np.abs(beside) / 0.008)
    side = np.exp(-np.abs(((up - 0.9 * np.abs(beside)) * 12) % 1.0 - 0.5) / 0.06)
    share = 0.35 * fractal(rng, (8, 8), 4, size) + 0.5 * np.maximum(rib, 0.5 * side)
    return np.dstack([mixed(dark, light, share), (inside | stem).astype(float)])


def normal_map(height: Picture, depth: float) -> Picture:
    """Tangent-space normals of a height from 0 to 1, green upwards; ``depth`` is in sides of the texture."""
    size = height.shape[0]
    right = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) * (0.5 * size * depth)
    up = (np.roll(height, 1, 0) - np.roll(height, -1, 0)) * (0.5 * size * depth)
    normal = np.dstack([-right, -up, np.ones_like(height)])
    return 0.5 + 0.5 * normal / np.linalg.norm(normal, axis=2, keepdims=True)


def knit_height(columns: int = 10) -> Picture:
    """Stitches of thick wool."""
    across, down = texels()
    x = across * columns
    slope = np.abs(x % 1.0 - 0.5)
    stitch = np.abs(np.sin(np.pi * (down * columns + slope)))
    return np.sqrt(np.clip(np.sin(np.pi * (x % 1.0)) * stitch, 0.0, 1.0))


def quilt_height(count: int = 4) -> Picture:
    """Upholstery drawn in at the corners of diamonds."""
    across, down = texels()
    one, other = (across + down) * count, (across - down) * count
    return (np.abs(np.sin(np.pi * one)) * np.abs(np.sin(np.pi * other))) ** 0.4


def metro_height(rows: int = 4) -> Picture:
    """Bevelled wall tiles, twice as wide as high, in bond."""
    across, down = texels()
    y = down * rows
    x = across * (rows / 2) + 0.5 * (y.astype(int) % 2)
    edge_y = np.minimum(y % 1.0, 1 - y % 1.0)
    edge_x = 2.0 * np.minimum(x % 1.0, 1 - x % 1.0)
    return np.clip(np.minimum(edge_x, edge_y) / 0.14, 0.0, 1.0)


def sky(seed: int, zenith: ArrayLike, horizon: ArrayLike, clouds: float, sun: ArrayLike, glow: float) -> Picture:
    """A panorama of radiance, 512 rows: a gradient, clouds, a glow about the sun's direction, hills below.

    Its centre is Blender's +x; to the right of it lies -y.
    """
    rng = np.random.default_rng(seed)
    rows = 512
    line = (np.arange(2 * rows) + 0.5) / (2 * rows)
    azimuth, height = np.meshgrid((0.5 - line) * 2 * np.pi, (0.5 - (np.arange(rows) + 0.5) / rows) * np.pi)
    up = np.sin(height)
    direction = np.dstack([np.cos(azimuth) * np.cos(height), np.sin(azimuth) * np.cos(height), up])
    toward = direction @ (np.asarray(sun, dtype=float) / np.linalg.norm(sun))
    colour = mixed(horizon, zenith, np.clip(up, 0.0, 1.0) ** 0.45)
    wide = np.repeat(fractal(rng, (6, 6), 6, rows), 2, axis=1)
    cover = np.clip((wide - 0.62 + 0.3 * clouds) * 5.0, 0.0, 1.0) * np.clip(up * 6.0, 0.0, 1.0)
    white = 1.4 * np.max(np.asarray(horizon, dtype=float)) * np.array((1.0, 0.97, 0.93))
    colour = colour + (white - colour) * (0.8 * cover)[..., None]
    colour = colour * (1.0 + glow * np.exp((toward - 1.0) * 25.0))[..., None]
    crest = 0.02 + 0.16 * (fractal(rng, (1, 24), 6, 2 * rows)[0] - 0.4)
    trees = fractal(rng, (40, 80), 5, 2 * rows)[::2]
    depth = np.clip((crest - up) * 4.0, 0.0, 1.0)
    shade = mixed((0.13, 0.16, 0.13), (0.04, 0.07, 0.015), depth)
    ground = np.asarray(horizon, dtype=float) * shade * (0.4 + 2.4 * np.clip(trees - 0.25, 0.0, 1.0))[..., None]
    return mixed(colour, ground, (crest - up) * rows / 4.0 + 0.5)
