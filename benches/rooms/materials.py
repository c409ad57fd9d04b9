"""True materials: what a BSDF of Mitsuba is as albedo and roughness, and its nearest form in Mitsuba 3.9.1."""

import copy
import math

import scene_file as sf

PLASTICS = {'plastic', 'roughplastic'}
CONDUCTORS = {'conductor', 'roughconductor'}
# Mitsuba's indices of refraction by name, of those that the rooms use.
IOR = {'air': 1.000277, 'vacuum': 1.0, 'water': 1.3330, 'silicone oil': 1.52045, 'bk7': 1.5046,
       'polypropylene': 1.49, 'acrylic glass': 1.49, 'pet': 1.575, 'diamond': 2.419}
# Mitsuba 0.6's default.
ALPHA = 0.1


def reflectance(leaf):
    """The element of the base colour: a colour or a texture; None for metals and glass."""
    for name in ('reflectance', 'diffuse_reflectance', 'base_color'):
        found = sf.find(leaf, name)
        if found is not None:
            return found
    return None


def alpha(leaf):
    """Width of a rough lobe; an anisotropic one by its geometric mean."""
    for axes in (('alpha_u', 'alpha_v'), ('alpha_x', 'alpha_y')):
        both = [sf.number(leaf, name, None) for name in axes]
        if None not in both:
            return math.sqrt(both[0] * both[1])
    return sf.number(leaf, 'alpha', ALPHA)


def ior(leaf, name, default):
    found = sf.find(leaf, name)
    if found is None:
        return default
    value = found.get('value')
    return IOR[value.lower()] if found.tag == 'string' else float(value)


def conductor_color(leaf):
    """A metal's reflectance at normal incidence; None if the file names a measured metal."""
    scale = sf.color(leaf, 'specular_reflectance', 1.0)
    if sf.text(leaf, 'material') == 'none':
        return scale
    eta, k = sf.color(leaf, 'eta', None), sf.color(leaf, 'k', None)
    if eta == [None] * 3:
        return None
    return [s * ((n - 1) ** 2 + q * q) / ((n + 1) ** 2 + q * q) for s, n, q in zip(scale, eta, k)]


def truth(bsdf):
    """What is known of a group's true material without its textures.

    `kind` is Mitsuba's plugin; `roughness` is sqrt(alpha), 1 without a lobe, 0 for a mirror; `metal` the
    reflectance at normal incidence. `left_out` says why no pixel of the group is scored."""
    leaf = sf.leaf(bsdf)
    kind = leaf.get('type')
    base = reflectance(leaf)
    found = {
        'kind': kind,
        'textured': base is not None and base.tag == 'texture',
        'bumps': sf.has(bsdf, {'bumpmap', 'normalmap'}),
        'roughness': 1.0,
        'metal': None,
        'plastic': None,
        'left_out': None,
    }
    if sf.is_lamp(bsdf.get('id')):
        found['left_out'] = 'lamp'
    elif sf.is_glass(bsdf):
        found['left_out'] = 'glass'
    elif sf.has(bsdf, {'mask'}):
        found['left_out'] = 'mask'
    if kind in ('plastic', 'conductor'):
        found['roughness'] = 0.0
    elif kind in ('roughplastic', 'roughconductor', 'ward'):
        found['roughness'] = math.sqrt(alpha(leaf))
    elif kind == 'principled':
        found['roughness'] = sf.number(leaf, 'roughness', 0.5)
    if kind in PLASTICS:
        found['plastic'] = {
            'alpha': 0.0 if kind == 'plastic' else alpha(leaf),
            'distribution': sf.text(leaf, 'distribution', 'beckmann'),
            'int_ior': ior(leaf, 'int_ior', 1.49),
            'ext_ior': ior(leaf, 'ext_ior', 1.000277),
            'nonlinear': sf.text(leaf, 'nonlinear', 'false') == 'true',
        }
    if kind in CONDUCTORS:
        found['metal'] = conductor_color(leaf)
        if found['metal'] is None:
            found['metal'] = named_metal(sf.text(leaf, 'material', 'Cu'))
    if kind == 'ward':
        # A lobe over a diffuse part; what it adds counts as a metal's.
        found['metal'] = sf.color(leaf, 'rho_s', 0.0)
    return found


