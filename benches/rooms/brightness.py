"""What a plastic reflects at normal incidence: the albedo of the diffuse surface that is as bright there.

Light that enters a plastic is reflected between its base and its surface, so that the base d appears as

    k d / (1 - d f),    smooth: k = (1 - F0)^2 / n^2, f the mean internal Fresnel reflectance;

in a linear plastic as k d / (1 - f). In Mitsuba's rough ones k and f depend on the lobe's width: a white base is
1.015, 0.966, 0.913, 0.853, 0.793 at alpha 0, 0.05, 0.1, 0.15, 0.2 (n = 1.5). Both are measured here on the plugin.
"""

import numpy as np


def response(plastic, base):
    """pi times the diffuse part of the plugin's BRDF, from and to its normal."""
    import drjit as dr
    import mitsuba as mi
    rough = plastic['alpha'] > 0
    entry = {
        'type': 'roughplastic' if rough else 'plastic',
        'int_ior': plastic['int_ior'],
        'ext_ior': plastic['ext_ior'],
        'nonlinear': plastic['nonlinear'],
        'diffuse_reflectance': {'type': 'rgb', 'value': [base] * 3},
        'specular_reflectance': {'type': 'rgb', 'value': [0.0] * 3},
    }
    if rough:
        entry.update(alpha=plastic['alpha'], distribution=plastic['distribution'])
    interaction = dr.zeros(mi.SurfaceInteraction3f)
    interaction.wi = mi.Vector3f(0, 0, 1)
    value = mi.load_dict(entry).eval(mi.BSDFContext(), interaction, mi.Vector3f(0, 0, 1))
    return float(np.pi * np.array(value).ravel()[0])


def coefficients(plastic):
    """k and f of a plastic as the module's head has them; f is 0 for a linear one."""
    tiny = 1e-3
    dark, white = response(plastic, tiny) / tiny, response(plastic, 1.0)
    f = 1 - dark / white
    # Once more, as 1e-3 is not quite dark.
    k = dark * (1 - tiny * f)
    return k, 1 - k / white


def seen(base, plastic):
    """The albedo at normal incidence of a plastic with this base."""
    k, f = coefficients(plastic)
    return k * base / (1 - f * base)
