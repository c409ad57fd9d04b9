//! The properties of glTF's elements and the attributes of its vertices that are known, and how they are taken.
//!
//! What is read has a field in `document.rs`, which a test compares with the table of properties. What has none is
//! warned of, unless it is passed over here.

use crate::entry::{Entry, Table, Taken, near, passed, read, told};

/// An element of the file.
struct Element {
    /// What it is called in warnings.
    kind: &'static str,
    /// What it is called on the page.
    name: &'static str,
    properties: &'static [Entry],
}

/// How the property `name` of an element of `kind` is taken, if it is known.
pub(super) fn property(kind: &str, name: &str) -> Option<&'static Entry> {
    let of_kind = ELEMENTS.iter().filter(|element| element.kind.is_empty() || element.kind == kind);
    let mut rows = of_kind.flat_map(|element| element.properties);
    // What is passed over in one element of a kind is passed over in all.
    rows.clone()
        .find(|row| row.name == name && row.taken == Taken::PassedOver)
        .or_else(|| rows.find(|row| row.name == name))
}

/// What is read of the elements.
pub(super) fn table() -> Table {
    let mut table = Table::new("glTF: properties", "element: property", []);
    ELEMENTS.iter().for_each(|element| table.add(element.name, element.properties));
    table
}

/// How the attribute `key` of vertices is taken, if it is known.
pub(super) fn attribute(key: &str) -> Option<&'static Entry> {
    let is_of = |row: &&Entry| match row.name.strip_suffix('n') {
        Some(numbered) => key.starts_with(numbered),
        None => key == row.name || row.name == "_" && key.starts_with('_'),
    };
    ATTRIBUTES.iter().find(is_of)
}

/// What is read of attributes.
pub(super) fn attributes() -> Table {
    Table::new("glTF: attributes of vertices", "attribute", ATTRIBUTES)
}

const fn element(kind: &'static str, name: &'static str, properties: &'static [Entry]) -> Element {
    Element { kind, name, properties }
}

/// The warning about motions of the nodes.
pub(super) const ANIMATIONS: Entry =
    told("animations", "Animations were ignored; everything stands as its node says");

const COUNTED: &str = "as glTF defines it";
const FACTOR: &str = "a factor";

