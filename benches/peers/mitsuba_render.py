"""Renders a scene for Mitsuba 3 as often as requested: VARIANT SCENE.xml.

Prints a line of JSON when the scene is loaded, then one for each line of JSON that it reads,
{"spp", "seed", "picture"}: {"seconds"}, without the time to write the picture.
"""

import json
import sys
import time

import mitsuba as mi

variant, path = sys.argv[1:3]
mi.set_variant(variant)
import drjit as dr

# With one thread, Mitsuba 3.9.1 waits for ever when it reads an EXR.
dr.set_thread_count(max(2, dr.thread_count()))

if variant != 'scalar_rgb':
    import ward
    ward.register()

scene = mi.load_file(path)
# Mitsuba's own Russian roulette, from the fifth bounce on.
integrator = mi.load_dict({'type': 'path', 'max_depth': -1})
print(json.dumps({'version': mi.__version__}), flush=True)
for line in sys.stdin:
    asked = json.loads(line)
    started = time.perf_counter()
    picture = mi.render(scene, integrator=integrator, spp=asked['spp'], seed=asked['seed'])
    if variant != 'scalar_rgb':
        dr.eval(picture)
        dr.sync_thread()
    seconds = time.perf_counter() - started
    bitmap = mi.Bitmap(picture)
    bitmap = bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    bitmap.write(asked['picture'])
    print(json.dumps({'seconds': seconds}), flush=True)
