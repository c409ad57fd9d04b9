//! Textures of glTF files: a picture and how it goes on beyond its edges.

use super::Problem;
use super::source::{Source, get};
use crate::texels::{self, decode};
use unrender_scene::{Image, Mapped, Rgb, Wrap};

/// The picture of a texture.
pub(super) enum Encoded {
    /// Its texels as encoded, 0 to 1, and how it goes on beyond its edges.
    Texels(Image<Rgb>, Wrap, Wrap),
    /// Its file is missing.
    Missing,
    /// It has none in a format of plain glTF.
    Other,
}

/// The picture of glTF texture `index`.
pub(super) fn encoded(source: &Source, index: usize) -> Result<Encoded, Problem> {
    let texture = get(&source.document.textures, index, "texture")?;
    let Some(image) = texture.source else { return Ok(Encoded::Other) };
    let Some(bytes) = source.image(image)? else { return Ok(Encoded::Missing) };
    let texels =
        decode(source.scope(), &bytes).map_err(|error| format!("image {image} {error}"))?;
    let (u, v) = wraps(source, texture.sampler)?;
    Ok(Encoded::Texels(texels, u, v))
}

/// The alpha of glTF texture `index`, 0 to 1; none if it is one everywhere, or not there.
pub(super) fn alpha(source: &Source, index: usize) -> Result<Option<Mapped<f32>>, Problem> {
    let texture = get(&source.document.textures, index, "texture")?;
    let Some(image) = texture.source else { return Ok(None) };
    let Some(bytes) = source.image(image)? else { return Ok(None) };
    let alpha = texels::alpha(source.scope(), &bytes);
    let alpha = alpha.map_err(|error| format!("image {image} {error}"))?;
    let (wrap_u, wrap_v) = wraps(source, texture.sampler)?;
    Ok(alpha.map(|image| Mapped { image, wrap_u, wrap_v }))
}

/// How textures with this sampler go on beyond their edges.
fn wraps(source: &Source, sampler: Option<usize>) -> Result<(Wrap, Wrap), Problem> {
    let Some(sampler) = sampler else { return Ok((Wrap::Repeat, Wrap::Repeat)) };
    let sampler = get(&source.document.samplers, sampler, "sampler")?;
    Ok((wrap(sampler.wrap_s)?, wrap(sampler.wrap_t)?))
}

/// Whether glTF texture `index` asks for its nearest texel.
pub(super) fn is_in_blocks(source: &Source, index: usize) -> bool {
    let document = &source.document;
    let sampler = document.textures.get(index).and_then(|texture| texture.sampler);
    let sampler = sampler.and_then(|sampler| document.samplers.get(sampler));
    sampler.is_some_and(|sampler| sampler.mag_filter == Some(NEAREST))
}

const NEAREST: u32 = 9728;
const REPEAT: u32 = 10497;
const MIRRORED_REPEAT: u32 = 33648;
const CLAMP_TO_EDGE: u32 = 33071;

/// The number of glTF's samplers for `wrap`.
pub(super) fn wrap_code(wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => REPEAT,
        Wrap::MirroredRepeat => MIRRORED_REPEAT,
        Wrap::ClampToEdge => CLAMP_TO_EDGE,
    }
}

fn wrap(code: Option<u32>) -> Result<Wrap, Problem> {
    match code {
        None | Some(REPEAT) => Ok(Wrap::Repeat),
        Some(MIRRORED_REPEAT) => Ok(Wrap::MirroredRepeat),
        Some(CLAMP_TO_EDGE) => Ok(Wrap::ClampToEdge),
        Some(other) => Err(format!("has a sampler that wraps by {other}; export the scene again")),
    }
}