/// All of them, the properties of all elements first [glTF 2.0 specification].
const ELEMENTS: &[Element] = &[
    element(
        "",
        "all",
        &[
            passed("name", "read for nodes, meshes, materials, lights and cameras"),
            passed("extras", "read where unrender wrote them"),
        ],
    ),
    element(
        "file",
        "file",
        &[
            read("asset", "see asset"),
            read("scene", "the scene that is read; the first one by default"),
            read("scenes", "a warning says if there are several"),
            read("nodes", "see nodes"),
            read("meshes", "see meshes"),
            read("materials", "see materials"),
            read("textures", "see textures"),
            read("images", "see images"),
            read("samplers", "see samplers"),
            read("accessors", "see accessors"),
            read("bufferViews", "see bufferViews"),
            read("buffers", "see buffers"),
            read("cameras", "see cameras"),
            read("extensions", "see extensions"),
            read("extensionsUsed", "those that are not read are warned of"),
            read(
                "extensionsRequired",
                "those that are not read are refused, except those of materials",
            ),
            ANIMATIONS,
            passed("skins", "a warning where a node has one"),
        ],
    ),
    element(
        "asset",
        "asset",
        &[
            read("version", "2.x; others are refused"),
            read("generator", "whether it is Blender, which has meanings of its own for lights"),
            passed("copyright", "a text for people"),
            passed("minVersion", "version says enough"),
        ],
    ),
    element("scenes", "scenes", &[read("nodes", "the uppermost nodes")]),
    element(
        "nodes",
        "nodes",
        &[
            read("mesh", "an object for each material"),
            read("camera", "see cameras"),
            read("children", "moved by the node, too"),
            read("matrix", "in place of translation, rotation and scale"),
            read("translation", COUNTED),
            read("rotation", COUNTED),
            read(
                "scale",
                "as glTF defines it; lights and cameras are moved by it and grow no larger",
            ),
            read("extensions", "see extensions"),
            told("skin", "the mesh stands as it was modelled"),
            passed("weights", "a warning where a mesh has morph targets"),
        ],
    ),
    element(
        "meshes",
        "meshes",
        &[
            read("primitives", "see primitives"),
            passed("weights", "a warning where a primitive has morph targets"),
        ],
    ),
    element(
        "meshes",
        "primitives",
        &[
            read("attributes", "see attributes"),
            read("indices", COUNTED),
            read("material", "the group; grey without one, with a warning"),
            read(
                "mode",
                "triangles, strips and fans; points and lines are left out, with a warning",
            ),
            told("targets", "the mesh stands as it was modelled"),
        ],
    ),
    element(
        "materials",
        "materials",
        &[
            read(
                "pbrMetallicRoughness",
                "a diffuse part and a lobe; grey without it, with a warning",
            ),
            read("emissiveFactor", "the emitted radiance"),
            read(
                "doubleSided",
                "a lamp that is open emits from both sides; other surfaces have two in any case",
            ),
            read("extensions", "see extensions"),
            told("emissiveTexture", "the surface emits emissiveFactor all over"),
            read(
                "normalTexture",
                "tangent-space normals, where it lies on the base colour's coordinates",
            ),
            told("occlusionTexture", "it is left out"),
            read(
                "alphaMode",
                "MASK: holes where the texture covers less; BLEND: the same, at a half, with a warning",
            ),
            read("alphaCutoff", "where holes begin"),
        ],
    ),
    element(
        "materials",
        "pbrMetallicRoughness",
        &[
            read("baseColorFactor", "the colour; clamped to 0 to 1, with a warning"),
            read("baseColorTexture", "a PNG or JPEG picture that the factor multiplies"),
            read(
                "metallicFactor",
                "1 by default; diffuse if roughnessFactor and the texture are missing too, with a warning",
            ),
            read("roughnessFactor", "its square is the roughness of the lobe"),
            told("metallicRoughnessTexture", "the mean is taken"),
        ],
    ),
    element(
        "materials",
        "textureInfo",
        &[
            read("index", "see textures"),
            read("texCoord", "any set of texture coordinates"),
            read("extensions", "see extensions"),
            read("scale", "of normals: how far they tilt"),
        ],
    ),
    element(
        "textures",
        "textures",
        &[read("sampler", "see samplers"), read("source", "see images")],
    ),
    element(
        "images",
        "images",
        &[
            read("uri", "a file beside, or data: in it"),
            read("bufferView", COUNTED),
            passed("mimeType", "the content says it"),
        ],
    ),
    element(
        "samplers",
        "samplers",
        &[
            near("magFilter", "interpolated in any case; a warning where a material has NEAREST"),
            read("wrapS", COUNTED),
            read("wrapT", COUNTED),
            passed("minFilter", "how a program makes pictures smaller"),
        ],
    ),
    element(
        "accessors",
        "accessors",
        &[
            read("bufferView", COUNTED),
            read("byteOffset", COUNTED),
            read("componentType", COUNTED),
            read("normalized", COUNTED),
            read("count", COUNTED),
            read("type", COUNTED),
            read("sparse", COUNTED),
            passed("min", "the numbers say it"),
            passed("max", "the numbers say it"),
        ],
    ),
    element(
        "sparse accessors",
        "sparse",
        &[read("count", COUNTED), read("indices", COUNTED), read("values", COUNTED)],
    ),
    element(
        "sparse accessors",
        "sparse indices and values",
        &[read("bufferView", COUNTED), read("byteOffset", COUNTED), read("componentType", COUNTED)],
    ),
    element(
        "bufferViews",
        "bufferViews",
        &[
            read("buffer", COUNTED),
            read("byteOffset", COUNTED),
            read("byteLength", COUNTED),
            read("byteStride", COUNTED),
            passed("target", "a hint for graphics cards"),
        ],
    ),
    element(
        "buffers",
        "buffers",
        &[
            read("uri", "a file beside, or data: in it; else the binary part of a .glb"),
            read("byteLength", COUNTED),
        ],
    ),
    element(
        "cameras",
        "cameras",
        &[
            read("perspective", "a camera"),
            passed("type", "a camera that is not in perspective is left out, with a warning"),
            passed("orthographic", "the warning of type covers it"),
        ],
    ),
    element(
        "perspective cameras",
        "perspective",
        &[
            read("yfov", COUNTED),
            read("aspectRatio", COUNTED),
            read("znear", "what is nearer is not seen"),
            passed("zfar", "what is further away is seen"),
        ],
    ),
    element(
        "lights",
        "KHR_lights_punctual",
        &[read("lights", "see light"), read("light", "of a node: its light")],
    ),
    element(
        "lights",
        "light",
        &[
            read("type", "point, spot or directional; others are refused"),
            read("color", "linear sRGB"),
            read("intensity", "in the unit that the file, or the user, says"),
            read("spot", "the cone"),
            told("range", "light has no end"),
        ],
    ),
    element(
        "lights",
        "spot",
        &[
            read("innerConeAngle", "from Blender's files, the cone whose light is that of Cycles"),
            read("outerConeAngle", "from Blender's files, the cone whose light is that of Cycles"),
        ],
    ),
    element(
        "lights",
        "EXT_lights_ies",
        &[
            read("lights", "see profile"),
            read("light", "of a node: its profile"),
            read("multiplier", "a factor on the candelas"),
            read("color", "linear sRGB"),
        ],
    ),
    element(
        "lights",
        "profile",
        &[
            read("uri", "a file beside the scene, or its data"),
            read("bufferView", "the bytes of an IES file"),
            passed("mimeType", "what it is shows in the data"),
        ],
    ),
    element("nodes", "KHR_node_visibility", &[read("visible", "what is not visible is left out")]),
    element(
        "materials",
        "KHR_texture_transform",
        &[
            read("offset", COUNTED),
            read("rotation", COUNTED),
            read("scale", COUNTED),
            read("texCoord", "in place of the texture's"),
        ],
    ),
    element("materials", "KHR_materials_emissive_strength", &[read("emissiveStrength", FACTOR)]),
    element(
        "materials",
        "KHR_materials_ior",
        &[read("ior", "the reflectance at normal incidence")],
    ),
    element(
        "materials",
        "KHR_materials_specular",
        &[
            read("specularFactor", FACTOR),
            read("specularColorFactor", FACTOR),
            told("specularTexture", "it is left out"),
            told("specularColorTexture", "it is left out"),
        ],
    ),
    element(
        "materials",
        "KHR_materials_anisotropy",
        &[
            read("anisotropyStrength", COUNTED),
            read("anisotropyRotation", COUNTED),
            told("anisotropyTexture", "it is left out"),
        ],
    ),
    element(
        "materials",
        "KHR_materials_clearcoat",
        &[
            read("clearcoatFactor", COAT),
            read("clearcoatRoughnessFactor", COAT),
            told("clearcoatTexture", "it is left out"),
            told("clearcoatRoughnessTexture", "it is left out"),
            told("clearcoatNormalTexture", "it is left out"),
        ],
    ),
    element(
        "materials",
        "KHR_materials_transmission",
        &[
            read(
                "transmissionFactor",
                "above zero the shapes of the material are smooth glass, and a recovery masks them",
            ),
            passed("transmissionTexture", "where there is glass: all of the shape is"),
        ],
    ),
    element(
        "materials",
        "KHR_materials_volume",
        &[
            read("thicknessFactor", "above zero glass is solid; else where its shape is closed"),
            read("attenuationDistance", "what solid glass absorbs"),
            read("attenuationColor", "what solid glass absorbs"),
            passed("thicknessTexture", "the shape itself says how thick it is"),
        ],
    ),
];

