"""Writes what Mitsuba 3.9.1 renders of a room and what unrender is given: ROOMS.json ROOM FOLDER OUT.

truth.xml        the artist's scene in Mitsuba 3's plugins, with the camera of the photograph and that of the new view
albedo.xml       the same with each material as a diffuse one of its base colour, for the maps of the truth
given.xml        without any material but glass: what is recovered is grey
*_new_light.xml  truth and given in the new light
published.xml, published_given.xml (and ..._new_light.xml)
                 as truth.xml and given.xml with all that unrender reads by itself left as published
groups.json      the groups, their true materials but for textures, and what was changed or is absent
"""

import copy
import json
import os
import sys

import engine
import materials
import scene_file as sf

GREY = '0.5, 0.5, 0.5'


def set_film(sensor, size):
    for child in list(sensor):
        if child.tag in ('film', 'sampler'):
            sensor.remove(child)
    film = sf.add(sensor, 'film', type='hdrfilm')
    for name, value in zip(('width', 'height'), size):
        sf.add(film, 'integer', name=name, value=value)
    sf.add(film, 'string', name='pixel_format', value='rgb')
    sf.add(film, 'string', name='component_format', value='float32')
    sf.add(film, 'rfilter', type='box')


def set_cameras(root, room, folder):
    """Names the camera of the photograph and adds that of the new view."""
    photo = root.find('sensor')
    photo.set('id', 'photo')
    # A thin lens or a shutter time is not what is tested.
    set_film(photo, room['size'])
    view = room['new_view']
    if 'file' in view:
        # The camera of another file of the same room.
        sensor = sf.load(os.path.join(folder, view['file'])).find('sensor')
        sensor.set('id', 'new-view')
        root.append(sensor)
    else:
        sensor = sf.add(root, 'sensor', type='perspective', id='new-view')
        sf.add(sensor, 'float', name='fov', value=view['fov'])
        place = sf.add(sensor, 'transform', name='to_world')
        point = lambda key: ', '.join(str(x) for x in view.get(key, [0, 1, 0]))
        sf.add(place, 'lookat', origin=point('origin'), target=point('target'), up=point('up'))
    set_film(sensor, room['size'])


def drop_absent(root, log):
    """Leaves out shapes whose mesh a snapshot lacks, and textures."""
    absent = lambda element: not os.path.exists(sf.text(element, 'filename', '.'))
    for shape in root.findall('shape'):
        if absent(shape):
            log.append(f"mesh {os.path.basename(sf.text(shape, 'filename'))} is absent: "
                       f"its shape of {sf.material_of(shape)} is left out")
            root.remove(shape)
    for bsdf in root.findall('bsdf'):
        for texture in list(bsdf.iter('texture')):
            if absent(texture):
                log.append(f"texture {os.path.basename(sf.text(texture, 'filename'))} is absent: "
                           f"{sf.id_within(bsdf)} is grey there")
                name = texture.get('name')
                texture.clear()
                texture.tag = 'rgb'
                texture.attrib.update(name=name, value=GREY)


def in_new_light(root, light):
    """Moves lamps, multiplies their radiance, or turns the surroundings about +y."""
    root = copy.deepcopy(root)
    for shape in root.findall('shape'):
        lamp = sf.material_of(shape)
        if lamp in light.get('scale', {}):
            radiance = sf.find(shape.find('emitter'), 'radiance')
            values = [v * light['scale'][lamp] for v in sf.numbers(radiance.get('value'))]
            radiance.tag = 'rgb'
            radiance.set('value', ', '.join(str(v) for v in (values * 3)[:3]))
        if lamp in light.get('move', {}):
            by = dict(zip('xyz', light['move'][lamp]))
            place = sf.find(shape, 'to_world')
            sf.add(sf.add(shape, 'transform', name='to_world') if place is None else place, 'translate', **by)
    if 'turn' in light:
        emitter = root.find('emitter')
        place = sf.find(emitter, 'to_world')
        place = sf.add(emitter, 'transform', name='to_world') if place is None else place
        sf.add(place, 'rotate', x=0, y=1, z=0, angle=light['turn'])
    return root


def without_materials(root):
    """Every BSDF that is to be found becomes grey; glass and lamps stay."""
    root = copy.deepcopy(root)
    for bsdf in root.findall('bsdf'):
        if sf.is_lamp(bsdf.get('id')) or sf.is_glass(bsdf):
            continue
        sf.clear(bsdf, 'twosided')
        inner = sf.add(bsdf, 'bsdf', type='diffuse')
        sf.add(inner, 'rgb', name='reflectance', value=GREY)
    return root


def prepare(room, folder, out):
    path = os.path.join(folder, room['file'])
    log = []
    published = sf.load(path)
    for element in published.findall('integrator'):
        published.remove(element)
    drop_absent(published, log)
    sf.name_groups(published)
    set_cameras(published, room, folder)
    truth = copy.deepcopy(published)
    materials.for_mitsuba_3(truth, log)
    scenes = {
        'truth': truth,
        'given': without_materials(truth),
        'published': published,
        'published_given': without_materials(published),
    }
    for name, scene in scenes.items():
        sf.write(scene, os.path.join(out, f'{name}.xml'))
        sf.write(in_new_light(scene, room['new_light']), os.path.join(out, f'{name}_new_light.xml'))
    sf.write(materials.as_albedo(truth), os.path.join(out, 'albedo.xml'))
    groups = {bsdf.get('id'): materials.truth(bsdf) for bsdf in truth.findall('bsdf')}
    with open(os.path.join(out, 'groups.json'), 'w') as file:
        json.dump({'groups': groups, 'changes': log}, file, indent=1)
    return log


def main():
    engine.start('scalar_rgb')
    rooms, name, folder, out = sys.argv[1:5]
    with open(rooms) as file:
        room = json.load(file)['rooms'][name]
    os.makedirs(out, exist_ok=True)
    for line in prepare(room, folder, out):
        print(f'{name}: {line}')


if __name__ == '__main__':
    main()
