"""Adds the scene of scene.json to the open file, as a separate scene, and renders or saves it.

    blender --background --python scene.py -- picture.exr
    python scene.py picture.exr                  (with the package bpy)

PICTURE.exr is rendered by Cycles, SCENE.blend is saved; --spp N sets the samples per pixel. In an open
file, run it from the text editor. Existing data stays unchanged: if a name is taken, Blender adds a
number to ours, and the property "unrender_name" keeps it. An object whose name is taken by an object
with a parent gets that parent, and keeps its place.
"""

import json
import math
import os
import sys

import bpy
import numpy
from mathutils import Matrix



def folder():
    """The folder of this script; in the text editor, __file__ is the name of the text."""
    files = [__file__, *(bpy.path.abspath(text.filepath) for text in bpy.data.texts)]
    folders = [os.path.dirname(os.path.abspath(file)) for file in files if file]
    return next((f for f in folders if os.path.exists(os.path.join(f, "scene.json"))), folders[0])


HERE = folder()
# What Cycles makes of a candela of an IES file: 4 pi over the lumens of a watt of white light.
CYCLES_PER_CANDELA = 4 * math.pi / 177.83
# In Blender z points up, in unrender y.
Z_UP = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))


def z_up(vectors):
    return numpy.stack([vectors[:, 0], -vectors[:, 2], vectors[:, 1]], axis=1)


def read_ply(path):
    """Vertices as rows of x y z nx ny nz [u v], and triangles."""
    with open(os.path.join(HERE, path), "rb") as file:
        head, body = file.read().split(b"end_header\n", 1)
    count = {words[1]: int(words[2]) for words in map(bytes.split, head.splitlines())
             if words[0] == b"element"}
    columns = head.count(b"property float")
    floats = count[b"vertex"] * columns
    vertices = numpy.frombuffer(body, "<f4", floats).reshape(-1, columns)
    face = numpy.dtype([("count", "u1"), ("corners", "<i4", 3)])
    return vertices, numpy.frombuffer(body, face, count[b"face"], 4 * floats)["corners"]


def named(thing, item):
    """Keeps the name of an item, as Blender may have to add a number to it."""
    thing["unrender_name"] = item["name"]
    return thing


def add_object(scene, item, materials, glasses):
    parent = getattr(bpy.data.objects.get(item["name"]), "parent", None)
    vertices, triangles = read_ply(item["mesh"])
    mesh = bpy.data.meshes.new(item["name"])
    mesh.from_pydata(z_up(vertices).tolist(), [], triangles.tolist())
    if vertices.shape[1] == 8:
        corners = vertices[triangles.ravel(), 6:8].ravel()
        mesh.uv_layers.new(name="map").data.foreach_set("uv", corners)
    mesh.shade_smooth()
    mesh.normals_split_custom_set_from_vertices(z_up(vertices[:, 3:6]).tolist())
    glass = item.get("glass")
    mesh.materials.append(materials[item["group"]] if glass is None else glasses[glass])
    thing = named(bpy.data.objects.new(item["name"], mesh), item)
    scene.collection.objects.link(thing)
    if parent is not None:
        thing.parent = parent
        thing.matrix_parent_inverse = parent.matrix_world.inverted()


def matte(nodes, color):
    """The diffuse part: Lambert's."""
    node = nodes.new("ShaderNodeBsdfPrincipled")
    node.inputs["Base Color"].default_value = (*color, 1)
    node.inputs["Roughness"].default_value = 1
    node.inputs["Specular IOR Level"].default_value = 0
    return node


def picture_node(nodes, texture):
    node = nodes.new("ShaderNodeTexImage")
    node.image = bpy.data.images.load(os.path.join(HERE, texture["file"]))
    node.image.colorspace_settings.name = "Non-Color"
    node.extension = "EXTEND" if texture["clamps"] else "REPEAT"
    return node


def shiny(nodes, links, group):
    """The specular part: microfacets with the same reflectance at all angles."""
    node = nodes.new("ShaderNodeBsdfAnisotropic")
    node.distribution = group["microfacets"]
    node.inputs["Color"].default_value = (*group["rho_s"], 1)
    node.inputs["Roughness"].default_value = group["roughness"]
    node.inputs["Anisotropy"].default_value = group["anisotropy"]
    if group["anisotropy"] > 0:
        tangent = nodes.new("ShaderNodeTangent")
        tangent.direction_type = "UV_MAP"
        tangent.uv_map = "map"
        links.new(tangent.outputs["Tangent"], node.inputs["Tangent"])
    return node


