//! The plugins of Mitsuba that are known, each with its properties, and how they are taken.
//!
//! A property without a row here cannot be asked for ([`Node`](super::tree::Node) looks it up), so a warning says
//! that it is not read; for one that is passed over here there is no warning.

use crate::entry::{Entry, Table, Taken, near, passed, read, refused, told};

/// A plugin by its element and its type.
#[derive(Debug)]
pub(super) struct Plugin {
    tag: &'static str,
    /// Its type; a star for all that have no row of their own.
    kind: &'static str,
    /// Its name, and how it is taken.
    entry: Entry,
    /// Its own properties; plugins within it stand as `<tag>`.
    properties: &'static [Entry],
    /// Properties that it shares with others.
    shared: Option<&'static Shared>,
}

/// Properties of several plugins.
#[derive(Debug)]
struct Shared {
    of: &'static str,
    properties: &'static [Entry],
}

/// The plugin of the element `tag` and of the type `kind`.
pub(super) fn find(tag: &str, kind: &str) -> Option<&'static Plugin> {
    let of = |kind: &str| PLUGINS.iter().find(|plugin| plugin.tag == tag && plugin.kind == kind);
    of(kind).or_else(|| of("*"))
}

impl Plugin {
    fn rows(&self) -> impl Iterator<Item = &'static Entry> {
        self.properties.iter().chain(self.shared.map_or(&[][..], |shared| shared.properties))
    }

    /// The row of the property `name`.
    pub(super) fn property(&self, name: &str) -> Option<&'static Entry> {
        self.rows().find(|row| row.name == name)
    }

    /// The row of the elements `tag` in it.
    pub(super) fn inner(&self, tag: &str) -> Option<&'static Entry> {
        let within = |row: &&Entry| {
            row.name.strip_prefix('<').and_then(|name| name.strip_suffix('>')) == Some(tag)
        };
        self.rows().find(within)
    }

    /// Whether a property of this name (or of the element `tag`, if it is a plugin) is passed over.
    pub(super) fn passes(&self, name: &str, tag: Option<&str>) -> bool {
        let rows = [self.property(name), tag.and_then(|tag| self.inner(tag))];
        rows.into_iter().flatten().any(|row| row.taken == Taken::PassedOver)
    }
}

/// What is read of the plugins.
pub(super) fn tables() -> Vec<Table> {
    let titles = [
        ("Mitsuba: the scene", "scene"),
        ("Mitsuba: shapes", "shape"),
        ("Mitsuba: BSDFs", "bsdf"),
        ("Mitsuba: textures and spectra", "texture"),
        ("Mitsuba: emitters", "emitter"),
        ("Mitsuba: sensors and films", "sensor"),
    ];
    let tags = |tag: &'static str| if tag == "sensor" { vec![tag, "film"] } else { vec![tag] };
    let table = |(title, tag): (&'static str, &'static str)| {
        let tags = tags(tag);
        let of_tag = || PLUGINS.iter().filter(|plugin| tags.contains(&plugin.tag));
        let mut table = Table::new(title, "type, or property", []);
        for plugin in of_tag() {
            table.add("", [&plugin.entry]);
            table.add(plugin.entry.name, plugin.properties);
        }
        let mut seen: Vec<&str> = Vec::new();
        for shared in of_tag().filter_map(|plugin| plugin.shared) {
            if !seen.contains(&shared.of) {
                seen.push(shared.of);
                table.add(shared.of, shared.properties);
            }
        }
        table
    };
    titles.into_iter().map(table).collect()
}

const fn plugin(
    (tag, kind): (&'static str, &'static str),
    entry: Entry,
    properties: &'static [Entry],
) -> Plugin {
    Plugin { tag, kind, entry, properties, shared: None }
}

const fn sharing(shared: &'static Shared, plugin: Plugin) -> Plugin {
    Plugin { shared: Some(shared), ..plugin }
}