def named_metal(name):
    """The reflectance at normal incidence of a metal that Mitsuba has by name."""
    import drjit as dr
    import mitsuba as mi
    metal = mi.load_dict({'type': 'conductor', 'material': name})
    interaction = dr.zeros(mi.SurfaceInteraction3f)
    interaction.wi = mi.Vector3f(0, 0, 1)
    _, weight = metal.sample(mi.BSDFContext(), interaction, 0.5, mi.Point2f(0.5, 0.5))
    return [float(weight[channel]) for channel in range(3)]


def for_mitsuba_3(root, log):
    """Replaces what Mitsuba 3.9.1 has not by the nearest that it has; `log` gets a line for each."""
    for texture in root.iter('texture'):
        kept = sf.find(texture, 'filter_type')
        if kept is not None and kept.get('value') == 'trilinear':
            kept.set('value', 'bilinear')
        gamma = sf.find(texture, 'gamma')
        if gamma is not None:
            # Mitsuba 3 knows values as they are, and those of sRGB.
            texture.remove(gamma)
            if float(gamma.get('value')) == 1:
                sf.add(texture, 'boolean', name='raw', value='true')
    for element in root.iter('spectrum'):
        if len(sf.numbers(element.get('value'))) == 3:
            element.tag = 'rgb'
    for bsdf in root.findall('bsdf'):
        for each in list(bsdf.iter('bsdf')):
            nearest(each, bsdf.get('id'), log)


def nearest(bsdf, name, log):
    kind = bsdf.get('type')
    around = sf.find(bsdf, 'ext_eta') if kind in CONDUCTORS else None
    if around is not None:
        # Mitsuba 3 has metals in air alone.
        bsdf.remove(around)
        if float(around.get('value')) != 1:
            log.append(f"{name}: its surroundings of {around.get('value')} are air")
    if kind == 'phong':
        # The lobe's width by its exponent: alpha = sqrt(2 / (n + 2)) [Walter et al. 2007].
        width = math.sqrt(2 / (sf.number(bsdf, 'exponent', 30.0) + 2))
        base = copy.deepcopy(sf.find(bsdf, 'diffuse_reflectance'))
        sf.clear(bsdf, 'roughplastic')
        sf.add(bsdf, 'float', name='alpha', value=width)
        if base is not None:
            bsdf.append(base)
        log.append(f'{name}: phong is a rough plastic of alpha {width:.3f}')
    elif kind == 'roughdiffuse':
        base = copy.deepcopy(sf.find(bsdf, 'reflectance'))
        sf.clear(bsdf, 'diffuse')
        if base is not None:
            bsdf.append(base)
        log.append(f'{name}: roughdiffuse is diffuse')
    elif kind == 'ward':
        width, diffuse, lobe = alpha(bsdf), *(sf.color(bsdf, f'{part}_reflectance', default) for part, default
                                              in (('diffuse', 0.5), ('specular', 0.2)))
        sf.clear(bsdf, 'ward')
        for key, values in (('rho_d', diffuse), ('rho_s', lobe)):
            sf.add(bsdf, 'rgb', name=key, value=', '.join(map(str, values)))
        for key in ('alpha_x', 'alpha_y'):
            sf.add(bsdf, 'float', name=key, value=width)
        sf.add(bsdf, 'boolean', name='gmd', value='true')
    elif kind in ('coating', 'roughcoating'):
        # The layer is left out: its reflection is 4 % beside what is below it.
        inner = copy.deepcopy(bsdf.find('bsdf'))
        sf.clear(bsdf, inner.get('type'))
        bsdf.extend(list(inner))
        log.append(f'{name}: its {kind} is left out')


def as_albedo(root):
    """Each material as a diffuse one of its base colour: black where it has none."""
    root = copy.deepcopy(root)
    for bsdf in root.findall('bsdf'):
        leaf = sf.leaf(bsdf)
        base = copy.deepcopy(reflectance(leaf))
        if base is None and leaf.get('type') == 'ward':
            base = copy.deepcopy(sf.find(leaf, 'rho_d'))
        if base is None and leaf.get('type') in PLASTICS | {'diffuse'}:
            base = sf.ET.Element('rgb', value='0.5')
        if base is None:
            base = sf.ET.Element('rgb', value='0')
        base.set('name', 'reflectance')
        sf.clear(bsdf, 'twosided')
        sf.add(bsdf, 'bsdf', type='diffuse').append(base)
    return root
