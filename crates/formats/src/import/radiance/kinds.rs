//! The kinds of primitives that Radiance knows, what each is, how it is taken, and how many numbers it has.

use crate::entry::{Entry, near, read, refused, told};

/// What a primitive is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sort {
    /// Something with a place, or a source of light from far away.
    Surface,
    /// A material that shines.
    Lamp,
    /// A material that does not shine.
    Material,
    /// A change of colour over a surface.
    Pattern,
    /// A change of the normals over a surface.
    Texture,
    /// Two modifiers in one.
    Mixture,
    /// Another name.
    Alias,
}

/// A kind of primitive.
pub(super) struct Kind {
    /// Its name, and how it is taken; for those warned of, the end of the warning.
    pub(super) entry: Entry,
    pub(super) sort: Sort,
    /// The numbers that it may have, if they are counted.
    pub(super) reals: &'static [usize],
    /// Whether its words are read.
    pub(super) has_words: bool,
}

/// The kind called `name`.
pub(super) fn kind(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.entry.name == name)
}

/// How the kind called `name` is taken.
pub(super) fn entry(name: &str) -> Option<&'static Entry> {
    kind(name).map(|kind| &kind.entry)
}

/// The rows of all kinds.
pub(super) fn entries() -> impl Iterator<Item = &'static Entry> {
    KINDS.iter().map(|kind| &kind.entry)
}

const fn plain(sort: Sort, reals: &'static [usize], entry: Entry) -> Kind {
    Kind { entry, sort, reals, has_words: false }
}

const fn worded(sort: Sort, reals: &'static [usize], entry: Entry) -> Kind {
    Kind { entry, sort, reals, has_words: true }
}

const ROUND: &str = "a smooth mesh of triangles";
const DIRECTED: &str =
    "a diffuse part and Ward's lobe of two roughnesses; their direction, if it is three numbers";
const THROUGH: &str = "lets light through, which is left out";
const HIGHLIGHTS: &str = "has highlights that are not read; only its diffuse part was taken";
/// The end of the warning of materials that are not read at all.
pub(super) const UNKNOWN: &str = "is not known; it was taken as diffuse with rho_d = 0.5";
/// The end of the warning of patterns that are not read.
pub(super) const NO_PATTERN: &str = "is not read; what it changes was left as it is";
/// The end of the warning of textures, which change normals.
pub(super) const NO_TEXTURE: &str = "is not read; its surfaces are smooth here";
/// The end of the warning of mixtures that are not the same everywhere.
pub(super) const NO_MIXTURE: &str =
    "mixes by a function that is not read; half of each was taken, everywhere";

