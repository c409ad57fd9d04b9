//! What is read of MaterialX, as the tables that the reader itself uses.

use crate::entry::{Entry, Table, near, passed, read as row, refused, told};

const COAT: &str = "the lobe of a base that has none; else it is left out, as there is one specular lobe a surface";
const OF_COAT: &str = "belongs to the coat, which has no colour and no brushing of its own";
const EMISSION: &str = "left out: lamps are those of the scene";
const HOLES: &str = "left out: holes are those of the scene";
const GLASS: &str = "left out: the surface is taken as opaque; glass is that of the scene";
const OF_GLASS: &str = "belongs to glass";
const UNDER: &str = "left out: the base colour is taken as diffuse";
const OF_UNDER: &str = "belongs to subsurface scattering";
const SHEEN: &str = "left out: there is one specular lobe a surface";
const OF_SHEEN: &str = "belongs to the sheen";
const FILM: &str = "left out: the surface has no thin film";
const OF_FILM: &str = "belongs to the thin film";
const THIN: &str = "a surface that is no glass is as thin as its mesh";
const NORMAL: &str = "a normal map, on the scene's texture coordinates";
const TANGENT: &str = "left out: brushing is counted from the scene's tangents";
const ROUGH: &str = "squared; of a picture the mean, which a warning says";
const METAL: &str = "1 is a metal, 0 a dielectric; of a picture the mean, which a warning says";
const COLOR: &str =
    "a colour, or a picture of the base of a dielectric; of a metal's picture the mean";
const FLAT: &str = "left out: the base is Lambertian";

/// The inputs of `standard_surface`.
pub(super) const STANDARD: [Entry; 42] = [
    row("base", "times base_color"),
    row("base_color", COLOR),
    told("diffuse_roughness", FLAT),
    row("metalness", METAL),
    row("specular", "times the dielectric's reflectance"),
    row("specular_color", "times the dielectric's reflectance, of which a plastic has the mean"),
    row("specular_roughness", ROUGH),
    row("specular_IOR", "of the dielectric"),
    row("specular_anisotropy", "alpha/aspect and alpha aspect, with the aspect (1 - a)^(1/2)"),
    row("specular_rotation", "turns from the tangent"),
    told("transmission", GLASS),
    passed("transmission_color", OF_GLASS),
    passed("transmission_depth", OF_GLASS),
    passed("transmission_scatter", OF_GLASS),
    passed("transmission_scatter_anisotropy", OF_GLASS),
    passed("transmission_dispersion", OF_GLASS),
    passed("transmission_extra_roughness", OF_GLASS),
    told("subsurface", UNDER),
    passed("subsurface_color", OF_UNDER),
    passed("subsurface_radius", OF_UNDER),
    passed("subsurface_scale", OF_UNDER),
    passed("subsurface_anisotropy", OF_UNDER),
    told("sheen", SHEEN),
    passed("sheen_color", OF_SHEEN),
    passed("sheen_roughness", OF_SHEEN),
    near("coat", COAT),
    passed("coat_color", OF_COAT),
    row("coat_roughness", ROUGH),
    passed("coat_anisotropy", OF_COAT),
    passed("coat_rotation", OF_COAT),
    row("coat_IOR", "of the coat"),
    passed("coat_normal", OF_COAT),
    passed("coat_affect_color", OF_COAT),
    passed("coat_affect_roughness", OF_COAT),
    told("thin_film_thickness", FILM),
    passed("thin_film_IOR", OF_FILM),
    told("emission", EMISSION),
    passed("emission_color", EMISSION),
    told("opacity", HOLES),
    passed("thin_walled", THIN),
    row("normal", NORMAL),
    told("tangent", TANGENT),
];

