# SPDX-License-Identifier: GPL-3.0-or-later
"""Recovers the materials of a modelled scene from one photograph of it, or several, in five steps.

The panel is in the sidebar of the 3D view. The Python package ``unrender``, which the extension
contains as a wheel, does the computations; the modules here pass Blender's scene to it, and its
results back.
"""

from . import apply, composite, match, panel, pick, prepare, properties, recover, shots

MODULES = (properties, match, pick, shots, prepare, recover, apply, composite, panel)


def register():
    for module in MODULES:
        module.register()


def unregister():
    for module in reversed(MODULES):
        module.unregister()
