"""Principled materials, and what is true of them."""

import dataclasses
import json
import pathlib
from typing import Any

import bpy
import numpy as np

import textures

Colour = tuple[float, float, float]


@dataclasses.dataclass(frozen=True)
class Paint:
    """The inputs of a Principled BSDF that a room sets; all others stay at Blender's defaults."""

    base: Colour | str
    """*Base Color*, linear, or the name of a texture."""
    roughness: float = 0.5
    metallic: float = 0.0
    ior: float = 1.5
    specular: float = 0.5
    """*Specular IOR Level*; 0.5 leaves the reflectance that follows from ``ior``."""
    transmission: float = 0.0
    normal: str | None = None
    """The name of a normal map."""
    strength: float = 1.0
    """*Strength* of the normal map."""
    cutout: bool = False
    """Whether the base texture's alpha, cut at one half, is the coverage."""
    emission: Colour | None = None
    """Radiance, W sr^-1 m^-2: the material is a lamp."""

    def diffuse(self) -> "Paint":
        """The same base without gloss, maps and coverage."""
        if self.emission is not None:
            return self
        return Paint(self.base, roughness=1.0, specular=0.0)


def lamp(radiance: Colour) -> Paint:
    """A lamp that reflects nothing."""
    return Paint((0.0, 0.0, 0.0), roughness=1.0, specular=0.0, emission=radiance)


class Palette:
    """The materials of one room, by the names of their groups."""

    def __init__(self, folder: pathlib.Path, without: frozenset[str], only_diffuse: bool) -> None:
        """Textures go into ``folder``/textures; ``without`` names glass, maps and cutouts that are left out."""
        self.folder = folder
        self.without = without
        self.only_diffuse = only_diffuse
        self.paints: dict[str, Paint] = {}
        self.images: dict[str, bpy.types.Image] = {}
        (folder / "textures").mkdir(parents=True, exist_ok=True)

    def texture(self, name: str, picture: textures.Picture, *, data: bool = False) -> str:
        """Writes a texture as PNG: colours encoded, ``data`` as it is. Its top row comes first."""
        coded = picture if data else np.dstack([textures.encoded(picture[..., :3]), picture[..., 3:]])
        if coded.shape[2] == 3:
            coded = np.dstack([coded, np.ones(coded.shape[:2])])
        path = self.folder / "textures" / f"{name}.png"
        drawn = bpy.data.images.new(f"{name} drawn", coded.shape[1], coded.shape[0], alpha=True)
        drawn.alpha_mode = "CHANNEL_PACKED"
        drawn.pixels.foreach_set(np.ascontiguousarray(coded[::-1], dtype=np.float32).ravel())
        drawn.filepath_raw, drawn.file_format = str(path), "PNG"
        drawn.save()
        bpy.data.images.remove(drawn)
        image = bpy.data.images.load(str(path))
        image.name = name
        image.alpha_mode = "CHANNEL_PACKED" if picture.shape[2] == 4 else "NONE"
        image.colorspace_settings.name = "Non-Color" if data else "sRGB"
        self.images[name] = image
        return name

    def add(self, name: str, paint: Paint) -> None:
        """Makes the material ``name``, simplified as the room is."""
        if self.only_diffuse:
            paint = paint.diffuse()
        if "maps" in self.without and paint.normal is not None:
            paint = dataclasses.replace(paint, normal=None)
        self.paints[name] = paint
        build(bpy.data.materials.new(name), paint, self.images)

    def shows(self, kind: str) -> bool:
        """Whether things of ``kind``, "glass" or "cutouts", stand in the room."""
        return kind not in self.without and not self.only_diffuse

    def truth(self) -> dict[str, Any]:
        """What truth.json states of the groups; their numbers in the pictures count from 1."""
        used = {slot.material.name for thing in bpy.context.scene.objects for slot in thing.material_slots}
        names = [name for name in self.paints if name in used]
        return {name: {"index": number, **stated(self.paints[name])} for number, name in enumerate(names, 1)}


def stated(paint: Paint) -> dict[str, Any]:
    """A paint as truth.json has it."""
    textured = isinstance(paint.base, str)
    made: dict[str, Any] = {
        "base_color": None if textured else list(paint.base),
        "base_color_texture": f"textures/{paint.base}.png" if textured else None,
        "metallic": paint.metallic,
        "roughness": paint.roughness,
        "ior": paint.ior,
        "specular_ior_level": paint.specular,
        "transmission": paint.transmission,
        "normal_map": f"textures/{paint.normal}.png" if paint.normal else None,
        "alpha_cutout": paint.cutout,
    }
    if paint.emission is not None:
        made["emission"] = list(paint.emission)
    return made


def build(material: bpy.types.Material, paint: Paint, images: dict[str, bpy.types.Image]) -> None:
    """The node tree of a paint, as one clicks it together."""
    material.use_nodes = True
    tree = material.node_tree
    shader = tree.nodes["Principled BSDF"]
    values = {"Roughness": paint.roughness, "Metallic": paint.metallic, "IOR": paint.ior,
              "Specular IOR Level": paint.specular, "Transmission Weight": paint.transmission}
    for key, value in values.items():
        shader.inputs[key].default_value = value
    if paint.emission is not None:
        strength = max(paint.emission)
        shader.inputs["Emission Color"].default_value = (*[c / strength for c in paint.emission], 1.0)
        shader.inputs["Emission Strength"].default_value = strength
    if isinstance(paint.base, str):
        picture = tree.nodes.new("ShaderNodeTexImage")
        picture.image = images[paint.base]
        tree.links.new(picture.outputs["Color"], shader.inputs["Base Color"])
        if paint.cutout:
            # The exporter knows this node as glTF's alphaMode MASK.
            cut = tree.nodes.new("ShaderNodeMath")
            cut.operation = "GREATER_THAN"
            cut.inputs[1].default_value = 0.5
            tree.links.new(picture.outputs["Alpha"], cut.inputs[0])
            tree.links.new(cut.outputs[0], shader.inputs["Alpha"])
    else:
        shader.inputs["Base Color"].default_value = (*paint.base, 1.0)
    if paint.normal is not None:
        picture, bump = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeNormalMap")
        picture.image = images[paint.normal]
        bump.inputs["Strength"].default_value = paint.strength
        tree.links.new(picture.outputs["Color"], bump.inputs["Color"])
        tree.links.new(bump.outputs["Normal"], shader.inputs["Normal"])


def write_truth(path: pathlib.Path, room: str, groups: dict[str, Any], more: dict[str, Any]) -> None:
    """truth.json."""
    document = {"version": 1, "room": room, **more, "groups": groups}
    path.write_text(json.dumps(document, indent=2) + "\n")