/// The inputs of `open_pbr_surface`.
pub(super) const OPEN_PBR: [Entry; 41] = [
    row("base_weight", "times base_color"),
    row("base_color", COLOR),
    told("base_diffuse_roughness", FLAT),
    row("base_metalness", METAL),
    row("specular_weight", "times the dielectric's reflectance"),
    row("specular_color", "times the dielectric's reflectance, of which a plastic has the mean"),
    row("specular_roughness", ROUGH),
    row("specular_ior", "of the dielectric"),
    row(
        "specular_roughness_anisotropy",
        "alpha (2/(1 + (1 - a)^2))^(1/2) along the tangent, times 1 - a across",
    ),
    told("transmission_weight", GLASS),
    passed("transmission_color", OF_GLASS),
    passed("transmission_depth", OF_GLASS),
    passed("transmission_scatter", OF_GLASS),
    passed("transmission_scatter_anisotropy", OF_GLASS),
    passed("transmission_dispersion_scale", OF_GLASS),
    passed("transmission_dispersion_abbe_number", OF_GLASS),
    told("subsurface_weight", UNDER),
    passed("subsurface_color", OF_UNDER),
    passed("subsurface_radius", OF_UNDER),
    passed("subsurface_radius_scale", OF_UNDER),
    passed("subsurface_scatter_anisotropy", OF_UNDER),
    told("fuzz_weight", SHEEN),
    passed("fuzz_color", OF_SHEEN),
    passed("fuzz_roughness", OF_SHEEN),
    near("coat_weight", COAT),
    passed("coat_color", OF_COAT),
    row("coat_roughness", ROUGH),
    passed("coat_roughness_anisotropy", OF_COAT),
    row("coat_ior", "of the coat"),
    passed("coat_darkening", OF_COAT),
    told("thin_film_weight", FILM),
    passed("thin_film_thickness", OF_FILM),
    passed("thin_film_ior", OF_FILM),
    told("emission_luminance", EMISSION),
    passed("emission_color", EMISSION),
    told("geometry_opacity", HOLES),
    passed("geometry_thin_walled", THIN),
    row("geometry_normal", NORMAL),
    passed("geometry_coat_normal", OF_COAT),
    told("geometry_tangent", TANGENT),
    passed("geometry_coat_tangent", OF_COAT),
];

/// The inputs of `gltf_pbr`.
pub(super) const GLTF: [Entry; 29] = [
    row("base_color", COLOR),
    row("metallic", METAL),
    row("roughness", ROUGH),
    row("normal", NORMAL),
    told("tangent", TANGENT),
    passed("occlusion", "light is computed"),
    told("transmission", GLASS),
    row("specular", "times the dielectric's reflectance"),
    row("specular_color", "times the dielectric's reflectance, of which a plastic has the mean"),
    row("ior", "of the dielectric"),
    told("alpha", HOLES),
    passed("alpha_mode", HOLES),
    passed("alpha_cutoff", HOLES),
    told("iridescence", FILM),
    passed("iridescence_ior", OF_FILM),
    passed("iridescence_thickness", OF_FILM),
    told("sheen_color", SHEEN),
    passed("sheen_roughness", OF_SHEEN),
    near("clearcoat", COAT),
    row("clearcoat_roughness", ROUGH),
    passed("clearcoat_normal", OF_COAT),
    told("emissive", EMISSION),
    passed("emissive_strength", EMISSION),
    passed("thickness", OF_GLASS),
    passed("attenuation_distance", OF_GLASS),
    passed("attenuation_color", OF_GLASS),
    row("anisotropy_strength", "alpha and alpha + (1 - alpha) s^2, as in glTF"),
    row("anisotropy_rotation", "radians from the tangent"),
    passed("dispersion", OF_GLASS),
];

/// Elements of the file.
const ELEMENTS: [Entry; 18] = [
    row("surfacematerial", "a material, by its name, by the doc of its shader, or by a look"),
    row("standard_surface", "with the inputs below"),
    row("open_pbr_surface", "with the inputs below"),
    row("gltf_pbr", "with the inputs below"),
    row("nodegraph", "its outputs and its interface are followed"),
    row(
        "image",
        "and tiledimage, gltf_image, gltf_colorimage: the picture; how it is tiled is told and left out",
    ),
    row("normalmap", "and gltf_normalmap, with its scale"),
    row("multiply", "by a value"),
    row("constant", "its value"),
    row("convert", "and dot: passed through"),
    row("extract", "and separate2 to separate4: one channel"),
    told("other nodes", "the input has its default; the warning names the node"),
    row("look", "the materialassign that name groups or objects of the scene"),
    told("other shaders", "the material is left out"),
    row("colorspace", "lin_rec709 and srgb_texture; others are told of and taken as lin_rec709"),
    row("fileprefix", "before the names of pictures"),
    row("comments of unrender", "the exact numbers of an exported material"),
    refused("xi:include", "and document types: write the file in one"),
];

/// What is read of MaterialX.
pub(crate) fn tables() -> Vec<Table> {
    let inputs = |title, rows: &'static [Entry]| Table::new(title, "input", rows);
    vec![
        Table::new("MaterialX: elements", "element", &ELEMENTS),
        inputs("MaterialX: standard_surface", &STANDARD),
        inputs("MaterialX: open_pbr_surface", &OPEN_PBR),
        inputs("MaterialX: gltf_pbr", &GLTF),
    ]
}
