# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads node trees: a material of Blender in the parameters of unrender.

The tree behind the output is a sum of diffuse, glossy and emitting closures with constant weights; any
other is approximated by such a sum, with a warning. Roughness r is alpha = r^2, an anisotropy a is
alpha_x = alpha (1 - a), alpha_y = alpha / (1 - a). [Blender manual, Principled BSDF and Glossy BSDF]
"""

import json
import math
from dataclasses import dataclass, field

import numpy as np
import unrender

PARAMETERS = "unrender_parameters"
"""The property of materials that were made from recovered parameters, which are in it as JSON."""

DIELECTRIC = 0.08
"""Reflectance of a dielectric at normal incidence for a *Specular IOR Level* of one; a level of 0.5
gives 0.04, as glass. [Blender manual, Principled BSDF]"""


@dataclass
class Sum:
    """A sum of closures: reflectances, roughness weighted by the reflectance, radiance."""

    rho_d: np.ndarray = field(default_factory=lambda: np.zeros(3))
    rho_s: np.ndarray = field(default_factory=lambda: np.zeros(3))
    alpha_x: float = 0.0
    alpha_y: float = 0.0
    emission: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def add(self, other, weight=1.0):
        """Adds ``weight`` of another sum."""
        before, more = self.rho_s.mean(), weight * other.rho_s.mean()
        if before + more > 0.0:
            self.alpha_x = (before * self.alpha_x + more * other.alpha_x) / (before + more)
            self.alpha_y = (before * self.alpha_y + more * other.alpha_y) / (before + more)
        self.rho_d = self.rho_d + weight * other.rho_d
        self.rho_s = self.rho_s + weight * other.rho_s
        self.emission = self.emission + weight * other.emission
        return self


def group_of(material, doubts):
    """The group of a material, from its nodes."""
    if material is None:
        return unrender.Group()
    kept = material.get(PARAMETERS)
    if kept:
        return unrender.Group(**json.loads(kept))
    if not material.use_nodes or material.node_tree is None:
        return unrender.Group(rho_d=tuple(material.diffuse_color[:3]))
    output = material.node_tree.get_output_node("CYCLES")
    link = next(iter(output.inputs["Surface"].links), None) if output else None
    found = Sum() if link is None else closure(link.from_node, material.name, doubts)
    top = float(np.max(found.rho_d + found.rho_s))
    scale = 1.0 / top if top > 1.0 else 1.0
    return unrender.Group(
        rho_d=tuple(found.rho_d * scale),
        rho_s=tuple(found.rho_s * scale),
        alpha_x=found.alpha_x,
        alpha_y=found.alpha_y,
        emission=tuple(found.emission),
    )


def closure(node, name, doubts):
    """The sum of closures that ends in ``node``."""
    reader = READERS.get(node.type)
    if reader is not None:
        return reader(node, name, doubts)
    doubts.append(f'material "{name}": the node "{node.name}" cannot be converted and is taken as grey')
    return Sum(rho_d=np.full(3, 0.5))


def constant(node, socket, name, doubts):
    """The value of an input; a link is replaced by the input's own value, with a warning."""
    found = node.inputs[socket]
    value = found.default_value
    if found.is_linked:
        source = found.links[0].from_node
        if source.type == "TEX_IMAGE" and source.image is not None:
            value = mean_colour(source.image)
            doubts.append(f'material "{name}": the mean colour of the texture on {socket} is taken')
        elif source.type == "RGB":
            value = source.outputs[0].default_value
        else:
            doubts.append(f'material "{name}": the link to {socket} was not read')
    return np.array(value[:3]) if hasattr(value, "__len__") else float(value)


def mean_colour(image):
    """The mean of a picture, linear; Blender gives the values of integer files as they are coded."""
    width, height = image.size
    if width * height == 0:
        return (0.5, 0.5, 0.5)
    values = np.empty(width * height * image.channels, dtype=np.float32)
    image.pixels.foreach_get(values)
    values = values.reshape(-1, image.channels)[:, :3]
    if image.colorspace_settings.name == "sRGB" and not image.is_float:
        values = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    return tuple(float(x) for x in values.mean(axis=0))


def lobe(roughness, anisotropy=0.0):
    """alpha_x and alpha_y."""
    alpha, ratio = roughness**2, max(1.0 - abs(anisotropy), 1e-2)
    return (alpha * ratio, alpha / ratio) if anisotropy >= 0.0 else (alpha / ratio, alpha * ratio)


def principled(node, name, doubts):
    """Principled BSDF: diffuse, a lobe of the dielectric or the metal, emission."""
    base = constant(node, "Base Color", name, doubts)
    metallic = constant(node, "Metallic", name, doubts)
    level = constant(node, "Specular IOR Level", name, doubts)
    alpha = constant(node, "Roughness", name, doubts) ** 2
    strength = constant(node, "Emission Strength", name, doubts)
    light = constant(node, "Emission Color", name, doubts) * strength if strength > 0.0 else np.zeros(3)
    shine = metallic * base + (1.0 - metallic) * DIELECTRIC * level
    return Sum((1.0 - metallic) * base, shine, alpha, alpha, light)


def diffuse(node, name, doubts):
    """Diffuse BSDF."""
    return Sum(rho_d=constant(node, "Color", name, doubts))


def glossy(node, name, doubts):
    """Glossy BSDF, with or without an anisotropy."""
    color = constant(node, "Color", name, doubts)
    anisotropy = constant(node, "Anisotropy", name, doubts) if "Anisotropy" in node.inputs else 0.0
    alpha_x, alpha_y = lobe(constant(node, "Roughness", name, doubts), anisotropy)
    return Sum(rho_s=color, alpha_x=alpha_x, alpha_y=alpha_y)


def emission(node, name, doubts):
    """Emission."""
    color = constant(node, "Color", name, doubts)
    return Sum(emission=color * constant(node, "Strength", name, doubts))


def add(node, name, doubts):
    """Add Shader."""
    made = Sum()
    for socket in node.inputs:
        for link in socket.links:
            made.add(closure(link.from_node, name, doubts))
    return made


def mix(node, name, doubts):
    """Mix Shader."""
    share = constant(node, 0, name, doubts)
    made = Sum()
    for socket, weight in ((node.inputs[1], 1.0 - share), (node.inputs[2], share)):
        for link in socket.links:
            made.add(closure(link.from_node, name, doubts), weight)
    return made


READERS = {
    "BSDF_PRINCIPLED": principled,
    "BSDF_DIFFUSE": diffuse,
    "BSDF_GLOSSY": glossy,
    "BSDF_ANISOTROPIC": glossy,
    "EMISSION": emission,
    "ADD_SHADER": add,
    "MIX_SHADER": mix,
}


def known(group):
    """The ``known`` table of a group in a project."""
    made = {"rho_d": list(group.rho_d), "rho_s": list(group.rho_s)}
    if max(group.rho_s) > 0.0:
        # With alpha 0 in both directions this is a mirror.
        made.update(alpha_x=group.alpha_x, alpha_y=group.alpha_y, theta_deg=group.theta_deg)
    return made


def brightness(emission):
    """The brightest channel of an emission."""
    return max(0.0, *map(float, emission))


def degrees_as_turns(degrees):
    """Angles in the unit of Glossy BSDF: whole turns."""
    return math.remainder(degrees, 360.0) / 360.0 % 1.0
