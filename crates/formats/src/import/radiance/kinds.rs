//! The kinds of primitives that Radiance knows, what each is, and how many numbers it has.

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
    name: &'static str,
    pub(super) sort: Sort,
    /// The numbers that it may have, if they are counted.
    pub(super) reals: &'static [usize],
    /// Whether it has words that mean something.
    pub(super) has_words: bool,
}

/// The kind called `name`.
pub(super) fn kind(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name)
}

const fn plain(name: &'static str, sort: Sort, reals: &'static [usize]) -> Kind {
    Kind { name, sort, reals, has_words: false }
}

const fn worded(name: &'static str, sort: Sort, reals: &'static [usize]) -> Kind {
    Kind { name, sort, reals, has_words: true }
}

/// All of them [Radiance 6.0, `src/common/otypes.h`].
const KINDS: &[Kind] = &[
    plain("polygon", Sort::Surface, &[]),
    plain("sphere", Sort::Surface, &[4]),
    plain("bubble", Sort::Surface, &[4]),
    plain("cylinder", Sort::Surface, &[7]),
    plain("tube", Sort::Surface, &[7]),
    plain("cone", Sort::Surface, &[8]),
    plain("cup", Sort::Surface, &[8]),
    plain("ring", Sort::Surface, &[8]),
    plain("source", Sort::Surface, &[4]),
    worded("mesh", Sort::Surface, &[0]),
    worded("instance", Sort::Surface, &[0]),
    worded("alias", Sort::Alias, &[]),
    plain("light", Sort::Lamp, &[3]),
    plain("glow", Sort::Lamp, &[4]),
    plain("spotlight", Sort::Lamp, &[7]),
    worded("illum", Sort::Lamp, &[3]),
    plain("plastic", Sort::Material, &[5]),
    plain("metal", Sort::Material, &[5]),
    plain("trans", Sort::Material, &[7]),
    worded("plastic2", Sort::Material, &[6]),
    worded("metal2", Sort::Material, &[6]),
    worded("trans2", Sort::Material, &[8]),
    worded("ashik2", Sort::Material, &[8]),
    worded("WGMDfunc", Sort::Material, &[]),
    worded("mirror", Sort::Material, &[3]),
    plain("glass", Sort::Material, &[3, 4]),
    plain("dielectric", Sort::Material, &[5]),
    plain("interface", Sort::Material, &[8]),
    worded("mist", Sort::Material, &[0, 3, 6, 7]),
    worded("antimatter", Sort::Material, &[0]),
    worded("plasfunc", Sort::Material, &[]),
    worded("metfunc", Sort::Material, &[]),
    worded("transfunc", Sort::Material, &[]),
    worded("plasdata", Sort::Material, &[]),
    worded("metdata", Sort::Material, &[]),
    worded("transdata", Sort::Material, &[]),
    worded("BRTDfunc", Sort::Material, &[]),
    worded("BSDF", Sort::Material, &[]),
    worded("aBSDF", Sort::Material, &[]),
    worded("sBSDF", Sort::Material, &[]),
    worded("prism1", Sort::Material, &[]),
    worded("prism2", Sort::Material, &[]),
    worded("colorfunc", Sort::Pattern, &[]),
    worded("brightfunc", Sort::Pattern, &[]),
    worded("colordata", Sort::Pattern, &[]),
    worded("brightdata", Sort::Pattern, &[]),
    worded("colorpict", Sort::Pattern, &[]),
    worded("colortext", Sort::Pattern, &[]),
    worded("brighttext", Sort::Pattern, &[]),
    worded("spectrum", Sort::Pattern, &[]),
    worded("specfile", Sort::Pattern, &[]),
    worded("specfunc", Sort::Pattern, &[]),
    worded("specdata", Sort::Pattern, &[]),
    worded("specpict", Sort::Pattern, &[]),
    worded("texfunc", Sort::Texture, &[]),
    worded("texdata", Sort::Texture, &[]),
    worded("mixfunc", Sort::Mixture, &[]),
    worded("mixdata", Sort::Mixture, &[]),
    worded("mixpict", Sort::Mixture, &[]),
    worded("mixtext", Sort::Mixture, &[]),
];