const fn shape(entry: Entry, properties: &'static [Entry]) -> Plugin {
    sharing(SHAPES, plugin(("shape", entry.name), entry, properties))
}

const fn bsdf(entry: Entry, properties: &'static [Entry]) -> Plugin {
    plugin(("bsdf", entry.name), entry, properties)
}

const fn texture(entry: Entry, properties: &'static [Entry]) -> Plugin {
    plugin(("texture", entry.name), entry, properties)
}

const fn emitter(entry: Entry, properties: &'static [Entry]) -> Plugin {
    sharing(EMITTERS, plugin(("emitter", entry.name), entry, properties))
}

const fn sensor(entry: Entry, properties: &'static [Entry]) -> Plugin {
    sharing(SENSORS, plugin(("sensor", entry.name), entry, properties))
}

const SHAPES: &Shared = &Shared {
    of: "shapes",
    properties: &[
        read("to_world", "where it is; if it mirrors, the front is where Mitsuba has it"),
        read("<bsdf>", "what it is made of; grey without one, and black if it is a lamp"),
        read("<emitter>", "of the type area: it is a lamp"),
        read("flip_normals", "its front is where its back was"),
        passed("silhouette_sampling_weight", "how it is sampled"),
    ],
};

const EMITTERS: &Shared =
    &Shared { of: "emitters", properties: &[passed("sampling_weight", "how it is sampled")] };

const SENSORS: &Shared = &Shared {
    of: "sensors",
    properties: &[
        read("to_world", "where it is and where it looks"),
        read("fov", "the angle of view, degrees"),
        read("fov_axis", "x, y, diagonal, smaller or larger"),
        read(
            "focal_length",
            "in its place, of a film of 24 mm x 36 mm by its diagonal; 50mm by default",
        ),
        read("principal_point_offset_x", "how far the axis is off the middle"),
        read("principal_point_offset_y", "how far the axis is off the middle"),
        read("<film>", "the sides of the picture"),
        passed("<sampler>", "how pixels are sampled"),
        passed("near_clip", "nearer surfaces are seen, too"),
        passed("far_clip", "surfaces further away are seen, too"),
        passed("focus_distance", "all is sharp"),
        passed("shutter_open", "nothing moves"),
        passed("shutter_close", "nothing moves"),
    ],
};

const TRANSPARENT: &str = "it lets light through; leave its shapes out, or make them opaque";
const LEFT_OUT: &str = "it is left out";
const AT_NORMAL: &str = "reflects at all angles as at normal incidence";
const ROUGHNESS: &str = "a number, or the mean of a texture, with a warning";

const DISTRIBUTION: Entry = read(
    "distribution",
    "ggx; beckmann, the default, is taken as Ward's of the same roughness, with a warning for metals",
);
const ALPHA: Entry = read("alpha", ROUGHNESS);
const ALPHA_U: Entry = read("alpha_u", ROUGHNESS);
const ALPHA_V: Entry = read("alpha_v", ROUGHNESS);
const VISIBLE: Entry = passed("sample_visible", "how it is sampled");
const DIFFUSE: Entry = read("diffuse_reflectance", "a colour, a spectrum or a texture");
const SPECULAR: Entry =
    read("specular_reflectance", "a colour; the mean of a texture, with a warning");
const MATERIAL: Entry = told("material", AT_NORMAL);
const ETA: Entry = told("eta", AT_NORMAL);
const K: Entry = told("k", AT_NORMAL);
const INT_IOR: Entry = read("int_ior", "a number or the name of a material");
const EXT_IOR: Entry = read("ext_ior", "a number or the name of a material");
const NONLINEAR: Entry =
    read("nonlinear", "whether the diffuse colour counts at each reflection inside");
