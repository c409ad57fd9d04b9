"""Photographs a prepared room with Mitsuba and writes its truth: ROOMS.json ROOM PREPARED OUT [SPP].

`prepare.py` has made PREPARED; OUT is the folder that `truth.py` describes."""

import json
import os
import sys
import time

import engine
import mitsuba as mi
import numpy as np

engine.start()
import brightness
import drjit as dr
import pictures
import truth as truth_format

# Samples per pixel of one pass, which bounds memory.
PASS = 64
# The share of the pixels without lamps and glass that is brighter than white in photo.png.
CLIPPED = 0.02


def render(path, camera, spp, seed):
    scene = engine.load_scene(path)
    total, done = 0, 0
    while done < spp:
        count = min(PASS, spp - done)
        picture = mi.render(scene, sensor=camera, spp=count, seed=1000 * seed + done,
                            integrator=engine.path_integrator())
        total = total + np.array(picture, np.float64) * count
        done += count
    return (total / spp).astype(np.float32)


def visible(scene, camera, size):
    """What the camera sees at 4 x 4 points of every pixel: number of the group, albedo, texture coordinates.
    Number 0 is nothing."""
    width, height = size
    names, numbers = [''], {}
    for shape in scene.shapes():
        bsdf = shape.bsdf()
        if bsdf.id() not in names:
            names.append(bsdf.id())
        index = int(np.array(dr.reinterpret_array(mi.UInt32, mi.BSDFPtr(bsdf)))[0])
        numbers[index] = names.index(bsdf.id())
    table = np.zeros(max(numbers) + 1, int)
    table[list(numbers)] = list(numbers.values())
    y, x = (axis.ravel() for axis in np.mgrid[0:height, 0:width])
    groups, albedos, uvs = [], [], []
    for point in range(truth_format.POINTS):
        at = mi.Point2f(mi.Float((x + (point % 4 + 0.5) / 4) / width),
                        mi.Float((y + (point // 4 + 0.5) / 4) / height))
        ray, _ = scene.sensors()[camera].sample_ray(0, 0.5, at, mi.Point2f(0.5, 0.5))
        hit = scene.ray_intersect(ray)
        bsdf = hit.bsdf()
        index = np.minimum(np.array(dr.reinterpret_array(mi.UInt32, bsdf)), len(table) - 1)
        groups.append(np.where(np.array(hit.is_valid()), table[index], 0).reshape(height, width))
        albedo = np.array(bsdf.eval_diffuse_reflectance(hit, hit.is_valid())).T.reshape(height, width, 3)
        albedos.append(np.nan_to_num(albedo))
        uvs.append(np.array(hit.uv).T.reshape(height, width, 2))
    return names, np.stack(groups), np.stack(albedos), np.stack(uvs)


def write_maps(room, known, seen, out):
    """The maps of the photograph; returns the groups as truth.json lists them."""
    names, groups, albedos, uvs = seen
    first = groups[0]
    left_out = [True] + [known[name]['left_out'] is not None for name in names[1:]]
    glass = [number for number, name in enumerate(names) if name and known[name]['left_out'] == 'glass']
    through_glass = np.isin(groups, glass).any(0)
    scored = (groups == first).all(0) & ~through_glass & ~np.array(left_out)[first]
    albedo, roughness = albedos, np.ones(first.shape)
    listed = []
    for number, name in enumerate(names):
        inside = first == number
        about = known.get(name)
        if about is not None:
            if about['plastic'] is not None:
                albedo[:, inside] = brightness.seen(albedo[:, inside], about['plastic'])
            if about['metal'] is not None:
                albedo[:, inside] += np.array(about['metal'])
            roughness[inside] = about['roughness']
        keys = ('kind', 'textured', 'bumps', 'left_out')
        listed.append({'name': name, 'pixels': int((scored & inside).sum()),
                       **{key: about[key] if about else None for key in keys}})
    write = lambda name, values: pictures.write(os.path.join(out, f'{name}.exr'), values)
    write('group', first)
    write('scored', scored)
    write('albedo', albedo.mean(0))
    write('roughness', roughness)
    width, height = room['size']
    write('uv', np.concatenate([uvs, np.zeros(uvs.shape[:3] + (1,))], 3).reshape(-1, width, 3))
    pictures.write_png(os.path.join(out, 'mask.png'), np.where(through_glass, 0.0, 1.0)[..., None].repeat(3, 2))
    return listed, first, through_glass | np.array([not n or known[n]['left_out'] == 'lamp' for n in names])[first]


def write_new_view(known, seen, out):
    names, groups, _, _ = seen
    left_out = np.array([True] + [known[name]['left_out'] is not None for name in names[1:]])
    scored = ~left_out[groups].any(0)
    pictures.write(os.path.join(out, 'group_new_view.exr'), groups[0])
    pictures.write(os.path.join(out, 'scored_new_view.exr'), scored)


def exposure_of(photo, unusable):
    """The radiance of white: few usable pixels are brighter. Two digits, so that a project states it exactly."""
    levels = photo.max(2)[~unusable]
    return float(f'{np.quantile(levels, 1 - CLIPPED):.2g}')


def main():
    rooms, name, prepared, out = sys.argv[1:5]
    spp = int(sys.argv[5]) if len(sys.argv) > 5 else 512
    with open(rooms) as file:
        room = json.load(file)['rooms'][name]
    with open(os.path.join(prepared, 'groups.json')) as file:
        groups = json.load(file)
    os.makedirs(out, exist_ok=True)
    started = time.time()
    inside = lambda name: os.path.join(prepared, name)
    maps = engine.load_scene(inside('albedo.xml'))
    seen = [visible(maps, camera, room['size']) for camera in (0, 1)]
    listed, _, unusable = write_maps(room, groups['groups'], seen[0], out)
    write_new_view(groups['groups'], seen[1], out)
    # Scene, camera, share of the samples.
    shots = {
        'photo': ('truth.xml', 0, 1),
        'new_view': ('truth.xml', 1, 2),
        'new_light': ('truth_new_light.xml', 0, 2),
    }
    taken = {}
    for seed, (shot, (file, camera, share)) in enumerate(shots.items()):
        taken[shot] = render(inside(file), camera, max(1, spp // share), seed)
        pictures.write(os.path.join(out, f'{shot}.exr'), taken[shot])
        print(f'{name}: {shot} after {time.time() - started:.0f} s', flush=True)
    exposure = exposure_of(taken['photo'], unusable)
    pictures.write_png(os.path.join(out, 'photo.png'), pictures.srgb(taken['photo'] / exposure))
    about = {'version': truth_format.VERSION, 'room': name, 'size': room['size'], 'exposure': exposure,
             'renderer': f'Mitsuba {mi.__version__}', 'spp': spp, 'groups': listed, 'changes': groups['changes']}
    # Last: a folder with it is complete.
    with open(os.path.join(out, 'truth.json'), 'w') as file:
        json.dump(about, file, indent=1)


if __name__ == '__main__':
    main()
