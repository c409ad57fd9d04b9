"""Mitsuba 3.9.1, as all scripts here start it."""

import os
import sys

import mitsuba as mi

VERSION = '3.9.1'
if mi.__version__ != VERSION:
    # Version 3.10 has other names for the parameters of meshes.
    sys.exit(f'this is Mitsuba {mi.__version__}; needed is {VERSION}: .ci/programs mitsuba')
sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'peers'))


def start(variant='llvm_ad_rgb'):
    """Chooses the variant. With one thread, 3.9.1 waits for ever when it reads an EXR."""
    mi.set_variant(variant)
    import drjit as dr
    dr.set_thread_count(max(2, dr.thread_count()))
    if variant == 'llvm_ad_rgb':
        import ward
        ward.register()


def path_integrator():
    # Paths of Bitterli's files end here.
    return mi.load_dict({'type': 'path', 'max_depth': 65})


def load_scene(path, **changes):
    # With optimisation, equal materials would become one.
    return mi.load_file(path, optimize=False, **changes)
