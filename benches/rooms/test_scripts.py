"""Tests of the scripts that need no photograph: python -m unittest discover -s benches/rooms -p 'test_*.py'."""

import json
import os
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ET

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import brightness
import estimate
import materials
import numpy as np
import pictures
import prepare
import scene_file as sf
import score
from truth import POINTS, VERSION, Truth

SCENE = '''<scene version="0.6.0">
    <default name="grey" value="0.25"/>
    <integrator type="path"/>
    <sensor type="perspective"><float name="fov" value="40"/><film type="hdrfilm"/></sensor>
    <bsdf type="bumpmap"><texture name="map" type="bitmap"><string name="filename" value="bump.png"/></texture>
        <bsdf type="twosided" id="Steel"><bsdf type="roughconductor"><float name="alpha" value="0.04"/>
        <rgb name="eta" value="2, 2, 2"/><rgb name="k" value="0, 0, 0"/></bsdf></bsdf></bsdf>
    <bsdf type="dielectric" id="Glass"/>
    <bsdf type="roughplastic" id="Paint"><float name="alpha" value="0.09"/><float name="intIOR" value="1.5"/>
        <boolean name="nonlinear" value="true"/><spectrum name="diffuseReflectance" value="0.1, 0.2, 0.3"/></bsdf>
    <bsdf type="diffuse" id="Unused"/>
    <shape type="cube"><ref id="Steel"/></shape>
    <shape type="cube"><ref id="Glass"/></shape>
    <shape type="cube"><ref id="Paint"/></shape>
    <shape type="obj"><string name="filename" value="gone.obj"/><ref id="Paint"/></shape>
    <shape type="cube" id="Plinth"><bsdf type="diffuse"><rgb name="reflectance" value="$grey"/></bsdf></shape>
    <shape type="rectangle"><ref id="Paint"/>
        <emitter type="area"><rgb name="radiance" value="2, 2, 2"/></emitter></shape>
</scene>'''
ROOM = {'file': 'scene.xml', 'size': [8, 4], 'new_view': {'origin': [0, 0, 1], 'target': [0, 0, 0], 'fov': 40},
        'new_light': {'scale': {'lamp0': 3}, 'move': {'lamp0': [0, 1, 0]}}}


def plastic(alpha, nonlinear=True):
    return {'alpha': alpha, 'distribution': 'ggx', 'int_ior': 1.5, 'ext_ior': 1.0, 'nonlinear': nonlinear}


class Brightness(unittest.TestCase):
    def test_a_smooth_plastic_has_the_closed_form(self):
        # Of n = 1.5: F0 = 0.04; 0.5963 of the light from below is reflected [d'Eon and Irving 2011's fit: 0.5966].
        for base in (0.05, 0.5, 1.0):
            closed = 0.96 ** 2 / 1.5 ** 2 * base / (1 - 0.5963 * base)
            self.assertAlmostEqual(brightness.seen(base, plastic(0)), closed, delta=2e-3 * closed)

    def test_white_rough_plastics_are_darker(self):
        for alpha, white in ((0.05, 0.966), (0.1, 0.913), (0.15, 0.853), (0.2, 0.793)):
            self.assertAlmostEqual(brightness.seen(1.0, plastic(alpha)), white, delta=2e-3)

    def test_it_is_what_the_plugin_reflects(self):
        for about in (plastic(0.1), plastic(0.2, False), plastic(0, False)):
            self.assertAlmostEqual(brightness.seen(0.37, about), brightness.response(about, 0.37), delta=2e-4)


