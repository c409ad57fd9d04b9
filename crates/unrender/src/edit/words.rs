//! Edits in words, for the gallery.

use std::collections::BTreeMap;
use unrender_restage::Edit;
use unrender_restage::insert::{Insert, Place};
use unrender_restage::light::{Alter, LightChange, LightEdit, Photometric, PhotometricUnit};
use unrender_restage::remove::{Bearer, Remove};
use unrender_restage::repaint::{Paint, Repaint};
use unrender_scene::Rgb;
use unrender_scene::color::srgb_from_linear;

/// A sentence for each edit.
pub(super) fn sentences(edits: &[Edit]) -> Vec<String> {
    edits.iter().map(sentence).collect()
}

fn sentence(edit: &Edit) -> String {
    match edit {
        Edit::Remove(remove) => removed(remove),
        Edit::Repaint(Repaint { group, paint }) => {
            format!("Repainted {group}: {}.", painted(paint))
        }
        Edit::Light(light) => lit(light),
        Edit::Surround(surround) => match surround.environment {
            Some(_) => "Replaced the environment.".to_owned(),
            None => "Removed the environment.".to_owned(),
        },
        Edit::Insert(insert) => inserted(insert),
    }
}

fn removed(Remove { name, what }: &Remove) -> String {
    match what {
        Bearer::Any => format!("Removed {name}."),
        Bearer::Object => format!("Removed the object {name}."),
        Bearer::Group => format!("Removed the group {name} with all its objects."),
    }
}

/// The new parameters, by name.
fn painted(paint: &Paint) -> String {
    let colors = [("rho_d", paint.rho_d), ("rho_s", paint.rho_s)];
    let colors = colors.into_iter().filter_map(|(name, rho)| Some((name, color(rho?))));
    let numbers = [("alpha_x", paint.alpha_x), ("alpha_y", paint.alpha_y)];
    let numbers = numbers.into_iter().filter_map(|(name, value)| Some((name, value?.to_string())));
    let mut parts: Vec<String> =
        colors.chain(numbers).map(|(name, value)| format!("{name} = {value}")).collect();
    if let Some(theta) = paint.theta_rad {
        parts.push(format!("theta = {:.1} deg", theta.to_degrees()));
    }
    if let Some(tint) = paint.tint {
        parts.push(format!("tinted by {}", values(tint)));
    }
    if paint.texture.is_some() {
        parts.push("with a texture".to_owned());
    }
    if parts.is_empty() { "as it was".to_owned() } else { parts.join(", ") }
}

/// A reflectance as linear values and as sRGB.
fn color(rho: Rgb) -> String {
    let [r, g, b] = rho.to_array().map(|v| (255.0 * srgb_from_linear(v)).round() as u8);
    format!("{} (sRGB #{r:02x}{g:02x}{b:02x})", values(rho))
}

fn values(of: Rgb) -> String {
    let [r, g, b] = of.to_array();
    format!("[{r}, {g}, {b}]")
}

fn lit(LightEdit { name, change, photometric }: &LightEdit) -> String {
    match change {
        LightChange::Remove => format!("Removed the light {name}."),
        LightChange::Add(..) => format!("Added the light {name}."),
        LightChange::Alter(alter) if alter.scale == Rgb::ZERO => {
            format!("Switched the light {name} off.")
        }
        LightChange::Alter(alter) => {
            format!("Changed the light {name}: {}.", altered(alter, photometric.as_ref()))
        }
    }
}

fn altered(alter: &Alter, photometric: Option<&Photometric>) -> String {
    let mut parts = Vec::new();
    if alter.profile.is_some() {
        parts.push("a photometric profile".to_owned());
    }
    if let Some(Photometric { unit, value, scale }) = photometric {
        let unit = match unit {
            PhotometricUnit::Lumens => "lm",
            PhotometricUnit::Candela => "cd",
            PhotometricUnit::Lux => "lx",
        };
        let times =
            if *scale == Rgb::ONE { String::new() } else { format!(" times {}", values(*scale)) };
        parts.push(format!("{value} {unit}{times}"));
    }
    if let Some(strength) = alter.strength {
        parts.push(format!("strength {}", values(strength)));
    }
    if alter.scale != Rgb::ONE {
        let is_grey = alter.scale == Rgb::splat(alter.scale.x);
        let factor = if is_grey { alter.scale.x.to_string() } else { values(alter.scale) };
        parts.push(format!("{factor} times as bright"));
    }
    if alter.shift != glam::Vec3::ZERO {
        let [x, y, z] = alter.shift.to_array();
        parts.push(format!("moved by [{x}, {y}, {z}] m"));
    }
    if alter.direction.is_some() || alter.turn_rad.is_some() {
        parts.push("turned".to_owned());
    }
    if parts.is_empty() { "as it was".to_owned() } else { parts.join(", ") }
}

fn inserted(insert: &Insert) -> String {
    let place = match &insert.place {
        Place::At(at) => format!("at [{}, {}, {}] m", at.x, at.y, at.z),
        Place::Onto { group, .. } | Place::Seen { group: Some(group), .. } => format!("on {group}"),
        Place::Seen { group: None, .. } => "where the photograph shows its place".to_owned(),
    };
    let scale =
        if insert.scale == 1.0 { String::new() } else { format!(", scaled by {}", insert.scale) };
    let paints: BTreeMap<&str, String> = insert
        .paint
        .iter()
        .map(|(name, paint)| (name.as_deref().unwrap_or("all its materials"), painted(paint)))
        .collect();
    let paints: String = paints.iter().map(|(name, paint)| format!("; {name}: {paint}")).collect();
    format!("Inserted {} {place}{scale}{paints}.", insert.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use unrender_restage::environment::Surround;

    #[test]
    fn edits_read_as_sentences() {
        let paint =
            Paint { rho_d: Some(Rgb::new(0.5, 0.1, 0.1)), alpha_x: Some(0.2), ..Paint::default() };
        let dimmed = Alter {
            scale: Rgb::splat(0.5),
            strength: None,
            shift: Vec3::Y,
            direction: None,
            profile: None,
            turn_rad: None,
        };
        let light =
            |change| Edit::Light(LightEdit { name: "lamp".into(), change, photometric: None });
        let edits = [
            Edit::Remove(Remove { name: "sofa".into(), what: Bearer::Group }),
            Edit::Repaint(Repaint { group: "floor".into(), paint }),
            light(LightChange::Alter(dimmed.clone())),
            light(LightChange::Alter(Alter { scale: Rgb::ZERO, ..dimmed })),
            Edit::Surround(Surround { environment: None }),
        ];
        assert_eq!(
            sentences(&edits),
            [
                "Removed the group sofa with all its objects.",
                "Repainted floor: rho_d = [0.5, 0.1, 0.1] (sRGB #bc5959), alpha_x = 0.2.",
                "Changed the light lamp: 0.5 times as bright, moved by [0, 1, 0] m.",
                "Switched the light lamp off.",
                "Removed the environment.",
            ]
        );
    }
}
