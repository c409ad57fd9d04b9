//! A material of MTL as a group.

use super::mtl;
use crate::input::Scope;
use crate::texels;
use std::path::Path;
use std::sync::Arc;
use unrender_scene::{Group, Material, Rgb, RgbImage, Texture, Warnings, Wrap};

/// The reflectance of surfaces that have no material, or one that states none, and of a map that is missing.
pub(super) const ASSUMED_RHO_D: f32 = 0.5;

/// The group of surfaces whose reflectance no file states.
pub(super) fn unstated(name: &str) -> Group {
    let material = Material::diffuse(Rgb::splat(ASSUMED_RHO_D));
    Group { name: name.into(), material, emission: Rgb::ZERO }
}

/// The group of the material `mtl`, which stands in `file` as the OBJ in `folder` names it.
pub(super) fn group(
    name: &str,
    (mtl, file): (&mtl::Material, &str),
    (scope, folder): (&Scope, &Path),
    warnings: &mut Warnings,
) -> Result<Group, String> {
    let rgb = |value: Option<Rgb>, key: &str| {
        let rgb = value.unwrap_or_default();
        if rgb.is_finite() && rgb.min_element() >= 0.0 {
            return Ok(rgb);
        }
        Err(format!("material \"{name}\" has a {key} that is no colour; repair \"{file}\""))
    };
    let mut reflectance = |value: Option<Rgb>, key: &str| {
        let stated = rgb(value, key)?;
        if stated.max_element() > 1.0 {
            warnings.push(format!(
                "material \"{name}\": its {key} lies outside 0 to 1; it was clamped."
            ));
        }
        Ok::<Rgb, String>(stated.min(Rgb::ONE))
    };
    let has_texture = mtl.map_kd.is_some();
    let kd = reflectance(mtl.kd.or(has_texture.then_some(Rgb::ONE)), "Kd")?;
    let ks = reflectance(mtl.ks, "Ks")?;
    let emission = rgb(mtl.ke, "Ke")?;
    let is_glossy = ks.max_element() > 0.0 && !matches!(mtl.illum, Some(0 | 1));
    let states_nothing = mtl.kd.is_none() && !has_texture && !is_glossy;
    if states_nothing && emission == Rgb::ZERO {
        warnings.push(format!(
            "material \"{name}\" states no reflectance; it was taken as diffuse with \
             rho_d = {ASSUMED_RHO_D}."
        ));
        return Ok(unstated(name));
    }
    let mut material = if is_glossy {
        let shininess = mtl.ns.unwrap_or(0.0).max(0.0);
        Material::isotropic(kd, ks, (2.0 / (shininess + 2.0)).sqrt())
    } else {
        Material::diffuse(kd)
    };
    if let Some(words) = &mtl.map_kd {
        let image = picture(scope, folder, file, words)
            .map_err(|problem| format!("material \"{name}\": its map_Kd \"{words}\" {problem}"))?;
        let image = image.unwrap_or_else(|| {
            warnings.push(format!(
                "material \"{name}\": its map_Kd \"{words}\" is missing; grey was taken for it"
            ));
            RgbImage::new(1, 1, vec![Rgb::splat(ASSUMED_RHO_D)])
        });
        if kd == Rgb::ZERO {
            warnings.push(format!(
                "material \"{name}\": its Kd is 0, which makes its map_Kd black; state Kd 1 1 1 if \
                 the map is to count."
            ));
        }
        let image = image.map(|texel| *texel * kd);
        material.rho_d = texels::mean(&image);
        let wrap = Wrap::Repeat;
        material.texture = Some(Arc::new(Texture { image, wrap_u: wrap, wrap_v: wrap }));
    }
    Ok(Group { name: name.into(), material, emission })
}

/// The texels of a map: `words` are its options and its file. None if that is missing.
fn picture(
    scope: &Scope,
    folder: &Path,
    mtl: &str,
    words: &str,
) -> Result<Option<RgbImage>, String> {
    let name = without_options(words)?;
    let whole = located(folder, mtl, name);
    let short = || located(folder, mtl, super::text::without_comment(name));
    let path = whole.or_else(short).unwrap_or_else(|| plain(name));
    let Some(path) = scope.find(folder, &path)? else { return Ok(None) };
    let bytes = scope.read(&path)?;
    Ok(Some(texels::linear(&texels::decode(scope, &bytes)?)))
}

/// A name as a path: without quotes, its folders apart by slashes.
pub(super) fn plain(name: &str) -> String {
    name.trim_matches('"').replace('\\', "/")
}

/// The path of the file called `name`, seen from `folder`, if it exists. Names are relative to the
/// folder of the MTL file; some programs write them relative to that of the OBJ, which is accepted,
/// too.
pub(super) fn located(folder: &Path, mtl: &str, name: &str) -> Option<String> {
    let within = Path::new(mtl).parent().unwrap_or(Path::new(""));
    let there = within.join(plain(name)).to_string_lossy().into_owned();
    [there, plain(name)].into_iter().find(|path| folder.join(path).is_file())
}

/// The name of a map's file, after its options, which must not change anything.
pub(super) fn without_options(words: &str) -> Result<&str, String> {
    let mut rest = words;
    while rest.starts_with('-') {
        let (option, behind) = split(rest);
        // The number of values of the option, and the default of each.
        let (most, default) = match option {
            "-blendu" | "-blendv" | "-cc" | "-clamp" => (0, None),
            "-bm" | "-boost" | "-texres" => (1, None),
            "-mm" => (2, Some([0.0, 1.0, 1.0])),
            "-o" | "-t" => (3, Some([0.0; 3])),
            "-s" => (3, Some([1.0; 3])),
            _ => return Err(format!("has the option {option}, which is not known; remove it")),
        };
        rest = behind;
        let mut is_neutral = true;
        if most == 0 {
            let (value, behind) = split(rest);
            // Options for the blending of texels may have any value; those that change colours or
            // clamp may not.
            is_neutral = value == "off" || option.starts_with("-blend");
            rest = behind;
        }
        for k in 0..most {
            let (word, behind) = split(rest);
            let Ok(number) = word.parse::<f32>() else { break };
            is_neutral &= default.is_none_or(|default: [f32; 3]| default[k] == number);
            rest = behind;
        }
        if !is_neutral {
            return Err(format!(
                "has the option {option}, which is not read; apply it to the picture or the texture \
                 coordinates and remove it"
            ));
        }
    }
    Ok(rest)
}

/// The first word, and what follows.
fn split(text: &str) -> (&str, &str) {
    let end = text.find(|c: char| c.is_ascii_whitespace()).unwrap_or(text.len());
    (&text[..end], text[end..].trim_ascii_start())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_that_change_nothing_are_passed_over() {
        let name = "my wood.png";
        for options in ["", "-s 1 1 1 -o 0.0 0 0 ", "-clamp off ", "-blendu on -mm 0 1 ", "-bm 2 "]
        {
            assert_eq!(without_options(&[options, name].concat()), Ok(name));
        }
        for options in ["-s 2 2 1", "-o 0.5", "-clamp on", "-mm 0 2", "-imfchan r", "-"] {
            assert!(without_options(&format!("{options} 1.png")).is_err(), "{options}");
        }
    }
}