class Scenes(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        with open(os.path.join(self.folder.name, 'scene.xml'), 'w') as file:
            file.write(SCENE)
        prepare.prepare(ROOM, self.folder.name, self.folder.name)

    def read(self, name):
        return ET.parse(os.path.join(self.folder.name, name)).getroot()

    def groups(self):
        with open(os.path.join(self.folder.name, 'groups.json')) as file:
            return json.load(file)

    def test_every_shape_names_its_group(self):
        root = self.read('truth.xml')
        names = [sf.material_of(shape) for shape in root.findall('shape')]
        self.assertEqual(names, ['Steel', 'Glass', 'Paint', 'Plinth', 'lamp0'])
        self.assertEqual({bsdf.get('id') for bsdf in root.findall('bsdf')}, set(names))

    def test_what_is_absent_is_said(self):
        changes = '\n'.join(self.groups()['changes'])
        self.assertIn('gone.obj', changes)
        self.assertIn('bump.png', changes)

    def test_true_materials(self):
        groups = self.groups()['groups']
        self.assertAlmostEqual(groups['Steel']['roughness'], 0.2)
        self.assertAlmostEqual(groups['Steel']['metal'][0], 1 / 9)
        self.assertTrue(groups['Steel']['bumps'])
        self.assertAlmostEqual(groups['Paint']['roughness'], 0.3)
        self.assertTrue(groups['Paint']['plastic']['nonlinear'])
        self.assertEqual([groups[name]['left_out'] for name in ('Glass', 'lamp0', 'Plinth')], ['glass', 'lamp', None])

    def test_nothing_of_the_truth_is_given(self):
        root = self.read('given.xml')
        self.assertIn('Glass', {sf.material_of(shape) for shape in root.findall('shape')})
        for bsdf in root.findall('bsdf'):
            if not sf.is_lamp(bsdf.get('id')) and not sf.is_glass(bsdf):
                self.assertEqual(sf.color(sf.leaf(bsdf), 'reflectance', None), [0.5] * 3)
        published = self.read('published_given.xml')
        self.assertIn('Glass', {sf.material_of(shape) for shape in published.findall('shape')})

    def test_the_new_light_differs_in_the_lamp_alone(self):
        lamp = lambda name: self.read(name).findall('shape')[-1]
        before, after = lamp('truth.xml'), lamp('truth_new_light.xml')
        radiance = lambda shape: sf.numbers(sf.find(shape.find('emitter'), 'radiance').get('value'))
        self.assertEqual((radiance(before), radiance(after)), ([2, 2, 2], [6, 6, 6]))
        self.assertEqual(sf.find(after, 'to_world').find('translate').get('y'), '1')

    def test_albedo_is_the_base_colour(self):
        bases = {bsdf.get('id'): sf.color(sf.leaf(bsdf), 'reflectance', None)
                 for bsdf in self.read('albedo.xml').findall('bsdf')}
        self.assertEqual(bases['Paint'], [0.1, 0.2, 0.3])
        self.assertEqual(bases['Plinth'], [0.25] * 3)
        self.assertEqual(bases['Steel'], [0.0] * 3)

    def test_what_mitsuba_3_lacks_becomes_its_nearest_form(self):
        log, bsdf = [], ET.fromstring('<bsdf type="phong" id="a"><float name="exponent" value="30"/></bsdf>')
        materials.nearest(bsdf, 'a', log)
        self.assertEqual((bsdf.get('type'), len(log)), ('roughplastic', 1))
        self.assertAlmostEqual(sf.number(bsdf, 'alpha', None), 0.25)


class Estimates(unittest.TestCase):
    def test_texels_are_bilinear_and_repeat(self):
        texture = np.array([[0.0, 1.0], [2.0, 3.0]])[..., None]
        at = lambda u, v: estimate.texels(texture, np.array([u, v]))[0]
        self.assertAlmostEqual(at(0.25, 0.25), 0)
        self.assertAlmostEqual(at(0.5, 0.25), 0.5)
        self.assertAlmostEqual(at(0.5, 0.5), 1.5)
        self.assertAlmostEqual(at(1.75, -0.25), 3)

    def test_a_lobe_counts_by_its_form(self):
        group = {'rho_s': [0.54] * 3}
        self.assertAlmostEqual(estimate.lobe_albedo(group)[0], 0.5)
        self.assertAlmostEqual(estimate.lobe_albedo({**group, 'reflectance': 'metal'})[0], 0.54)
        self.assertEqual(estimate.lobe_albedo({'rho_s': [0.2] * 3, 'reflectance': 'dielectric'})[0], 0)
        self.assertEqual(estimate.lobe_albedo({'rho_s': [0.06] * 3})[0], 0)

    def test_albedo_as_seen_scales_the_base(self):
        group = {'rho_d': [0.8, 0.4, 0.0], 'albedo_d': [0.4, 0.3, 0.0]}
        self.assertTrue(np.allclose(group['rho_d'] * estimate.scale_to_seen(group), group['albedo_d']))
        self.assertTrue(np.allclose(estimate.scale_to_seen({'rho_d': [0.8] * 3}), 1))

    def test_roughness_is_burleys(self):
        self.assertEqual(estimate.roughness({'rho_s': [0.0] * 3}), 1)
        self.assertEqual(estimate.roughness({'rho_s': [0.5] * 3, 'alpha_x': 0.0, 'alpha_y': 0.0}), 0)
        self.assertAlmostEqual(estimate.roughness({'rho_s': [0.5] * 3, 'alpha_x': 0.16, 'alpha_y': 0.01}), 0.2)


class Scores(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        write = lambda name, values: pictures.write(os.path.join(folder.name, f'{name}.exr'), values)
        group = np.repeat([[1, 2]], 4, axis=0).repeat(4, axis=1)
        write('group', group)
        write('scored', np.ones(group.shape))
        write('albedo', np.where(group == 1, 0.5, 0.3)[..., None].repeat(3, 2))
        write('roughness', np.where(group == 1, 1.0, 0.4))
        write('uv', np.zeros((POINTS * 4, 8, 3)))
        write('new_light', np.full((4, 8, 3), 2.0))
        groups = [{'name': name, 'kind': 'diffuse', 'textured': False} for name in ('', 'a', 'b')]
        self.about = {'version': VERSION, 'room': 'test', 'size': [8, 4], 'exposure': 1.0, 'groups': groups}
        self.write_about(folder.name)
        self.truth = Truth(folder.name)

    def write_about(self, folder):
        with open(os.path.join(folder, 'truth.json'), 'w') as file:
            json.dump(self.about, file)

    def score(self, a, b, statuses):
        inside = self.truth.group == 1
        albedo = np.where(inside, a, b)[..., None].repeat(3, 2)
        return score.materials(self.truth, albedo, np.ones(inside.shape), statuses)

    def test_the_truth_has_no_error(self):
        found = self.score(0.5, 0.3, {})
        self.assertGreater(found['albedo_db'], 100)
        self.assertEqual((found['groups'], found['wrong']), (2, 0))
        self.assertAlmostEqual(found['roughness_db'], -10 * np.log10(0.36 / 2), places=3)

    def test_nothing_is_rescaled_and_silence_counts(self):
        found = self.score(0.6, 0.6, {'a': {'status': 'recovered'}, 'b': {'status': 'doubtful'}})
        self.assertAlmostEqual(found['albedo_db'], -10 * np.log10((0.01 + 0.09) / 2), places=3)
        self.assertAlmostEqual(found['silent_share'], 0.1, places=5)
        self.assertEqual([found[key] for key in ('wrong', 'wrong_and_told', 'right_and_told')], [2, 1, 0])

    def test_what_was_given_is_not_scored(self):
        found = self.score(0.9, 0.3, {'a': {'status': 'known'}})
        self.assertEqual((found['groups'], found['pixels']), (1, 16))
        self.assertGreater(found['albedo_db'], 100)

    def test_a_picture_is_compared_at_its_own_exposure(self):
        same = score.picture(self.truth, 'new_light', os.path.join(self.truth.folder, 'new_light.exr'))
        self.assertGreater(same['psnr'], 100)
        self.assertAlmostEqual(same['mean'], 1)
        dark = os.path.join(self.truth.folder, 'dark.exr')
        pictures.write(dark, np.full((4, 8, 3), 1.8))
        self.assertAlmostEqual(score.picture(self.truth, 'new_light', dark)['median'], 0.1, places=5)

    def test_a_rendering_is_compared_by_the_groups_of_its_own_view(self):
        path = lambda name: os.path.join(self.truth.folder, f'{name}.exr')
        pictures.write(path('new_view'), np.full((4, 8, 3), 2.0))
        pictures.write(path('ours'), np.full((4, 8, 3), 1.8))
        pictures.write(path('group_new_view'), np.full((4, 8), 2))
        pictures.write(path('scored_new_view'), np.ones((4, 8)))
        found = score.forward(self.truth, 'new_view', path('ours'))
        self.assertEqual([(row['group'], row['pixels']) for row in found['rows']], [('b', 32)])
        self.assertAlmostEqual(found['mean'], 0.9, places=5)

    def test_another_version_is_refused(self):
        self.about['version'] = VERSION + 1
        self.write_about(self.truth.folder)
        with self.assertRaises(ValueError):
            Truth(self.truth.folder)


if __name__ == '__main__':
    unittest.main()
