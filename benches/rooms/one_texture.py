"""One unknown texture in a room where all else is known, as in the notebook of ReSTIR_GI_DR:

    one_texture.py make ROOMS.json TASK FOLDER OUT      photo.exr, given.xml, and task.json with the names of all groups
    one_texture.py mitsuba ROOMS.json TASK OUT SECONDS  optimises with Mitsuba as the notebook does: mitsuba.json
    one_texture.py error ROOMS.json TASK OUT RESULT     compares the texture of a result of unrender: error.json

The notebook's measure: the mean of (a - b)^2 / (b^2 + 0.01) over all texels, b the true ones. Its loss is the same of
the picture, its optimiser Adam with 32 samples per pixel and one for the gradient. Paths are as short as there.
"""

import copy
import json
import os
import sys
import time

import engine
import mitsuba as mi
import numpy as np

engine.start()
import drjit as dr
import estimate
import materials
import pictures
import prepare
import scene_file as sf

SPP, SPP_GRADIENT = 32, 1
PHOTO_SPP, PASS = 512, 64
START = 0.5


def relative(a, b):
    """The notebook's measure."""
    return (a - b) ** 2 / (b ** 2 + 1e-2)


def texture_key(parameters, group):
    """The parameter of the group's base colour."""
    keys = [key for key in parameters.keys() if key.startswith(f'{group}.') and key.endswith('.data')]
    return next(key for key in keys if 'base_color' in key or 'reflectance' in key)


def true_texels(out, group):
    parameters = mi.traverse(engine.load_scene(os.path.join(out, 'truth.xml')))
    return np.array(parameters[texture_key(parameters, group)])[..., :3]


def base_of(root, group):
    return materials.reflectance(sf.leaf(next(bsdf for bsdf in root.findall('bsdf') if bsdf.get('id') == group)))


def make(task, folder, out):
    os.makedirs(out, exist_ok=True)
    root = sf.load(os.path.join(folder, task['file']))
    for integrator in root.findall('integrator'):
        root.remove(integrator)
    log = []
    prepare.drop_absent(root, log)
    sf.name_groups(root)
    materials.for_mitsuba_3(root, log)
    root.find('sensor').set('id', 'photo')
    prepare.set_film(root.find('sensor'), task['size'])
    root = sf.without_glass(root)
    given = copy.deepcopy(root)
    # Bytes have no gradient.
    sf.add(base_of(root, task['group']), 'string', name='format', value='variant')
    sf.write(root, os.path.join(out, 'truth.xml'))
    base = base_of(given, task['group'])
    name = base.get('name')
    base.clear()
    base.tag = 'rgb'
    base.attrib.update(name=name, value=', '.join([str(START)] * 3))
    sf.write(given, os.path.join(out, 'given.xml'))
    scene = engine.load_scene(os.path.join(out, 'truth.xml'))
    integrator = mi.load_dict({'type': 'path', 'max_depth': task['max_depth'], 'rr_depth': 100})
    passes = [np.array(mi.render(scene, spp=PASS, seed=seed, integrator=integrator), np.float64)
              for seed in range(PHOTO_SPP // PASS)]
    pictures.write(os.path.join(out, 'photo.exr'), np.mean(passes, 0))
    return {'groups': [bsdf.get('id') for bsdf in given.findall('bsdf')], 'changes': log}


def optimise(task, out, seconds):
    scene = engine.load_scene(os.path.join(out, 'truth.xml'))
    parameters = mi.traverse(scene)
    key = texture_key(parameters, task['group'])
    truth = np.array(parameters[key])
    start = np.full(truth.shape, START, np.float32)
    adam = mi.ad.Adam(lr=task['rate'])
    adam[key] = mi.TensorXf(start)
    parameters.update(adam)
    photo = mi.TensorXf(pictures.read(os.path.join(out, 'photo.exr')))
    integrator = mi.load_dict({'type': 'prb', 'max_depth': task['max_depth'], 'rr_depth': 100})
    started, count, halved = time.time(), 0, 0
    while time.time() - started < seconds:
        picture = mi.render(scene, parameters, spp=SPP, spp_grad=SPP_GRADIENT, integrator=integrator,
                            seed=2 * count, seed_grad=2 * count + 1)
        dr.backward(dr.mean(relative(picture, photo), axis=None))
        adam.step()
        adam[key] = dr.clip(adam[key], 0.001, 0.999)
        parameters.update(adam)
        count += 1
        due = int((time.time() - started) / seconds * (task['halvings'] + 1))
        if due > halved:
            halved = due
            adam.set_learning_rate(task['rate'] * 0.5 ** halved)
    found = np.array(parameters[key])[..., :3]
    return {'seconds': time.time() - started, 'iterations': count,
            'error': float(relative(found, truth[..., :3]).mean())}


def compare(task, out, result):
    """The error of a result's texture, at the true one's texels."""
    with open(os.path.join(result, 'materials.json')) as file:
        group = json.load(file)['groups'][task['group']]
    truth = true_texels(out, task['group'])
    if not group.get('texture'):
        return {'error': float(relative(np.array(group['rho_d']), truth).mean())}
    stem = os.path.splitext(group['texture'])[0]
    found = pictures.read(os.path.join(result, f'{stem}.exr'))
    height, width = truth.shape[:2]
    v, u = np.mgrid[0:height, 0:width]
    uv = np.stack([(u + 0.5) / width, (v + 0.5) / height], 2)
    return {'error': float(relative(estimate.texels(found, uv) * estimate.scale_to_seen(group), truth).mean())}


def main():
    act, rooms, name = sys.argv[1:4]
    with open(rooms) as file:
        task = json.load(file)['one_texture'][name]
    if act == 'make':
        folder, out = sys.argv[4:6]
        answer, file = make(task, folder, out), 'task.json'
    elif act == 'mitsuba':
        out = sys.argv[4]
        answer, file = optimise(task, out, float(sys.argv[5])), 'mitsuba.json'
    else:
        out = sys.argv[4]
        answer, file = compare(task, out, sys.argv[5]), 'error.json'
    with open(os.path.join(out, file), 'w') as written:
        json.dump(answer, written, indent=1)


if __name__ == '__main__':
    main()