def principled(nodes, group):
    """A plastic or a metal: Blender's own."""
    node = nodes.new("ShaderNodeBsdfPrincipled")
    node.inputs["Base Color"].default_value = (*group["base_color"], 1)
    node.inputs["Metallic"].default_value = float(group["metallic"])
    node.inputs["Roughness"].default_value = group["roughness"]
    if group["ior"]:
        node.inputs["IOR"].default_value = group["ior"]
    return node


def add_material(group):
    material = named(bpy.data.materials.new(group["name"]), group)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    parts = []
    is_free = group["reflectance"] == "free"
    if not is_free or max(group["rho_d"]) > 0 or group["texture"]:
        diffuse = matte(nodes, group["rho_d"]) if is_free else principled(nodes, group)
        if group["texture"]:
            picture = picture_node(nodes, group["texture"])
            links.new(picture.outputs["Color"], diffuse.inputs["Base Color"])
        parts.append(diffuse)
    if is_free and max(group["rho_s"]) > 0:
        parts.append(shiny(nodes, links, group))
    if group["normals"]:
        emboss(nodes, links, parts, group["normals"])
    if max(group["emission"]) > 0:
        strength = max(group["emission"])
        emission = nodes.new("ShaderNodeEmission")
        emission.inputs["Color"].default_value = (*(c / strength for c in group["emission"]), 1)
        # From the front only.
        front = nodes.new("ShaderNodeMath")
        front.operation = "MULTIPLY_ADD"
        front.inputs[1].default_value = -strength
        front.inputs[2].default_value = strength
        links.new(nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], front.inputs[0])
        links.new(front.outputs[0], emission.inputs["Strength"])
        parts.append(emission)
    result = nodes.new("ShaderNodeOutputMaterial")
    total = None
    for part in parts:
        shader = part.outputs[0]
        if total is not None:
            add = nodes.new("ShaderNodeAddShader")
            links.new(total, add.inputs[0])
            links.new(shader, add.inputs[1])
            shader = add.outputs[0]
        total = shader
    if group["holes"]:
        total = pierced(nodes, links, parts, total, group["holes"])
    if total is not None:
        links.new(total, result.inputs["Surface"])
    return material


def emboss(nodes, links, parts, normals):
    """Gives the shaders the normals of a picture."""
    bump = nodes.new("ShaderNodeNormalMap")
    bump.uv_map = "map"
    links.new(picture_node(nodes, normals).outputs["Color"], bump.inputs["Color"])
    for part in parts:
        links.new(bump.outputs["Normal"], part.inputs["Normal"])


