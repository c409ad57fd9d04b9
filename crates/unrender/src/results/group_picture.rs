//! The picture groups.png: every pixel in the colour of its group.

use super::report_folder;
use crate::Error;
use crate::engine::Recovered;
use std::path::Path;
use unrender_formats::picture;
use unrender_render::NOTHING;
use unrender_scene::Rgb;
use unrender_scene::color::linear_from_srgb;

/// The step in hue from one group to the next, as a share of the circle: the golden ratio's, with
/// which neighbours in the list are far apart for any number of groups.
const HUE_STEP: f32 = 0.618_034;
/// Lightness cycles through these steps, so that groups of nearly the same hue differ by it.
const LIGHTNESS: [f32; 3] = [0.85, 0.6, 0.72];
/// Paleness too, with one step per cycle of the lightness.
const PALENESS: [f32; 4] = [0.25, 0.1, 0.35, 0.18];

/// Writes the group map of a recovery into its folder, with the photograph's `number` in its name; returns its name
/// there.
pub(super) fn write(
    recovered: &Recovered,
    (folder, number): (&Path, &str),
) -> Result<String, Error> {
    let file = report_folder(&format!("groups{number}.png"));
    let picture = recovered.group_map.map(|&group| match group {
        NOTHING => Rgb::ZERO,
        group => color(group as usize),
    });
    picture::write_png_srgb(&folder.join(&file), &picture)?;
    Ok(file)
}

/// The colour of the group with this index, linear RGB; no two of the first thousand are equal in 8
/// bits.
pub(super) fn color(group: usize) -> Rgb {
    let hue = (group as f32 * HUE_STEP).fract() * 6.0;
    let value = LIGHTNESS[group % LIGHTNESS.len()];
    let pale = PALENESS[group / LIGHTNESS.len() % PALENESS.len()];
    let channel = |shift: f32| {
        let distance = ((hue + shift).rem_euclid(6.0) - 3.0).abs() - 1.0;
        value * (pale + (1.0 - pale) * distance.clamp(0.0, 1.0))
    };
    Rgb::new(channel(0.0), channel(4.0), channel(2.0)).map(linear_from_srgb)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn groups_have_colours_of_their_own() {
        let colors: BTreeSet<String> =
            (0..1000).map(|group| crate::results::hex(color(group))).collect();
        assert_eq!(colors.len(), 1000);
        assert!(!colors.contains("#000000"));
    }
}
