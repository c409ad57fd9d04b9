"""The truth of a room, in a folder that other programs can read: version 2.

truth.json      "version", "room", "size" [width, height], "exposure" (the radiance of white in photo.png), and
                "groups", a list; its order is that of the numbers in group.exr. Each has "name", "kind" (the BSDF of
                Mitsuba), "textured", "bumps", "pixels" (those that are scored) and "left_out", why it is not scored
photo.exr       the photograph, linear radiance;  photo.png: 8 bits, sRGB
new_view.exr    the same room from another place;  new_light.exr: from the same place in other light
group.exr       the number of the group that fills the pixel
scored.exr      1 where the pixel is scored: one group fills it, no glass is in front, no lamp, no cut-out
scored_new_view.exr, group_new_view.exr    the same for the new view; unlike scored.exr, also pixels of several groups
albedo.exr      the reflectance at normal incidence: of a diffuse surface, of a metal, or of the diffuse surface that
                is as bright there as the plastic's base; mean over the pixel
roughness.exr   sqrt(alpha); 1 without a lobe, 0 for a mirror or smooth plastic
uv.exr          texture coordinates at 4 x 4 points of each pixel: 16 pictures, one above the other
mask.png        white where a photograph may be used: no glass
"""

import json
import os

import numpy as np

import pictures

VERSION = 2
POINTS = 16


class Truth:
    """A folder as above, read."""

    def __init__(self, folder):
        self.folder = str(folder)
        with open(os.path.join(self.folder, 'truth.json')) as file:
            self.about = json.load(file)
        if self.about['version'] != VERSION:
            raise ValueError(f"{folder}: truth of version {self.about['version']}; this program reads {VERSION}")
        self.names = [group['name'] for group in self.about['groups']]
        self.group = self.groups_of('photo')
        self.scored = self.picture('scored')[..., 0] > 0.5

    def picture(self, name):
        return pictures.read(os.path.join(self.folder, f'{name}.exr'))

    def groups_of(self, shot):
        """The number of the group in each pixel of a picture."""
        seen = self.picture('group_new_view' if shot == 'new_view' else 'group')
        return np.rint(seen[..., 0]).astype(int)

    def pixels_of(self, name):
        return self.group == self.names.index(name)

    def uv(self):
        """(height, width, point, 2)"""
        width, height = self.about['size']
        return self.picture('uv').reshape(POINTS, height, width, 3)[..., :2].transpose(1, 2, 0, 3)
