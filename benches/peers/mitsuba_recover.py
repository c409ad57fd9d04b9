"""Recovers reflectances by Mitsuba 3 alone: Adam on the gradients of `prb`. ASKED.json has

scene, photo       the files; groups that reflect by the plugin `ward` are glossy
diffuse, glossy    the groups to recover, by name
truth              by group: rho_d, and for glossy ones rho_s, alpha_x, alpha_y
theta              the initial anisotropy direction, radians; the true one is zero
spp, rate, seconds paths per pixel, Adam's initial learning rate, and when to give up

Prints a line of JSON for each iteration: iteration, seconds, and the largest errors rho, alpha
(relative) and degrees. Compiling is not counted.
"""

import json
import math
import sys
import time

import mitsuba as mi

mi.set_variant('llvm_ad_rgb')
import drjit as dr
import ward

# With one thread, Mitsuba 3.9.1 waits for ever when it reads an EXR.
dr.set_thread_count(max(2, dr.thread_count()))
ward.register()
asked = json.load(open(sys.argv[1]))
# With optimisation, groups with equal initial materials would be merged.
scene = mi.load_file(asked['scene'], optimize=False)
photo = mi.TensorXf(mi.Bitmap(asked['photo']).convert(
    mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False))
integrator = mi.load_dict({'type': 'prb', 'max_depth': -1})

params = mi.traverse(scene)
LOBE = ['rho_s', 'alpha_x', 'alpha_y', 'theta']
rho_d = {g: f'm_{g}.brdf_0.reflectance.value' for g in asked['diffuse']}
rho_d.update({g: f'm_{g}.rho_d' for g in asked['glossy']})
keys = list(rho_d.values()) + [f'm_{g}.{name}' for g in asked['glossy'] for name in LOBE]
params.keep(keys)
# A short memory of gradient sizes: the first gradients are much larger than later ones.
adam = mi.ad.Adam(lr=asked['rate'], beta_2=0.99)
for key in keys:
    adam[key] = mi.Float(asked['theta']) if key.endswith('.theta') else params[key]
    dr.make_opaque(adam[key])
params.update(adam)


def clamp():
    for key in keys:
        if 'alpha' in key:
            adam[key] = dr.clip(adam[key], 0.01, 1)
        elif 'theta' not in key:
            adam[key] = dr.clip(adam[key], 0, 1)


def slow_down(iteration):
    """Steps decrease with time; those of roughnesses are a tenth of those of reflectances."""
    rate = asked['rate'] / (1 + iteration / 100)
    adam.set_learning_rate({key: rate / 10 if 'alpha' in key else rate for key in keys})


def gradients(iteration):
    picture = mi.render(scene, params, integrator=integrator, spp=asked['spp'],
                        seed=2 * iteration, seed_grad=2 * iteration + 1)
    # Relative errors took several times as many iterations.
    dr.backward(dr.mean(dr.square(picture - photo), axis=None))


def errors():
    """The largest error of a reflectance, of a roughness (relative), and of a direction (degrees)."""
    value = {key: [channel[0] for channel in adam[key]] if 'rho' in key or 'reflectance' in key
             else [adam[key][0]] for key in keys}
    rho, alpha, degrees = 0, 0, 0
    for group, truth in asked['truth'].items():
        pairs = list(zip(value[rho_d[group]], truth['rho_d']))
        if group in asked['glossy']:
            pairs += zip(value[f'm_{group}.rho_s'], truth['rho_s'])
            for name in ['alpha_x', 'alpha_y']:
                found = value[f'm_{group}.{name}'][0]
                alpha = max(alpha, abs(found - truth[name]) / truth[name])
            turned = math.degrees(value[f'm_{group}.theta'][0]) % 180
            degrees = max(degrees, min(turned, 180 - turned))
        rho = max([rho] + [abs(a - b) for a, b in pairs])
    return {'rho': rho, 'alpha': alpha, 'degrees': degrees}


print(json.dumps({'version': mi.__version__}), flush=True)
# Compiles; the step is not taken.
gradients(0)
for key in keys:
    dr.eval(dr.grad(adam[key]))
    dr.clear_grad(adam[key])
dr.sync_thread()
spent, iteration = 0, 0
while spent < asked['seconds']:
    iteration += 1
    started = time.perf_counter()
    gradients(iteration)
    slow_down(iteration)
    adam.step()
    clamp()
    params.update(adam)
    dr.eval(*[adam[key] for key in keys])
    dr.sync_thread()
    spent += time.perf_counter() - started
    print(json.dumps({'iteration': iteration, 'seconds': spent, **errors()}), flush=True)