const INNER: Entry = read("<bsdf>", "what it is of");
const FILE: Entry = read("filename", "the file, as seen from the scene or from a path");
const TO_UV: Entry = read("to_uv", "how texture coordinates are moved");
const FROM: Entry = read("wavelength_min", "in nm; 360 by default");
const TO: Entry = read("wavelength_max", "in nm; 830 by default");
const OLD_FROM: Entry = read("lambda_min", "as wavelength_min");
const OLD_TO: Entry = read("lambda_max", "as wavelength_max");
const WHOLE: Entry = read("value", "wavelengths and values in one");
const FLAT: Entry = read("face_normals", "its triangles are flat");
const FLIPPED: Entry =
    read("flip_tex_coords", "v counts from the other end; true by default for obj only");

const PLASTIC: &str = "a diffuse part and a lobe, taken as it reflects at normal incidence";
const PLASTICS: &[Entry] = &[
    DIFFUSE,
    SPECULAR,
    INT_IOR,
    EXT_IOR,
    NONLINEAR,
    DISTRIBUTION,
    ALPHA,
    ALPHA_U,
    ALPHA_V,
    VISIBLE,
];

const PLUGINS: &[Plugin] = &[
    plugin(
        ("scene", ""),
        read("scene", "of version 0.5 and later; old names are upgraded as Mitsuba does"),
        &[
            read("<shape>", "see shapes"),
            read("<bsdf>", "see BSDFs; a warning for one that is not read and that no shape has"),
            read("<emitter>", "see emitters; two environments are refused"),
            read("<sensor>", "each is a camera"),
            passed("<integrator>", "how to render"),
            passed("<sampler>", "how to render"),
            passed("<film>", "read where something refers to it"),
            passed("<rfilter>", "read where something refers to it"),
            passed("<texture>", "read where something refers to it"),
            passed("<medium>", "a warning where a shape has it"),
            passed("<phase>", "a warning where a shape has it"),
            passed("<volume>", "a warning where a shape has it"),
        ],
    ),
    shape(read("ply", "see PLY; smooth where it has no normals"), &[FILE, FLAT, FLIPPED]),
    shape(
        read("obj", "all faces, as one; smooth where they have no normals"),
        &[FILE, FLAT, FLIPPED],
    ),
    shape(
        read("serialized", "Mitsuba's compressed meshes"),
        &[FILE, FLAT, FLIPPED, read("shape_index", "which mesh of the file")],
    ),
    shape(read("rectangle", "two triangles"), &[]),
    shape(read("cube", "twelve triangles"), &[passed("face_normals", "it is flat in any case")]),
    shape(
        near("sphere", "a smooth mesh of triangles"),
        &[read("center", "where it is"), read("radius", "1 by default")],
    ),
    shape(
        near("cylinder", "64 strips around it, without its ends; a warning if it is stretched"),
        &[
            read("p0", "the middle of one end"),
            read("p1", "the middle of the other end"),
            read("radius", "1 by default"),
        ],
    ),
    shape(near("disk", "a mesh of triangles, 64 around"), &[]),
    plugin(
        ("shape", "instance"),
        read("instance", "the shapes of a shapegroup once more"),
        &[read("to_world", "where they are"), read("<shape>", "the shapegroup")],
    ),
    plugin(
        ("shape", "shapegroup"),
        read("shapegroup", "seen only where instances of it are"),
        &[read("<shape>", "its shapes")],
    ),
    plugin(("shape", "merge"), read("merge", "the shapes in it"), &[read("<shape>", "its shapes")]),
    shape(refused("others", "put a mesh in their place"), &[]),
    bsdf(read("diffuse", "exact"), &[read("reflectance", "a colour, a spectrum or a texture")]),
    bsdf(
        read(
            "twosided",
            "its front; a back of its own is left out, with a warning. Without it surfaces reflect \
             on both sides, too, with a warning if a camera sees the back",
        ),
        &[INNER],
    ),
    bsdf(
        read("conductor", "a perfect mirror, unless it has a metal"),
        &[SPECULAR, MATERIAL, ETA, K],
    ),
    bsdf(
        read("roughconductor", "GGX, if all rough BSDFs have it; else Ward's"),
        &[DISTRIBUTION, ALPHA, ALPHA_U, ALPHA_V, SPECULAR, MATERIAL, ETA, K, VISIBLE],
    ),
    bsdf(told("plastic", PLASTIC), &[DIFFUSE, SPECULAR, INT_IOR, EXT_IOR, NONLINEAR]),
    bsdf(told("roughplastic", PLASTIC), PLASTICS),
    bsdf(told("pplastic", PLASTIC), PLASTICS),
    bsdf(
        told("principled", "a diffuse part and a lobe of GGX, as it reflects at normal incidence"),
        &[
            read("base_color", "a colour, a spectrum or a texture"),
            read("metallic", ROUGHNESS),
            read("roughness", ROUGHNESS),
            read("anisotropic", ROUGHNESS),
            read("specular", ROUGHNESS),
            read("eta", "in place of specular"),
            told("sheen", LEFT_OUT),
            told("clearcoat", LEFT_OUT),
            told("flatness", LEFT_OUT),
            told("spec_tint", LEFT_OUT),
            passed("sheen_tint", "the warning of sheen covers it"),
            passed("clearcoat_gloss", "the warning of clearcoat covers it"),
            refused("spec_trans", "above zero it lets light through; make it opaque"),
        ],
    ),
    bsdf(
        read("ward", "of Mitsuba 0.5; exact"),
        &[
            read("variant", "ward, ward-duer or balanced"),
            DIFFUSE,
            SPECULAR,
            ALPHA,
            ALPHA_U,
            ALPHA_V,
        ],
    ),
    bsdf(
        read(
            "blendbsdf",
            "exact where at most one of the two has a lobe or both are equally rough",
        ),
        &[
            read("weight", "a number, or the mean of a texture, with a warning"),
            read("<bsdf>", "the two"),
        ],
    ),
    bsdf(
        told("mask", "opaque everywhere, unless its opacity is 0 or 1"),
        &[read("opacity", "0 or 1 everywhere"), INNER],
    ),
    bsdf(
        told("bumpmap", "the surface is taken as it is"),
        &[
            INNER,
            passed("<texture>", "the warning of its plugin covers it"),
            passed("scale", "belongs to what is left out"),
        ],
    ),
    bsdf(
        told("normalmap", "the surface is taken as it is"),
        &[
            INNER,
            passed("<texture>", "the warning of its plugin covers it"),
            passed("normalmap", "the warning of its plugin covers it"),
        ],
    ),
    bsdf(read("null", "the surface is not there; as a lamp it is black"), &[]),
    bsdf(refused("dielectric", TRANSPARENT), &[]),
    bsdf(refused("roughdielectric", TRANSPARENT), &[]),
    bsdf(refused("thindielectric", TRANSPARENT), &[]),
    bsdf(refused("principledthin", TRANSPARENT), &[]),
    bsdf(refused("others", "put a diffuse, conductor, plastic or principled in their place"), &[]),
    texture(
        read("bitmap", "a picture; see pictures"),
        &[
            FILE,
            read("raw", "its values as they are, not by their profile"),
            near("filter_type", "bilinear; nearest: enlarged, so that little is interpolated"),
            read("wrap_mode", "repeat, mirror or clamp"),
            TO_UV,
            passed("format", "how it is kept"),
            passed("accel", "how it is kept"),
        ],
    ),
    texture(
        near("checkerboard", "a picture of 512 x 512"),
        &[
            read("color0", "a colour; the mean of a texture, with a warning"),
            read("color1", "a colour; the mean of a texture, with a warning"),
            TO_UV,
        ],
    ),
    texture(
        read("srgb", "a colour"),
        &[read("color", "linear sRGB"), read("unbounded", "whether it may be above one")],
    ),
    texture(
        read("uniform", "the same at all wavelengths"),
        &[
            read("value", "1 by default"),
            passed("wavelength_min", "it is the same everywhere"),
            passed("wavelength_max", "it is the same everywhere"),
        ],
    ),
    texture(read("rawconstant", "a number or three"), &[read("value", "as it is")]),
    texture(
        read("d65", "daylight, or a colour under it"),
        &[
            read("scale", "a factor"),
            read("color", "linear sRGB"),
            read("<texture>", "in place of color"),
        ],
    ),
    texture(
        read("blackbody", "of light, as linear sRGB"),
        &[read("temperature", "in K"), FROM, TO, OLD_FROM, OLD_TO],
    ),
    texture(
        read("regular", "as linear sRGB"),
        &[read("values", "at equal steps of the wavelength"), FROM, TO, OLD_FROM, OLD_TO, WHOLE],
    ),
    texture(
        read("irregular", "as linear sRGB"),
        &[read("wavelengths", "in nm, growing"), read("values", "one for each"), WHOLE],
    ),
    texture(refused("others", "put a colour or a bitmap in their place"), &[]),
    emitter(
        read("area", "the shape that it stands in shines"),
        &[read("radiance", "a colour or a spectrum; the mean of a texture, with a warning")],
    ),
    emitter(
        read("point", "a point light"),
        &[
            read("position", "where it is"),
            read("to_world", "where it is, if there is no position"),
            read("intensity", "a colour or a spectrum"),
        ],
    ),
    emitter(
        told(
            "spot",
            "the nearest cone of ours that sends the same light in all; exact only where beam_width is not below \
             cutoff_angle",
        ),
        &[
            read("to_world", "where it is and where it points"),
            read("intensity", "a colour or a spectrum"),
            read("cutoff_angle", "where its light ends; 20 degrees by default"),
            read(
                "beam_width",
                "where it begins to fade; three quarters of cutoff_angle by default",
            ),
            read("texture", "a colour; the mean of a picture, with a warning"),
        ],
    ),
    emitter(
        read("directional", "light from far away"),
        &[
            read("direction", "where it points"),
            read("to_world", "along its z, if there is no direction"),
            read("irradiance", "a colour or a spectrum"),
        ],
    ),
    emitter(
        read("constant", "the environment, the same everywhere"),
        &[read("radiance", "a colour or a spectrum")],
    ),
    emitter(
        read(
            "envmap",
            "the environment; a warning for pictures of 8 or 16 bits, which lack bright light",
        ),
        &[
            FILE,
            read("scale", "a factor"),
            read("to_world", "how it is turned"),
            passed("mis_compensation", "how it is sampled"),
        ],
    ),
    emitter(
        refused(
            "others",
            "put an area, point, spot, directional, constant or envmap in their place",
        ),
        &[],
    ),
    sensor(read("perspective", "a camera"), &[]),
    sensor(
        read("thinlens", "a camera without depth of field"),
        &[told("aperture_radius", "above zero it is left out: everything is sharp")],
    ),
    plugin(("sensor", "others"), told("others", "they are not pinholes and are left out"), &[]),
    plugin(
        ("film", "*"),
        read("film", "of all types"),
        &[
            read("width", "768 by default"),
            read("height", "576 by default"),
            read("crop_width", "the part of it that is rendered"),
            read("crop_height", "the part of it that is rendered"),
            read("crop_offset_x", "where that part begins"),
            read("crop_offset_y", "where that part begins"),
            passed("<rfilter>", "how pixels are filtered"),
            passed("pixel_format", "how the picture is written"),
            passed("component_format", "how the picture is written"),
            passed("file_format", "how the picture is written"),
            passed("compression", "how the picture is written"),
            passed("banner", "how the picture is written"),
            passed("compensate", "how the picture is summed"),
            passed("sample_border", "how pixels are filtered"),
            passed("high_quality_edges", "how pixels are filtered"),
        ],
    ),
];