def pierced(nodes, links, parts, shader, holes):
    """The shader with holes where a picture lies below its cutoff."""
    there = nodes.new("ShaderNodeMath")
    there.operation = "GREATER_THAN"
    # What lies at the cutoff is there.
    there.inputs[1].default_value = holes["cutoff"] - 1e-6
    links.new(picture_node(nodes, holes).outputs["Color"], there.inputs[0])
    if len(parts) == 1 and "Alpha" in parts[0].inputs:
        # Exporters know this as a cut-out.
        links.new(there.outputs[0], parts[0].inputs["Alpha"])
        return shader
    mix = nodes.new("ShaderNodeMixShader")
    links.new(there.outputs[0], mix.inputs["Fac"])
    links.new(nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
    if shader is not None:
        links.new(shader, mix.inputs[2])
    return mix.outputs[0]


def add_glass(glass):
    material = named(bpy.data.materials.new(glass["name"]), glass)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    result = nodes.new("ShaderNodeOutputMaterial")
    make = pane if glass["is_thin"] else body
    links.new(make(nodes, links, glass), result.inputs["Surface"])
    strongest = max(glass["absorption"])
    if strongest > 0:
        # It absorbs the density times one minus the colour.
        absorbing = nodes.new("ShaderNodeVolumeAbsorption")
        absorbing.inputs["Color"].default_value = (*(1 - a / strongest for a in glass["absorption"]), 1)
        absorbing.inputs["Density"].default_value = strongest
        links.new(absorbing.outputs[0], result.inputs["Volume"])
    return material


def body(nodes, links, glass):
    """Solid glass."""
    node = nodes.new("ShaderNodeBsdfPrincipled")
    node.inputs["Base Color"].default_value = (*glass["color"], 1)
    node.inputs["Transmission Weight"].default_value = 1
    node.inputs["Roughness"].default_value = 0
    node.inputs["IOR"].default_value = glass["ior"]
    return node.outputs[0]


def pane(nodes, links, glass):
    """Both faces of a plate in one: light goes straight on, and 2 r / (1 + r) of it is reflected."""
    def math(operation, *values):
        node = nodes.new("ShaderNodeMath")
        node.operation = operation
        for place, value in zip(node.inputs, values):
            if isinstance(value, bpy.types.NodeSocket):
                links.new(value, place)
            else:
                place.default_value = value
        return node.outputs[0]

    # Seen from the back, the Fresnel node takes one over the refractive index.
    ior, back = glass["ior"], nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"]
    fresnel = nodes.new("ShaderNodeFresnel")
    links.new(math("MULTIPLY_ADD", back, 1 / ior - ior, ior), fresnel.inputs["IOR"])
    once = fresnel.outputs[0]
    mix = nodes.new("ShaderNodeMixShader")
    both = math("DIVIDE", math("MULTIPLY", once, 2.0), math("ADD", once, 1.0))
    links.new(both, mix.inputs["Fac"])
    through = nodes.new("ShaderNodeBsdfTransparent")
    through.inputs["Color"].default_value = (*glass["color"], 1)
    mirror = nodes.new("ShaderNodeBsdfAnisotropic")
    mirror.inputs["Color"].default_value = (1, 1, 1, 1)
    mirror.inputs["Roughness"].default_value = 0
    links.new(through.outputs[0], mix.inputs[1])
    links.new(mirror.outputs[0], mix.inputs[2])
    return mix.outputs[0]


def fall_off(light, axis, cos_inner, cos_outer):
    """A fall-off by the square of a line in the cosine, as in glTF; Blender's own differs."""
    light.use_nodes = True
    nodes, links = light.node_tree.nodes, light.node_tree.links
    cosine = nodes.new("ShaderNodeVectorMath")
    cosine.operation = "DOT_PRODUCT"
    cosine.inputs[1].default_value = axis
    links.new(nodes.new("ShaderNodeNewGeometry").outputs["Incoming"], cosine.inputs[0])
    line = nodes.new("ShaderNodeMapRange")
    line.inputs["From Min"].default_value = cos_outer
    line.inputs["From Max"].default_value = cos_inner
    links.new(cosine.outputs["Value"], line.inputs["Value"])
    square = nodes.new("ShaderNodeMath")
    square.operation = "POWER"
    square.inputs[1].default_value = 2
    links.new(line.outputs["Result"], square.inputs[0])
    emission = next(n for n in nodes if n.type == "EMISSION")
    links.new(square.outputs[0], emission.inputs["Strength"])


def shine_by_profile(light, aim, upright, item):
    """The strength of a light by its IES file, one where that has its greatest candela."""
    light.use_nodes = True
    nodes, links = light.node_tree.nodes, light.node_tree.links
    # Cycles counts the horizontal angle from -y towards -x of this vector, and the vertical one from its -z.
    towards = nodes.new("ShaderNodeCombineXYZ")
    for socket, axis in zip(towards.inputs, (aim.cross(upright), -upright, -aim)):
        along = nodes.new("ShaderNodeVectorMath")
        along.operation = "DOT_PRODUCT"
        along.inputs[1].default_value = axis
        links.new(nodes.new("ShaderNodeNewGeometry").outputs["Incoming"], along.inputs[0])
        links.new(along.outputs["Value"], socket)
    profile = nodes.new("ShaderNodeTexIES")
    profile.mode = "EXTERNAL"
    profile.filepath = os.path.join(HERE, item["profile"])
    links.new(towards.outputs[0], profile.inputs["Vector"])
    share = nodes.new("ShaderNodeMath")
    share.operation = "DIVIDE"
    share.inputs[1].default_value = CYCLES_PER_CANDELA * item["candela"]
    links.new(profile.outputs[0], share.inputs[0])
    emission = next(n for n in nodes if n.type == "EMISSION")
    links.new(share.outputs[0], emission.inputs["Strength"])


def add_light(scene, item):
    kind = "SUN" if item["kind"] == "directional" else "POINT"
    light = bpy.data.lights.new(item["name"], kind)
    strength = max(item["strength"])
    light.color = [c / max(strength, 1e-30) for c in item["strength"]]
    # Watts into all directions, from watts per steradian; for suns watts per square metre.
    light.energy = strength if kind == "SUN" else 4 * math.pi * strength
    thing = named(bpy.data.objects.new(item["name"], light), item)
    scene.collection.objects.link(thing)
    if kind == "SUN":
        light.angle = 0
    else:
        light.shadow_soft_size = 0
        thing.location = Z_UP @ Matrix.Translation(item["position"]).to_translation()
    if "direction" in item:
        axis = Z_UP.to_3x3() @ Matrix.Translation(item["direction"]).to_translation()
        if kind == "SUN":
            thing.rotation_euler = axis.to_track_quat("-Z", "Y").to_euler()
        elif item["kind"] == "profiled":
            upright = Z_UP.to_3x3() @ Matrix.Translation(item["upright"]).to_translation()
            shine_by_profile(light, axis, upright, item)
        else:
            fall_off(light, axis, item["cos_inner"], item["cos_outer"])


def add_camera(scene, item):
    camera = bpy.data.cameras.new(item["name"])
    camera.sensor_fit = "VERTICAL"
    camera.angle_y = item["fov_y"]
    # If the axis is right of the middle, the frame is shifted to the left, in heights of it.
    camera.shift_x, camera.shift_y = -item["principal_point"][0], item["principal_point"][1]
    camera.clip_start, camera.clip_end = item["near"], 1e5
    thing = named(bpy.data.objects.new(item["name"], camera), item)
    thing.matrix_world = Z_UP @ Matrix(item["world_from_camera"])
    scene.collection.objects.link(thing)
    return thing


def add_world(item):
    """The light from all around: one radiance, a panorama, or none."""
    world = bpy.data.worlds.new("unrender" if item else "unrender, dark")
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    background = nodes["Background"]
    background.inputs["Strength"].default_value = 1 if item else 0
    if item and "radiance" in item:
        background.inputs["Color"].default_value = (*item["radiance"], 1)
    if item and "panorama" in item:
        picture = nodes.new("ShaderNodeTexEnvironment")
        picture.image = bpy.data.images.load(os.path.join(HERE, item["panorama"]))
        picture.image.colorspace_settings.name = "Non-Color"
        # The middle of Blender's panoramas lies along x, that of ours along y.
        turned = nodes.new("ShaderNodeMapping")
        turned.vector_type = "TEXTURE"
        turned.inputs["Rotation"].default_value = (0, 0, math.pi / 2 + item["rotation"])
        generated = nodes.new("ShaderNodeTexCoord").outputs["Generated"]
        links.new(generated, turned.inputs["Vector"])
        links.new(turned.outputs["Vector"], picture.inputs["Vector"])
        links.new(picture.outputs["Color"], background.inputs["Color"])
    return world


def build():
    with open(os.path.join(HERE, "scene.json"), encoding="utf-8") as file:
        data = json.load(file)
    scene = bpy.data.scenes.new("unrender")
    materials = [add_material(group) for group in data["groups"]]
    glasses = [add_glass(glass) for glass in data["glasses"]]
    for item in data["objects"]:
        add_object(scene, item, materials, glasses)
    for item in data["lights"]:
        add_light(scene, item)
    cameras = [add_camera(scene, item) for item in data["cameras"]]
    scene.camera = cameras[0]
    scene.world = add_world(data["environment"])
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = data["size"]
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    cycles = scene.cycles
    cycles.pixel_filter_type = "BOX"
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = 64
    cycles.transmission_bounces = cycles.transparent_max_bounces = 64
    return scene


def arguments():
    """The arguments: in Blender those after "--", with the package bpy all of them."""
    if "--" in sys.argv:
        return sys.argv[sys.argv.index("--") + 1:]
    return [] if bpy.app.binary_path else sys.argv[1:]


def main():
    words = arguments()
    scene = build()
    if bpy.context.window is not None:
        bpy.context.window.scene = scene
    if "--spp" in words:
        at = words.index("--spp")
        scene.cycles.samples = int(words[at + 1])
        del words[at:at + 2]
    for path in map(os.path.abspath, words):
        if path.endswith(".blend"):
            bpy.ops.wm.save_as_mainfile(filepath=path)
            continue
        scene.render.image_settings.file_format = "OPEN_EXR"
        scene.render.image_settings.color_depth = "32"
        scene.render.filepath = path
        bpy.ops.render.render(write_still=True, scene=scene.name)


main()
