"""Mitsuba's own inverse of a room, for comparison: PREPARED TRUTH SECONDS OUT.

Adam on the gradients of `prb`, on a Principled material for each group: base colour, roughness and metallic. Light,
camera and glass are given; unlike unrender, it is told which groups have a texture, and gets one of 256 x 256 texels
for each. Writes albedo.exr and roughness.exr, which `score.py` compares with the truth.
"""

import os
import sys
import time

import engine
import mitsuba as mi
import numpy as np

engine.start()
import drjit as dr
import estimate
import pictures
import scene_file as sf
from truth import Truth

TEXELS = 256
START = {'base_color': 0.5, 'roughness': 0.6, 'metallic': 0.1}
# Adam's step, and the smaller one of the last part of the time.
RATE, LAST_RATE, LAST_PART = 0.02, 0.005, 0.7
# Samples per pixel of a picture and of its gradient: noise of the gradient is averaged over iterations.
SPP, SPP_GRADIENT = 16, 8
# Share of white below which differences count as absolute ones.
DARK = 0.05


def principled(root, textured, grey):
    """Replaces every material that is to be found; returns the groups."""
    found = []
    for bsdf in root.findall('bsdf'):
        name = bsdf.get('id')
        if sf.is_lamp(name) or sf.is_glass(bsdf):
            continue
        sf.clear(bsdf, 'twosided')
        inner = sf.add(bsdf, 'bsdf', type='principled')
        if name in textured:
            texture = sf.add(inner, 'texture', type='bitmap', name='base_color')
            sf.add(texture, 'string', name='filename', value=grey)
            sf.add(texture, 'boolean', name='raw', value='true')
        else:
            sf.add(inner, 'rgb', name='base_color', value=', '.join([str(START['base_color'])] * 3))
        for key in ('roughness', 'metallic'):
            sf.add(inner, 'float', name=key, value=START[key])
        found.append(name)
    return found


def optimise(scene, truth, seconds):
    """The parameters after so many seconds."""
    parameters = mi.traverse(scene)
    endings = ('base_color.value', 'base_color.data', 'roughness.value', 'metallic.value')
    keys = [key for key in parameters.keys() if key.endswith(endings)]
    parameters.keep(keys)
    adam = mi.ad.Adam(lr=RATE)
    for key in keys:
        adam[key] = parameters[key]
    parameters.update(adam)
    photo = mi.TensorXf(truth.picture('photo'))
    weight = mi.TensorXf(truth.scored.astype(np.float32)[..., None])
    floor = DARK * truth.about['exposure']
    integrator = mi.load_dict({'type': 'prb', 'max_depth': 8, 'rr_depth': 4})
    started, count = time.time(), 0
    while time.time() - started < seconds:
        if time.time() - started > LAST_PART * seconds:
            adam.set_learning_rate(LAST_RATE)
        picture = mi.render(scene, parameters, sensor=0, spp=SPP, spp_grad=SPP_GRADIENT, integrator=integrator,
                            seed=2 * count, seed_grad=2 * count + 1)
        dr.backward(dr.mean(weight * dr.abs(picture - photo) / (photo + floor), axis=None))
        adam.step()
        for key in keys:
            adam[key] = dr.clip(adam[key], 0.01 if 'roughness' in key else 0.001, 0.999)
        parameters.update(adam)
        count += 1
    print(f'{count} iterations in {time.time() - started:.0f} s', flush=True)
    return {key: np.array(parameters[key]) for key in keys}


def maps(truth, groups, values):
    """Albedo and roughness of every pixel."""
    height, width = truth.group.shape
    albedo, rough, uv = np.zeros((height, width, 3)), np.ones((height, width)), truth.uv()
    for name in groups:
        if name not in truth.names:
            continue
        inside = truth.pixels_of(name)
        for key, value in values.items():
            if not key.startswith(f'{name}.'):
                continue
            if key.endswith('base_color.data'):
                albedo[inside] = estimate.texels(value, uv[inside]).mean(1)
            elif key.endswith('base_color.value'):
                albedo[inside] = value.ravel()
            elif 'roughness' in key:
                rough[inside] = float(value.ravel()[0])
    return albedo, rough


def main():
    prepared, truth, seconds, out = sys.argv[1:5]
    truth = Truth(truth)
    os.makedirs(out, exist_ok=True)
    grey = os.path.join(out, 'grey.exr')
    pictures.write(grey, np.full((TEXELS, TEXELS, 3), START['base_color']))
    root = sf.load(os.path.join(prepared, 'truth.xml'))
    textured = {group['name'] for group in truth.about['groups'] if group['textured']}
    groups = principled(root, textured, grey)
    sf.write(root, os.path.join(out, 'scene.xml'))
    values = optimise(engine.load_scene(os.path.join(out, 'scene.xml')), truth, float(seconds))
    albedo, rough = maps(truth, groups, values)
    pictures.write(os.path.join(out, 'albedo.exr'), albedo)
    pictures.write(os.path.join(out, 'roughness.exr'), rough)


if __name__ == '__main__':
    main()