const COAT: &str =
    "the lobe over a base that is diffuse; over others the coat is left out, with a warning";

/// The attributes of vertices, and how they are taken; `n` is a number, and a `_` may be more.
const ATTRIBUTES: &[Entry] = &[
    read("POSITION", "where it is"),
    read("NORMAL", "the normal; without them the triangles are flat"),
    read("TANGENT", "the direction of highlights, and its handedness"),
    read("TEXCOORD_n", "the set that a texture names"),
    told("COLOR_n", "a surface has the colour of its material and its texture"),
    passed("JOINTS_n", "the warning of the node's skin covers it"),
    passed("WEIGHTS_n", "the warning of the node's skin covers it"),
    passed("_", "what a program keeps for itself"),
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// The structures of `document.rs`, each with the element that it is.
    const STRUCTURES: [(&str, &str); 41] = [
        ("Document", "file"),
        ("Asset", "asset"),
        ("DocumentExtensions", ""),
        ("Lights", "KHR_lights_punctual"),
        ("Profiles", "EXT_lights_ies"),
        ("Profile", "profile"),
        ("Light", "light"),
        ("Spot", "spot"),
        ("SceneNodes", "scenes"),
        ("Node", "nodes"),
        ("NodeExtensions", ""),
        ("Visibility", "KHR_node_visibility"),
        ("NodeLight", "KHR_lights_punctual"),
        ("NodeProfile", "EXT_lights_ies"),
        ("Mesh", "meshes"),
        ("Primitive", "primitives"),
        ("Attributes", ""),
        ("Material", "materials"),
        ("Pbr", "pbrMetallicRoughness"),
        ("TextureInfo", "textureInfo"),
        ("TextureExtensions", ""),
        ("TextureTransform", "KHR_texture_transform"),
        ("MaterialExtensions", ""),
        ("EmissiveStrength", "KHR_materials_emissive_strength"),
        ("Ior", "KHR_materials_ior"),
        ("Specular", "KHR_materials_specular"),
        ("Anisotropy", "KHR_materials_anisotropy"),
        ("Clearcoat", "KHR_materials_clearcoat"),
        ("Transmission", "KHR_materials_transmission"),
        ("Volume", "KHR_materials_volume"),
        ("Texture", "textures"),
        ("Image", "images"),
        ("Sampler", "samplers"),
        ("Accessor", "accessors"),
        ("Sparse", "sparse"),
        ("SparseIndices", "sparse indices and values"),
        ("SparseValues", "sparse indices and values"),
        ("BufferView", "bufferViews"),
        ("Buffer", "buffers"),
        ("Camera", "cameras"),
        ("Perspective", "perspective"),
    ];

    /// `byte_offset` as `byteOffset`.
    fn camel_case(field: &str) -> String {
        let mut words = field.split('_');
        let first = words.next().unwrap_or_default().to_owned();
        words.fold(first, |all, word| all + &word[..1].to_uppercase() + &word[1..])
    }

    /// The properties that the structure `name` of `document.rs` has fields for.
    fn fields(name: &str) -> BTreeSet<String> {
        let code = include_str!("document.rs");
        let begin = format!("pub(super) struct {name} {{\n");
        let body = code.split_once(&begin).unwrap_or_else(|| panic!("no {name}")).1;
        let body = body.split_once("\n}").unwrap().0;
        let mut renamed = None;
        let mut found = BTreeSet::new();
        for line in body.lines().map(str::trim) {
            if let Some((_, rest)) = line.split_once("rename = \"") {
                renamed = rest.split_once('"').map(|(name, _)| name.to_owned());
            }
            let field = line.strip_prefix("pub(super) ").and_then(|rest| rest.split_once(':'));
            let Some((field, _)) = field else { continue };
            let own = renamed.take().unwrap_or_else(|| camel_case(field));
            if !["unread", "name", "extras"].contains(&field) {
                found.insert(own);
            }
        }
        found
    }

    #[test]
    fn what_is_read_has_a_field_and_fields_are_in_the_table() {
        let code = include_str!("document.rs");
        let declared = code.matches("pub(super) struct ").count();
        assert_eq!(declared, STRUCTURES.len(), "name the new structure here");
        for element in ELEMENTS.iter().filter(|element| !element.kind.is_empty()) {
            let own = STRUCTURES.iter().filter(|(_, name)| *name == element.name);
            let fields: BTreeSet<String> = own.flat_map(|(name, _)| fields(name)).collect();
            let rows = |taken: &[Taken]| -> BTreeSet<String> {
                let rows = element.properties.iter().filter(|row| taken.contains(&row.taken));
                rows.map(|row| row.name.to_owned()).collect()
            };
            let read = rows(&[Taken::Read, Taken::Approximated]);
            let known = rows(&[Taken::Read, Taken::Approximated, Taken::WarnedOf]);
            let name = element.name;
            assert!(read.is_subset(&fields), "{name}: without a field: {:?}", &read - &fields);
            assert!(fields.is_subset(&known), "{name}: without a row: {:?}", &fields - &known);
        }
    }
}
