"""A result of unrender as the maps that `score.py` compares: albedo and roughness of every pixel, statuses by group."""

import json
import os

import numpy as np

import pictures

# What a dielectric reflects at normal incidence; a free lobe up to this and somewhat more is a plastic's.
DIELECTRIC = 0.04
METALLIC = 0.1


def texels(texture, uv):
    """Bilinear values of a repeated texture at coordinates (..., 2), with the first row at v = 0."""
    height, width = texture.shape[:2]
    x, y = uv[..., 0] % 1 * width - 0.5, uv[..., 1] % 1 * height - 0.5
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = (x - left)[..., None], (y - top)[..., None]
    at = lambda i, j: texture[(top + j) % height, (left + i) % width]
    upper = at(0, 0) * (1 - fx) + at(1, 0) * fx
    lower = at(0, 1) * (1 - fx) + at(1, 1) * fx
    return upper * (1 - fy) + lower * fy


def scale_to_seen(group):
    """From rho_d to the reflectance seen at normal incidence, where the file states it."""
    base, seen = (np.array(group.get(key) or [1.0] * 3) for key in ('rho_d', 'albedo_d'))
    if group.get('albedo_d') is None:
        return np.ones(3)
    return np.divide(seen, base, out=np.ones(3), where=base > 1e-6)


def lobe_albedo(group):
    """What the lobe adds to the albedo at normal incidence: a metal's reflectance, nothing for a plastic's."""
    lobe = np.array(group.get('rho_s') or [0.0] * 3)
    form = group.get('reflectance')
    if form == 'dielectric':
        return np.zeros(3)
    if form == 'metal':
        return lobe
    return np.maximum(lobe - DIELECTRIC, 0) if lobe.max() > METALLIC else np.zeros(3)


def roughness(group):
    """sqrt(alpha), Burley's roughness; 1 without a lobe."""
    if max(group.get('rho_s') or [0]) <= 0:
        return 1.0
    return ((group.get('alpha_x') or 0) * (group.get('alpha_y') or 0)) ** 0.25


def maps(truth, result):
    """Albedo, roughness and statuses of a result's folder."""
    with open(os.path.join(result, 'materials.json')) as file:
        groups = json.load(file)['groups']
    height, width = truth.group.shape
    albedo, rough = np.zeros((height, width, 3)), np.ones((height, width))
    uv = truth.uv() if any(group.get('texture') for group in groups.values()) else None
    for name in truth.names:
        group, inside = groups.get(name), truth.pixels_of(name)
        if group is None or not inside.any():
            continue
        if group.get('texture'):
            # The radiometric one of the two files.
            stem = os.path.splitext(group['texture'])[0]
            base = texels(pictures.read(os.path.join(result, f'{stem}.exr')), uv[inside]).mean(1)
        else:
            base = np.array(group.get('rho_d') or [0.0] * 3)
        albedo[inside] = base * scale_to_seen(group) + lobe_albedo(group)
        rough[inside] = roughness(group)
    kept = ('status', 'hypothesis', 'reflectance', 'error', 'rho_d', 'rho_s', 'alpha_x', 'alpha_y')
    statuses = {name: {key: group[key] for key in kept if group.get(key) is not None}
                for name, group in groups.items()}
    return albedo, rough, statuses
