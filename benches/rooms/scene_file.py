"""Mitsuba's scene files as trees: the parts of them that the other scripts look for or change.

Files of Mitsuba 0.5 and 0.6 spell names in camelCase, those of Mitsuba 3 with underscores; `find` takes both.
"""

import copy
import os
import re
import xml.etree.ElementTree as ET

GLASS = {'dielectric', 'thindielectric', 'roughdielectric'}
# BSDFs that only wrap another one.
WRAPPERS = {'twosided', 'bumpmap', 'normalmap', 'mask'}


def plain(name):
    """A name without what the versions of the format spell differently."""
    return (name or '').replace('_', '').lower()


def find(element, name):
    """The child of this name, or None."""
    wanted = plain(name)
    return next((child for child in element if plain(child.get('name')) == wanted), None)


def numbers(text):
    return [float(word) for word in re.split(r'[ ,]+', text.strip())]


def color(element, name, default):
    """A constant colour; None if it is a texture."""
    found = find(element, name)
    if found is None:
        return [default] * 3
    if found.get('value') is None:
        return None
    values = numbers(found.get('value'))
    return values * 3 if len(values) == 1 else values


def number(element, name, default):
    found = find(element, name)
    return default if found is None else float(found.get('value'))


def text(element, name, default=None):
    found = find(element, name)
    return default if found is None else found.get('value')


def add(parent, tag, **attributes):
    return ET.SubElement(parent, tag, {key: str(value) for key, value in attributes.items()})


def clear(element, kind):
    """Makes an element one of another type, without children; its id and name stay."""
    for child in list(element):
        element.remove(child)
    element.set('type', kind)


def load(path):
    """The tree, with defaults filled in and the paths of files absolute."""
    root = ET.parse(path).getroot()
    defaults = {e.get('name'): e.get('value') for e in root.findall('default')}
    for element in root.findall('default'):
        root.remove(element)
    folder = os.path.dirname(os.path.abspath(path))
    for element in root.iter():
        for key, value in element.attrib.items():
            if value.startswith('$'):
                element.set(key, defaults.get(value[1:], value))
        if element.tag == 'string' and element.get('name') == 'filename':
            element.set('value', os.path.join(folder, element.get('value')))
    return root


def write(root, path):
    root = copy.deepcopy(root)
    ET.indent(root)
    ET.ElementTree(root).write(path, encoding='utf-8', xml_declaration=True)


def leaf(bsdf):
    """The BSDF inside all wrappers."""
    while bsdf.get('type') in WRAPPERS:
        inner = bsdf.find('bsdf')
        if inner is None:
            break
        bsdf = inner
    return bsdf


def has(bsdf, kinds):
    return any(each.get('type') in kinds for each in bsdf.iter('bsdf'))


def is_glass(bsdf):
    return has(bsdf, GLASS)


def material_of(shape):
    """The id of a shape's BSDF."""
    ref = shape.find('ref')
    return None if ref is None else ref.get('id')


def id_within(bsdf):
    """The id of a BSDF or of the one that it wraps."""
    return next((each.get('id') for each in bsdf.iter('bsdf') if each.get('id')), None)


def name_groups(root):
    """Gives every shape a BSDF of the scene by its id, which names its group: `lampN` for the Nth shape that
    emits, and the shape's own id where the BSDF has none. An id inside wrappers moves to the outermost."""
    for bsdf in root.findall('bsdf'):
        if bsdf.get('id') is None:
            name = id_within(bsdf)
            for inner in bsdf.iter('bsdf'):
                inner.attrib.pop('id', None)
            if name is not None:
                bsdf.set('id', name)
    shared = {bsdf.get('id'): bsdf for bsdf in root.findall('bsdf')}
    lamps = 0
    for count, shape in enumerate(root.findall('shape')):
        own, emits = shape.find('bsdf'), shape.find('emitter') is not None
        if own is None and not emits and material_of(shape) is not None:
            continue
        if own is not None:
            shape.remove(own)
        elif material_of(shape) in shared:
            own = copy.deepcopy(shared[material_of(shape)])
        else:
            own = ET.Element('bsdf', type='diffuse')
        for ref in shape.findall('ref'):
            shape.remove(ref)
        name = f'lamp{lamps}' if emits else own.get('id') or shape.get('id') or f'shape{count}'
        lamps += emits
        own.set('id', name)
        # Mitsuba wants all ids of a file to differ.
        shape.set('id', f'{name}-shape')
        if name not in shared:
            shared[name] = own
            root.insert(0, own)
        add(shape, 'ref', id=name)
    used = {material_of(shape) for shape in root.findall('shape')}
    for bsdf in root.findall('bsdf'):
        if bsdf.get('id') not in used:
            root.remove(bsdf)


def is_lamp(name):
    return re.fullmatch(r'lamp\d+', name) is not None


def without_glass(root):
    root = copy.deepcopy(root)
    glass = {bsdf.get('id') for bsdf in root.findall('bsdf') if is_glass(bsdf)}
    for shape in root.findall('shape'):
        if material_of(shape) in glass:
            root.remove(shape)
    for bsdf in root.findall('bsdf'):
        if bsdf.get('id') in glass:
            root.remove(bsdf)
    return root
