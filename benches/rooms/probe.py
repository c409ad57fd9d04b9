"""Tries Mitsuba: renders one pixel by the variant that the other scripts use."""

import engine

engine.start()
import mitsuba as mi
import numpy as np

film = {'type': 'hdrfilm', 'width': 1, 'height': 1, 'rfilter': {'type': 'box'}}
scene = mi.load_dict({'type': 'scene', 'light': {'type': 'constant'}, 'camera': {'type': 'perspective', 'film': film}})
seen = np.array(mi.render(scene, spp=1, integrator=engine.path_integrator()))
assert np.allclose(seen, 1, atol=0.1), seen
