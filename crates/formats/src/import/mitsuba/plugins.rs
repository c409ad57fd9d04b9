//! The plugins of Mitsuba that are known, each with its properties, and how they are taken.
//!
//! A property without a row here cannot be asked for ([`Node`](super::tree::Node) looks it up), so a warning says
//! that it is not read; for one that is passed over here there is no warning.

mod emitters;

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

/// All plugins.
fn all() -> impl Iterator<Item = &'static Plugin> {
    PLUGINS.iter().chain(emitters::EMITTERS)
}

/// The plugin of the element `tag` and of the type `kind`.
pub(super) fn find(tag: &str, kind: &str) -> Option<&'static Plugin> {
    let of = |kind: &str| all().find(|plugin| plugin.tag == tag && plugin.kind == kind);
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
        let of_tag = || all().filter(|plugin| tags.contains(&plugin.tag));
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

const CLEAR: &str =
    "smooth glass, where a shape is closed, and a pane elsewhere; a recovery masks its shapes";
const COVERED: &str = "the warning of its plugin covers it";
const BUMPS: Entry = read(
    "<texture>",
    "its picture; one with another to_uv than others is left out, with a warning",
);
const COAT: &str =
    "of Mitsuba 0.5; over a diffuse BSDF a plastic, over others only its darkening, with a warning";
const LEFT_OUT: &str = "it is left out";
const METAL: &str =
    "a metal that reflects so at normal incidence, and by Schlick's approximation at others";
const ROUGHNESS: &str = "a number, or the mean of a texture, with a warning";

const DISTRIBUTION: Entry = read(
    "distribution",
    "ggx; beckmann, the default, is taken as GGX of the same roughness, with a warning; phong and as, \
     of Mitsuba 0.5, as beckmann",
);
const ALPHA: Entry = read("alpha", ROUGHNESS);
const ALPHA_U: Entry = read("alpha_u", ROUGHNESS);
const ALPHA_V: Entry = read("alpha_v", ROUGHNESS);
const VISIBLE: Entry = passed("sample_visible", "how it is sampled");
const DIFFUSE: Entry = read("diffuse_reflectance", "a colour, a spectrum or a texture");
const SHINE: Entry = told(
    "specular_reflectance",
    "zero is no lobe; colours are left out: Fresnel's reflectance has none",
);
const SPECULAR: Entry =
    read("specular_reflectance", "a colour; the mean of a texture, with a warning");
const TRANSMITTED: Entry = read(
    "specular_transmittance",
    "the factor on light that passes a surface; the mean of a texture, with a warning",
);
const REFLECTED: Entry =
    told("specular_reflectance", "all but one is left out: Fresnel's reflectance has no colour");
const MATERIAL: Entry = read("material", METAL);
const ETA: Entry = read("eta", METAL);
const K: Entry = read("k", METAL);
const EXT_ETA: Entry = read("ext_eta", "a number or the name of a material; 1 by default");
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

const PLASTIC: &str =
    "a dielectric over a base; Beckmann's microfacets are taken as GGX, with a warning";
const PLASTICS: &[Entry] =
    &[DIFFUSE, SHINE, INT_IOR, EXT_IOR, NONLINEAR, DISTRIBUTION, ALPHA, ALPHA_U, ALPHA_V, VISIBLE];

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
    bsdf(read("conductor", "a perfect mirror, or a metal"), &[SPECULAR, MATERIAL, ETA, K, EXT_ETA]),
    bsdf(
        read(
            "roughconductor",
            "the same with GGX; Beckmann's microfacets are taken as GGX, with a warning",
        ),
        &[DISTRIBUTION, ALPHA, ALPHA_U, ALPHA_V, SPECULAR, MATERIAL, ETA, K, EXT_ETA, VISIBLE],
    ),
    bsdf(read("plastic", PLASTIC), &[DIFFUSE, SHINE, INT_IOR, EXT_IOR, NONLINEAR]),
    bsdf(told("roughplastic", PLASTIC), PLASTICS),
    bsdf(told("pplastic", PLASTIC), PLASTICS),
    bsdf(
        told("principled", "a metal, or a plastic over a Lambertian base"),
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
            told(
                "spec_trans",
                "above zero it is smooth glass, whose colour is that of light through a body",
            ),
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
        read("mask", "holes, by half where it is half-transparent"),
        &[
            read(
                "opacity",
                "a picture, with a warning where much of it is half-transparent, or a number, with a warning unless it is 0 \
                 or 1: it is opaque everywhere",
            ),
            INNER,
        ],
    ),
    bsdf(
        near(
            "bumpmap",
            "normals by the picture's heights, as if it was equally large all over a shape",
        ),
        &[INNER, BUMPS, read("scale", "a factor on the heights, which are in units of the scene")],
    ),
    bsdf(
        read(
            "normalmap",
            "normals in the shading frame; a picture that is not raw is taken as raw, with a warning",
        ),
        &[INNER, BUMPS],
    ),
    bsdf(read("null", "the surface is not there; as a lamp it is black"), &[]),
    bsdf(told("dielectric", CLEAR), &[INT_IOR, EXT_IOR, TRANSMITTED, REFLECTED]),
    bsdf(
        told("roughdielectric", "as dielectric: its roughness is left out"),
        &[
            INT_IOR,
            EXT_IOR,
            TRANSMITTED,
            REFLECTED,
            passed("alpha", COVERED),
            passed("alpha_u", COVERED),
            passed("alpha_v", COVERED),
            passed("distribution", COVERED),
            VISIBLE,
        ],
    ),
    bsdf(
        told("thindielectric", "a smooth pane of glass; a recovery masks its shapes"),
        &[INT_IOR, EXT_IOR, TRANSMITTED, REFLECTED],
    ),
    bsdf(
        told("principledthin", "a smooth pane of glass, or a Lambertian reflectance"),
        &[
            read("base_color", "a colour, a spectrum or a texture; of glass the mean"),
            read("eta", "1.5 by default"),
            told("spec_trans", "above zero it is glass, else what it scatters through is left out"),
            read("diff_trans", "the share that is left out"),
            read("roughness", "above zero the pane is still smooth, with a warning"),
            passed("anisotropic", COVERED),
            passed("spec_tint", COVERED),
            passed("sheen", COVERED),
            passed("sheen_tint", COVERED),
            passed("flatness", COVERED),
        ],
    ),
    bsdf(
        told(
            "phong",
            "of Mitsuba 0.5; a diffuse part and a lobe that is as high and as wide at normal incidence",
        ),
        &[
            read("exponent", "30 by default; the mean of a texture, with a warning"),
            DIFFUSE,
            SPECULAR,
        ],
    ),
    bsdf(read("coating", COAT), &[INNER, INT_IOR, EXT_IOR, SHINE]),
    bsdf(
        read("roughcoating", COAT),
        &[INNER, INT_IOR, EXT_IOR, SHINE, ALPHA, DISTRIBUTION, VISIBLE],
    ),
    bsdf(
        told("roughdiffuse", "of Mitsuba 0.5; diffuse, of the same albedo"),
        &[
            read("reflectance", "a colour, a spectrum or a texture"),
            read("alpha", ROUGHNESS),
            read("use_fast_approx", "which of Oren and Nayar's models the albedo is of"),
        ],
    ),
    bsdf(refused("others", "put a diffuse, conductor, plastic or principled in their place"), &[]),
    texture(
        read("bitmap", "a picture; see pictures"),
        &[
            FILE,
            read("raw", "its values as they are, not by their profile"),
            near(
                "filter_type",
                "bilinear; trilinear and ewa too; nearest: enlarged, so that little is interpolated",
            ),
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
];