/// All of them [Radiance 6.0, `src/common/otypes.h`].
const KINDS: &[Kind] = &[
    plain(Sort::Surface, &[], read("polygon", "triangles; convex or not")),
    plain(Sort::Surface, &[4], near("sphere", ROUND)),
    plain(Sort::Surface, &[4], near("bubble", ROUND)),
    plain(Sort::Surface, &[7], near("cylinder", ROUND)),
    plain(Sort::Surface, &[7], near("tube", ROUND)),
    plain(Sort::Surface, &[8], near("cone", ROUND)),
    plain(Sort::Surface, &[8], near("cup", ROUND)),
    plain(Sort::Surface, &[8], near("ring", "a flat mesh of triangles")),
    plain(
        Sort::Surface,
        &[4],
        near(
            "source",
            "a light of one direction if up to 5 degrees wide; wider ones are in the environment",
        ),
    ),
    worded(
        Sort::Surface,
        &[0],
        read("mesh", "the OBJ beside it from which it was compiled, moved as it says"),
    ),
    worded(
        Sort::Surface,
        &[0],
        refused(
            "instance",
            "is an octree, which is not read; put the scene from which it was made in its place, by !xform",
        ),
    ),
    worded(
        Sort::Alias,
        &[],
        read("alias", "another name for a modifier, with inherit or another modifier"),
    ),
    plain(
        Sort::Lamp,
        &[3],
        read("light", "a black surface that emits; light from far away on a source"),
    ),
    plain(Sort::Lamp, &[4], read("glow", "as light, if its radius is not below zero")),
    plain(
        Sort::Lamp,
        &[7],
        told(
            "spotlight",
            "is taken as a spot light without a surface, as bright as in Radiance where its axis meets something",
        ),
    ),
    worded(
        Sort::Lamp,
        &[3],
        told("illum", "gives light as light does; the lamp is seen here, so mask its pixels"),
    ),
    plain(Sort::Material, &[5], read("plastic", "a diffuse part and a white lobe of Ward's")),
    plain(
        Sort::Material,
        &[5],
        read("metal", "a diffuse part and a lobe of Ward's of the same colour"),
    ),
    plain(Sort::Material, &[7], told("trans", THROUGH)),
    worded(Sort::Material, &[6], read("plastic2", DIRECTED)),
    worded(Sort::Material, &[6], read("metal2", DIRECTED)),
    worded(Sort::Material, &[8], told("trans2", THROUGH)),
    worded(
        Sort::Material,
        &[8],
        told("ashik2", "has the lobe of Ashikhmin and Shirley; one of the same width was taken"),
    ),
    worded(
        Sort::Material,
        &[],
        read(
            "WGMDfunc",
            "both parts with their colours; a warning for expressions that are not numbers",
        ),
    ),
    worded(
        Sort::Material,
        &[3],
        read(
            "mirror",
            "a perfect mirror; if it names another material, it is taken as that one, with a warning",
        ),
    ),
    plain(
        Sort::Material,
        &[3, 4],
        told("glass", "a pane of that transmissivity, smooth, and not recovered"),
    ),
    plain(
        Sort::Material,
        &[5],
        told("dielectric", "smooth glass that absorbs, whose front is outside; not recovered"),
    ),
    plain(Sort::Material, &[8], told("interface", UNKNOWN)),
    worded(
        Sort::Material,
        &[0, 3, 6, 7],
        told("mist", "is a volume of mist, which is not known here; it was left out"),
    ),
    worded(
        Sort::Material,
        &[0],
        told("antimatter", "was left out; what it cuts away is still there"),
    ),
    worded(Sort::Material, &[], told("plasfunc", HIGHLIGHTS)),
    worded(Sort::Material, &[], told("metfunc", HIGHLIGHTS)),
    worded(Sort::Material, &[], told("transfunc", HIGHLIGHTS)),
    worded(Sort::Material, &[], told("plasdata", HIGHLIGHTS)),
    worded(Sort::Material, &[], told("metdata", HIGHLIGHTS)),
    worded(Sort::Material, &[], told("transdata", HIGHLIGHTS)),
    worded(Sort::Material, &[], told("BRTDfunc", HIGHLIGHTS)),
    worded(Sort::Material, &[], told("BSDF", UNKNOWN)),
    worded(Sort::Material, &[], told("aBSDF", UNKNOWN)),
    worded(Sort::Material, &[], told("sBSDF", UNKNOWN)),
    worded(Sort::Material, &[], told("prism1", UNKNOWN)),
    worded(Sort::Material, &[], told("prism2", UNKNOWN)),
    worded(Sort::Pattern, &[], read("colorfunc", "a colour, where its words are numbers")),
    worded(
        Sort::Pattern,
        &[],
        read(
            "brightfunc",
            "a factor, where its word is a number; the skies of gensky and gendaylit",
        ),
    ),
    worded(Sort::Pattern, &[], told("colordata", NO_PATTERN)),
    worded(Sort::Pattern, &[], told("brightdata", NO_PATTERN)),
    worded(
        Sort::Pattern,
        &[],
        read(
            "colorpict",
            "a square picture over Lu and Lv of a mesh, its numbers as stored, whatever its \
             EXPOSURE; on a source a panorama as unrender exports it; the mean of others, with a warning",
        ),
    ),
    worded(Sort::Pattern, &[], told("colortext", NO_PATTERN)),
    worded(Sort::Pattern, &[], told("brighttext", NO_PATTERN)),
    worded(Sort::Pattern, &[], told("spectrum", NO_PATTERN)),
    worded(Sort::Pattern, &[], told("specfile", NO_PATTERN)),
    worded(Sort::Pattern, &[], told("specfunc", NO_PATTERN)),
    worded(Sort::Pattern, &[], told("specdata", NO_PATTERN)),
    worded(Sort::Pattern, &[], told("specpict", NO_PATTERN)),
    worded(Sort::Texture, &[], told("texfunc", NO_TEXTURE)),
    worded(Sort::Texture, &[], told("texdata", NO_TEXTURE)),
    worded(
        Sort::Mixture,
        &[],
        read("mixfunc", "a share of each, where it is a number, of materials of one roughness"),
    ),
    worded(Sort::Mixture, &[], told("mixdata", NO_MIXTURE)),
    worded(Sort::Mixture, &[], told("mixpict", NO_MIXTURE)),
    worded(Sort::Mixture, &[], told("mixtext", NO_MIXTURE)),
];

/// Cases that are warned of or refused, of kinds that are read.
pub(super) const CASES: [Entry; 8] = [
    told("void on a surface", "a surface without a material is invisible; it was left out"),
    told("mesh without its OBJ", "was left out: there is no OBJ of its name beside it"),
    told("colorfunc of an expression", NO_PATTERN),
    told("brightfunc of an expression", NO_PATTERN),
    told("mixfunc of an expression", NO_MIXTURE),
    told(
        "glow of a radius below zero",
        "is visible but gives no light; here it is black, so mask its pixels",
    ),
    refused(
        "lamp behind a pattern",
        "is as bright as the pattern says, unless that is a number, a sky or a panorama of an export",
    ),
    refused("mixfunc of a lamp", "has a lamp in it, whose brightness is not understood"),
];
