//! Maps of MTL by which surfaces have normals and holes.

use super::material::{located, plain, without_options};
use super::mtl::{HEIGHTS, Map, Material};
use crate::input::Scope;
use crate::relief::{holes, is_normal_map, is_veil};
use crate::texels::{alpha, decode, mean};
use std::path::Path;
use std::sync::Arc;
use unrender_scene::color::luminance;
use unrender_scene::{Coverage, Detail, Image, Mapped, NormalMap, Rgb, Wrap};

const NO_NORMALS: &str = "a map of its normals is missing or has options that are not read: the surface is taken as smooth \
                          as its mesh";
const NO_HOLES: &str = "a map of its transparency is missing or has options that are not read: the surface is taken as \
                        opaque";
const LAMP: &str = "it is a lamp with a map of its transparency, which is taken as opaque";
const VEIL: &str = "half-transparent places of its map_d are taken as there or not, by half";

/// What was not read of a material, each with its line.
pub(super) type Unread = Vec<(&'static str, usize)>;

/// The detail of surfaces of the material `mtl` of `file`.
pub(super) fn detail(
    (mtl, file): (&Material, &str),
    (scope, folder): (&Scope, &Path),
    unread: &mut Unread,
) -> Result<Detail, String> {
    let place = (scope, folder, file);
    let mut normals = None;
    if let Some(map) = &mtl.normals {
        normals = self::normals(map, place, false)?;
        if normals.is_none() {
            unread.push((NO_NORMALS, map.line));
        }
    }
    if let Some(map) = &mtl.bump {
        // Many programs write normal maps as those of heights.
        let found = self::normals(map, place, true)?;
        if found.is_none() {
            unread.push((HEIGHTS, map.line));
        }
        normals = normals.or(found);
    }
    let coverage = match &mtl.map_d {
        Some(map) if mtl.ke.is_some_and(|ke| ke.max_element() > 0.0) => {
            unread.push((LAMP, map.line));
            None
        }
        Some(map) => coverage(map, place, unread)?,
        None => None,
    };
    Ok(Detail { normals, coverage })
}

/// The bytes of a map's picture; none if it is missing or has options that change it. If it `may_be_heights` it is not
/// noted as missing.
fn bytes(
    map: &Map,
    (scope, folder, file): (&Scope, &Path, &str),
    may_be_heights: bool,
) -> Result<Option<Vec<u8>>, String> {
    let Ok(name) = without_options(&map.words) else { return Ok(None) };
    let short = || located(folder, file, super::text::without_comment(name));
    let there = located(folder, file, name).or_else(short);
    // What is most often not read anyway need not be there.
    if there.is_none() && may_be_heights {
        return Ok(None);
    }
    let path = there.unwrap_or_else(|| plain(name));
    let Ok(Some(path)) = scope.find(folder, &path) else { return Ok(None) };
    scope.read(&path).map(Some)
}

fn repeated<T>(image: Image<T>) -> Mapped<T> {
    Mapped { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat }
}

/// The normals of a map; none if it is not there or, as it may be, of heights.
fn normals(
    map: &Map,
    place: (&Scope, &Path, &str),
    may_be_heights: bool,
) -> Result<Option<Arc<NormalMap>>, String> {
    let Some(bytes) = bytes(map, place, may_be_heights)? else { return Ok(None) };
    let image: Image<Rgb> = match decode(place.0, &bytes) {
        Err(_) if may_be_heights => return Ok(None),
        decoded => decoded?,
    };
    if may_be_heights && !is_normal_map(mean(&image)) {
        return Ok(None);
    }
    let normals = NormalMap::decoded(&repeated(image), strength(&map.words), true);
    Ok(Some(Arc::new(normals)))
}

/// The number of the option `-bm`: how much a map lifts.
fn strength(words: &str) -> f32 {
    let mut words = words.split_ascii_whitespace().skip_while(|word| *word != "-bm").skip(1);
    words.next().and_then(|word| word.parse().ok()).filter(|by: &f32| by.is_finite()).unwrap_or(1.0)
}

/// The holes of a map: by its alpha, or by its luminance if it has none.
fn coverage(
    map: &Map,
    place: (&Scope, &Path, &str),
    unread: &mut Unread,
) -> Result<Option<Arc<Coverage>>, String> {
    let Some(bytes) = bytes(map, place, false)? else {
        unread.push((NO_HOLES, map.line));
        return Ok(None);
    };
    let image = match alpha(place.0, &bytes)? {
        Some(alpha) => alpha,
        None => decode(place.0, &bytes)?.map(|texel| luminance(*texel)),
    };
    if is_veil(&image) {
        unread.push((VEIL, map.line));
    }
    Ok(holes(repeated(image)))
}

#[cfg(test)]
mod tests {
    use super::strength;

    #[test]
    fn the_strength_is_that_of_its_option() {
        assert_eq!(strength("-s 1 1 1 -bm 0.5 -clamp off a b.png"), 0.5);
        assert_eq!(["b.png", "-bm x.png", "-bm inf x.png"].map(strength), [1.0; 3]);
    }
}
