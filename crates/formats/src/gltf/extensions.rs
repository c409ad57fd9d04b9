//! The extensions of glTF: which are read, and what is said about the others.

use crate::entry::{Entry, Table, Taken, find, passed, read, refused as refusing, told};

/// The name of the extension that moves, turns and scales textures.
pub(super) const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";

const TRANSPARENT: &str = "transparent surfaces are not modelled; they were taken as opaque";
const OTHER_PICTURE: &str = "of each texture the PNG or JPEG picture was taken, where it has one";

/// The known extensions, and how they are taken where a file uses them; for those warned of, the end of the
/// warning.
const EXTENSIONS: &[Entry] = &[
    read("KHR_lights_punctual", "see its properties"),
    read("EXT_lights_ies", "see its properties"),
    read("KHR_materials_emissive_strength", "see its properties"),
    read("KHR_materials_ior", "see its properties"),
    read("KHR_materials_specular", "see its properties"),
    read("KHR_materials_anisotropy", "see its properties"),
    read("KHR_mesh_quantization", "positions, normals and texture coordinates as whole numbers"),
    read("KHR_node_visibility", "see its properties"),
    read(TEXTURE_TRANSFORM, "see its properties"),
    read("KHR_materials_transmission", "see its properties"),
    read("KHR_materials_volume", "see its properties"),
    passed("KHR_materials_dispersion", "glass bends all colours alike"),
    told("KHR_materials_diffuse_transmission", TRANSPARENT),
    told(
        "KHR_materials_clearcoat",
        "there is one specular lobe a surface; a clearcoat is read over a diffuse base, and left out over others",
    ),
    told("KHR_materials_sheen", "the sheen of cloth is not modelled; it was left out"),
    told("KHR_materials_iridescence", "thin films are not modelled; they were left out"),
    told("KHR_materials_unlit", "surfaces without shading were taken as reflecting ones"),
    told("KHR_materials_variants", "the materials of the meshes themselves were taken"),
    told(
        "KHR_materials_pbrSpecularGlossiness",
        "metallic and roughness were read instead; export the scene with these",
    ),
    told("KHR_texture_basisu", OTHER_PICTURE),
    told("EXT_texture_webp", OTHER_PICTURE),
    told("EXT_texture_avif", OTHER_PICTURE),
    told(OTHERS, "it is not understood and was ignored"),
];

/// What stands in the tables for extensions that have no row.
const OTHERS: &str = "others";

const MESHOPT: &str = "export the scene without it (in Blender's glTF export: Data > Meshopt Compression off; in \
                       gltfpack: leave out -c and -cc)";
const WEB_PICTURE: &str = "export the scene without it, its textures as PNG or JPEG (in Blender's glTF export: Data > Material > Images: \
     Automatic, and Create WebP off or WebP Fallback on)";

/// What to do where a file requires what is not understood.
const REQUIRED: &[Entry] = &[
    refusing(
        "KHR_draco_mesh_compression",
        "export the scene without it (in Blender's glTF export: Data > Compression, or Draco Compression, off)",
    ),
    refusing("EXT_meshopt_compression", MESHOPT),
    refusing("KHR_meshopt_compression", MESHOPT),
    refusing(
        "KHR_texture_basisu",
        "export the scene without it, its textures as PNG or JPEG (in gltfpack: leave out -tc)",
    ),
    refusing("EXT_texture_webp", WEB_PICTURE),
    refusing("EXT_texture_avif", WEB_PICTURE),
    refusing(
        "EXT_mesh_gpu_instancing",
        "export the scene without it (in Blender's glTF export: Data > Scene Graph > GPU Instances off)",
    ),
    refusing(OTHERS, "export the scene without it (without compression)"),
];

/// What is read of extensions.
pub(super) fn tables() -> [Table; 2] {
    [
        Table::new("glTF: extensions that a file uses", "extension", EXTENSIONS),
        Table::new("glTF: extensions that a file requires", "extension", REQUIRED),
    ]
}

/// The extensions that are read, or whose absence changes nothing.
pub(super) fn understood() -> impl Iterator<Item = &'static str> {
    EXTENSIONS.iter().filter(|row| row.taken == Taken::Read).map(|row| row.name)
}

/// Whether the extension `name` is one of them, or is passed over.
pub(super) fn is_read(name: &str) -> bool {
    find(EXTENSIONS, name).is_some_and(|row| matches!(row.taken, Taken::Read | Taken::PassedOver))
}

/// Whether a scene without the extension `name` still has its geometry, lights and cameras: an
/// extension of the materials only changes how surfaces look, which is what is recovered.
pub(super) fn may_be_ignored(name: &str) -> bool {
    is_read(name) || name.starts_with("KHR_materials_")
}

/// The warning that the extension `name` is not read.
pub(super) fn ignored(name: &str) -> String {
    match find(EXTENSIONS, name) {
        Some(row) => format!("The glTF extension {name} is not read: {}.", row.done),
        None => format!("The glTF extension {name} is not understood; it was ignored."),
    }
}

/// Why a file that requires the extension `name` cannot be read, and what to do about it.
pub(super) fn refused(name: &str) -> String {
    let row = find(REQUIRED, name).or_else(|| find(REQUIRED, OTHERS));
    let remedy = row.map_or("", |row| row.done);
    format!("requires the glTF extension {name}, which is not understood; {remedy}")
}
