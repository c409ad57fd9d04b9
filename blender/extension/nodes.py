# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes node trees: recovered parameters as a material of Cycles.

The diffuse part is a Principled BSDF without specular reflection. The specular part is a Glossy BSDF
added to it, since Principled reflects more towards grazing angles and the recovered lobe does not.
"""

import json
import math
import os

import bpy

from .shaders import PARAMETERS, degrees_as_turns


def build(material, entry, group, folder, has_uvs):
    """Gives ``material`` the nodes of a group.

    Args:
        entry: The group as ``unrender export --to blender`` writes it, with the lobe of Cycles.
        group: The group's parameters, kept with the material.
        folder: The folder of the entry's texture.
        has_uvs: Whether the surfaces have texture coordinates; then angles count from u.
    """
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    closures = []
    if max(entry["rho_d"]) > 0.0 or entry["texture"]:
        closures.append(matte(nodes, links, entry, folder))
    if max(entry["rho_s"]) > 0.0:
        closures.append(shiny(nodes, links, entry, group, has_uvs))
    if max(entry["emission"]) > 0.0:
        closures.append(shining(nodes, links, entry["emission"]))
    output = nodes.new("ShaderNodeOutputMaterial")
    total = None
    for closure in closures:
        total = closure.outputs[0] if total is None else added(nodes, links, total, closure)
    if total is not None:
        links.new(total, output.inputs["Surface"])
    arrange(output, 0, 0, set())
    material.diffuse_color = (*(min(1.0, d + s) for d, s in zip(entry["rho_d"], entry["rho_s"])), 1.0)
    material[PARAMETERS] = json.dumps(group)


def matte(nodes, links, entry, folder):
    """The diffuse part, with its texture packed into the file."""
    node = nodes.new("ShaderNodeBsdfPrincipled")
    node.inputs["Base Color"].default_value = (*entry["rho_d"], 1.0)
    node.inputs["Roughness"].default_value = 1.0
    node.inputs["Specular IOR Level"].default_value = 0.0
    if entry["texture"]:
        picture = nodes.new("ShaderNodeTexImage")
        picture.image = bpy.data.images.load(os.path.join(folder, entry["texture"]["file"]))
        picture.image.colorspace_settings.name = "Non-Color"
        picture.image.pack()
        picture.extension = "EXTEND" if entry["texture"]["clamps"] else "REPEAT"
        links.new(picture.outputs["Color"], node.inputs["Base Color"])
    return node


def shiny(nodes, links, entry, group, has_uvs):
    """The specular part: microfacets with the same reflectance at all angles."""
    node = nodes.new("ShaderNodeBsdfAnisotropic")
    node.distribution = entry["microfacets"]
    node.inputs["Color"].default_value = (*entry["rho_s"], 1.0)
    node.inputs["Roughness"].default_value = math.sqrt(entry["alpha"])
    node.inputs["Anisotropy"].default_value = entry["anisotropy"]
    if entry["anisotropy"] > 0.0:
        tangent = nodes.new("ShaderNodeTangent") if has_uvs else world_x(nodes)
        if has_uvs:
            tangent.direction_type = "UV_MAP"
        links.new(tangent.outputs[0], node.inputs["Tangent"])
        # Cycles has the smoother direction along the tangent.
        across = 90.0 if group["alpha_x"] > group["alpha_y"] else 0.0
        node.inputs["Rotation"].default_value = degrees_as_turns(group["theta_deg"] + across)
    return node


def world_x(nodes):
    """The direction from which angles count on surfaces without texture coordinates."""
    node = nodes.new("ShaderNodeCombineXYZ")
    node.inputs["X"].default_value = 1.0
    return node


def shining(nodes, links, radiance):
    """Emission, from the front only."""
    strength = max(radiance)
    node = nodes.new("ShaderNodeEmission")
    node.inputs["Color"].default_value = (*(c / strength for c in radiance), 1.0)
    front = nodes.new("ShaderNodeMath")
    front.operation = "MULTIPLY_ADD"
    front.inputs[1].default_value = -strength
    front.inputs[2].default_value = strength
    links.new(nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], front.inputs[0])
    links.new(front.outputs[0], node.inputs["Strength"])
    return node


def added(nodes, links, total, closure):
    """The sum of two closures."""
    node = nodes.new("ShaderNodeAddShader")
    links.new(total, node.inputs[0])
    links.new(closure.outputs[0], node.inputs[1])
    return node.outputs[0]


def arrange(node, column, row, seen):
    """Places every node to the left of the one to which it leads; returns the next free row."""
    if node.name in seen:
        return row
    seen.add(node.name)
    node.location = (-260.0 * column, -240.0 * row)
    sources = [link.from_node for socket in node.inputs for link in socket.links]
    for source in sources:
        row = arrange(source, column + 1, row, seen)
    return row if sources else row + 1
