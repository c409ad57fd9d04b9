//! Patterns: constants, pictures over the texture coordinates of a mesh, skies, panoramas.

use super::primitives::Primitive;
use super::sky::{Panorama, Sky};
use crate::input::Scope;
use crate::{picture, texels};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use unrender_scene::{Depth, Environment, Image, Rgb, Texture, Warnings, Wrap};

/// What a pattern is.
pub(super) enum Pattern {
    /// The same everywhere.
    Constant(Rgb),
    /// A picture laid over texture coordinates.
    Picture(Arc<Texture>),
    /// A picture laid out in another way; its mean colour.
    Mean(Rgb),
    /// The brightness of a sky.
    Sky(Sky),
    /// The light from all around, as our export writes it.
    Panorama(Panorama),
    /// Something else.
    Unread,
}

/// Pictures that were read, by the words that name them, so that many patterns share one.
#[derive(Default)]
pub(super) struct Pictures(BTreeMap<(String, bool, [String; 2]), Arc<Texture>>);

impl Pictures {
    /// What the pattern `p` is.
    pub(super) fn pattern(
        &mut self,
        p: &Primitive,
        (scope, folder): (&Scope, &Path),
        warnings: &mut Warnings,
    ) -> Result<Pattern, String> {
        let constant = |at: usize| {
            let value = p.strings.get(at).and_then(|word| constant(word, &p.reals));
            value.filter(|value| *value >= 0.0)
        };
        let found = match p.kind.as_str() {
            "colorfunc" => match [0, 1, 2].map(constant) {
                [Some(r), Some(g), Some(b)] => Pattern::Constant(Rgb::new(r, g, b)),
                _ => Pattern::Unread,
            },
            "brightfunc" => constant(0)
                .map(|value| Pattern::Constant(Rgb::splat(value)))
                .or_else(|| Sky::of(p).map(Pattern::Sky))
                .unwrap_or(Pattern::Unread),
            "colorpict" => self.picture(p, (scope, folder), warnings)?,
            _ => Pattern::Unread,
        };
        Ok(found)
    }

    fn picture(
        &mut self,
        p: &Primitive,
        (scope, folder): (&Scope, &Path),
        warnings: &mut Warnings,
    ) -> Result<Pattern, String> {
        let name = p.strings.get(3).ok_or("a colorpict names no picture")?;
        let [u, v] = [5, 6].map(|at| p.strings.get(at).cloned().unwrap_or_default());
        let turn = turn(&u);
        let is_ours = turn.is_some() || is_ours(&u) && is_ours(&v);
        let key = (name.clone(), is_ours, [u.clone(), v.clone()]);
        let texture = match self.0.get(&key) {
            Some(texture) => texture.clone(),
            None => {
                let path = scope.beside(folder, name).map_err(|p| format!("\"{name}\" {p}"))?;
                let read = Arc::new(texture(scope, &path, (is_ours, [&u, &v]), warnings)?);
                self.0.insert(key, read.clone());
                read
            }
        };
        if let Some(turn) = turn {
            let environment = Environment::new(texture.image.clone(), turn);
            let found = environment.map_err(|error| format!("\"{name}\": {error}"))?;
            return Ok(Pattern::Panorama(Arc::new(found)));
        }
        let is_square = texture.image.width() == texture.image.height();
        let is_plain = |word: &str, name: &str| word == name || word == format!("frac({name})");
        let is_laid = is_ours || is_square && is_plain(&u, "Lu") && is_plain(&v, "Lv");
        if is_laid {
            return Ok(Pattern::Picture(texture));
        }
        Ok(Pattern::Mean(texels::mean(&texture.image)))
    }
}

/// A word that is a number, or a numbered argument.
pub(super) fn constant(word: &str, reals: &[f64]) -> Option<f32> {
    let argument = word.strip_prefix('A').and_then(|k| k.parse::<usize>().ok());
    let value = match argument {
        Some(k) => reals.get(k.checked_sub(1)?).copied(),
        None => word.parse::<f64>().ok(),
    };
    value.map(|value| value as f32).filter(|value| value.is_finite())
}

/// Whether `place` is an expression as our export writes them.
fn is_ours(place: &str) -> bool {
    place.contains("+.5)*") && (place.contains("Lu") || place.contains("Lv"))
}

/// How far a panorama is turned, radians, if `place` is the expression of its columns as our export writes them.
fn turn(place: &str) -> Option<f32> {
    let (turn, _) = place.strip_prefix("(frac(.5+(atan2(Dx,-Dz)+(")?.split_once("))/")?;
    turn.parse().ok()
}

/// The picture of a `colorpict`. Our export adds the texels around it, and the expression of its
/// place states how it continues.
fn texture(
    scope: &Scope,
    path: &Path,
    (is_ours, places): (bool, [&str; 2]),
    warnings: &mut Warnings,
) -> Result<Texture, String> {
    let (read, told) = picture::read_in(scope, path).map_err(|error| error.to_string())?;
    warnings.extend(told);
    // Patterns take the numbers as stored, whatever factor the header states.
    let bytes = scope.read(path)?;
    let factor = picture::hdr_header_of(&bytes).map_or(Rgb::ONE, |header| header.factor.into());
    let numbers = if read.depth == Depth::Float { read.values } else { read.to_linear() };
    let mut image = numbers.map(|texel| middle_of_step(*texel * factor));
    if !is_ours {
        image = with_texels_at_edges(scope, &image)?;
    } else if image.width() > 2 && image.height() > 2 {
        let framed = image;
        image = Image::from_fn(framed.width() - 2, framed.height() - 2, |x, y| {
            *framed.at(x + 1, y + 1)
        });
    }
    let wrap = |place: &str| match place {
        _ if place.contains("abs(") => Wrap::MirroredRepeat,
        _ if place.contains("if(") => Wrap::ClampToEdge,
        _ => Wrap::Repeat,
    };
    let [wrap_u, wrap_v] = places.map(wrap);
    Ok(Texture { image, wrap_u, wrap_v })
}

/// The picture in finer texels, as Radiance interpolates it: the centres of its outermost texels are at its edges, not
/// half a texel inside.
fn with_texels_at_edges(scope: &Scope, image: &Image<Rgb>) -> Result<Image<Rgb>, String> {
    /// Texels of the finer picture along its longer side; in larger pictures half a texel is little.
    const SIDE: usize = 1024;
    let (width, height) = (image.width(), image.height());
    let times = (SIDE / width.max(height).max(1)).clamp(1, 32);
    scope.charge((times * times * width * height * size_of::<Rgb>()) as u64)?;
    let place = |at: usize, count: usize| {
        let place = (at as f32 + 0.5) / (times * count) as f32 * (count - 1) as f32;
        let first = (place as usize).min(count.saturating_sub(2));
        (first, (first + 1).min(count - 1), place - first as f32)
    };
    Ok(Image::from_fn(times * width, times * height, |x, y| {
        let ((left, right, u), (top, bottom, v)) = (place(x, width), place(y, height));
        let row = |y: usize| image.at(left, y).lerp(*image.at(right, y), u);
        row(top).lerp(row(bottom), v)
    }))
}

/// Radiance decodes the eight bits of a channel to the middle of their quantisation step, picture
/// readers to its lower end. The largest channel has a mantissa of 128 to 255 steps.
fn middle_of_step(texel: Rgb) -> Rgb {
    let largest = texel.max_element();
    if largest <= 0.0 {
        return texel;
    }
    texel + Rgb::splat(0.5 * (largest.log2().floor() - 7.0).exp2())
}
