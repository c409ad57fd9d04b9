//! Models whose size does not fit the scene that they are put into, as those in other units than metres.

/// From this share of the scene's diagonal on, a model is too large to be meant. A chair in centimetres, in a room of
/// 8 m, has ten times the room's diagonal. At half of it rooms and grounds around a scene are told of; double was not
/// tried.
const LARGEST: f32 = 2.0;
/// Below this share, a model is too small to be meant: a cup in a room of 8 m has a hundredth. Half and double were not
/// tried.
const SMALLEST: f32 = 1e-3;
/// What a unit of a model may be, metres.
const UNITS: [(f32, &str); 4] =
    [(0.01, "centimetres"), (0.0254, "inches"), (0.3048, "feet"), (0.001, "millimetres")];

/// What is odd about the model called `name`, which was scaled by `scale` and has the diagonal `model`, metres, in a scene with the
/// diagonal `scene`; none if its size may be meant.
pub(crate) fn doubt((name, scale): (&str, f32), model: f32, scene: f32) -> Option<String> {
    let share = model / scene;
    let is_large = share > LARGEST;
    if !(is_large || share < SMALLEST) || !share.is_finite() {
        return None;
    }
    let factor = |metres: f32| if is_large { metres } else { 1.0 / metres };
    let fits =
        |(metres, _): &&(f32, &str)| (10.0 * SMALLEST..=0.5).contains(&(share * factor(*metres)));
    let remedies = UNITS.iter().filter(fits).map(|(metres, unit)| {
        let (factor, why) =
            (factor(*metres), if is_large { "is in" } else { "was taken for one in" });
        format!(
            "scale = {} if its file {why} {unit}, which makes it {} m",
            rounded(scale * factor),
            rounded(model * factor)
        )
    });
    let remedies: Vec<String> = remedies.collect();
    let remedy =
        if remedies.is_empty() { "give a scale".to_owned() } else { remedies.join(", or ") };
    let size = if is_large { "large" } else { "small" };
    Some(format!(
        "\"{name}\" is too {size} for the scene: from corner to corner it has {} m, the scene {} m; say {remedy}",
        rounded(model),
        rounded(scene)
    ))
}

/// `value` in three digits.
fn rounded(value: f32) -> f64 {
    let shown = format!("{value:.2e}");
    shown.parse().unwrap_or(f64::from(value))
}

#[cfg(test)]
mod tests {
    use super::doubt;

    #[test]
    fn units_are_told_by_the_sizes() {
        let told = |model, scene| doubt(("chair", 1.0), model, scene);
        assert!(told(0.9, 8.0).is_none() && told(15.0, 8.0).is_none() && told(0.02, 8.0).is_none());
        let large = told(900.0, 8.0).unwrap();
        assert!(large.contains("it has 900 m, the scene 8 m"), "{large}");
        assert!(
            large.contains("scale = 0.001 if its file is in millimetres, which makes it 0.9 m")
        );
        assert!(!large.contains("centimetres"), "{large}");
        let small = doubt(("chair", 0.5), 0.0009, 8.0).unwrap();
        assert!(small.contains("too small") && small.contains("scale = 500 if"), "{small}");
        assert!(told(1e9, 8.0).unwrap().ends_with("say give a scale"));
    }
}
