//! What is wrong with the results of a run: numbers that are none, and groups that are called recovered though their error
//! is large.

use serde_json::Value;
use std::fs;
use std::path::Path;

/// A group that is called recovered has no larger error than this, relative: twice of what makes it doubtful. Half and
/// double of it were not tried.
const ERROR_MAX: f64 = 0.3;

/// What is wrong with the text that a command printed or the sentence of a warning.
pub(super) fn text(said: &str) -> Option<String> {
    let is_none = |word: &str| {
        let word = word.trim_matches(|c: char| !c.is_ascii_alphanumeric());
        ["nan", "inf", "infinity"].contains(&word.to_ascii_lowercase().as_str())
    };
    let line = said.lines().find(|line| {
        line.contains("were not finite numbers") || line.split_whitespace().any(is_none)
    });
    line.map(|line| format!("says \"{}\"", line.trim()))
}

/// What is wrong with the `materials.json` in `folder`, beside which there is `run.json`.
pub(super) fn materials(folder: &Path) -> Vec<String> {
    let read = |name: &str| {
        let text = fs::read(folder.join(name)).map_err(|error| format!("{name}: {error}"))?;
        serde_json::from_slice::<Value>(&text).map_err(|error| format!("{name}: {error}"))
    };
    match (read("materials.json"), read("run.json")) {
        (Ok(file), Ok(run)) => groups(&file, &run).chain(others(&file)).collect(),
        (Err(error), _) | (_, Err(error)) => vec![error],
    }
}

/// What is wrong with the groups.
fn groups(file: &Value, run: &Value) -> impl Iterator<Item = String> {
    file["groups"].as_object().into_iter().flatten().flat_map(|(name, group)| {
        // What is no finite number is written as null.
        let always = ["rho_d", "rho_s", "alpha_x", "alpha_y", "theta_deg"];
        let mut missing: Vec<&str> =
            always.into_iter().filter(|key| !is_finite(&group[*key])).collect();
        let is_seen = run["groups"][name]["valid_pixels"].as_u64().is_some_and(|count| count > 0);
        let is_recovered = group["status"] == "recovered";
        if is_recovered && is_seen && !is_finite(&group["error"]) {
            missing.push("error");
        }
        let is_none = |key| format!("{name}: {key} of materials.json is no finite number");
        let mut wrong: Vec<String> = missing.into_iter().map(is_none).collect();
        let error = group["error"].as_f64().filter(|error| is_recovered && *error > ERROR_MAX);
        wrong.extend(error.map(|error| format!("{name}: recovered, with an error of {error:.3}")));
        wrong
    })
}

/// What is wrong with the exposures and the lamps.
fn others(file: &Value) -> impl Iterator<Item = String> {
    let lights = file["lights"].as_object().into_iter().flatten();
    let lights = lights.map(|(name, light)| (name.clone(), &light["intensity"]));
    let exposure = std::iter::once(("exposure".to_owned(), &file["exposure"]));
    exposure
        .chain(lights)
        .filter(|(_, value)| !is_finite(value))
        .map(|(name, _)| format!("{name} of materials.json is no finite number"))
}

/// Whether `value` is a number or a list of numbers that are finite in single precision.
fn is_finite(value: &Value) -> bool {
    match value {
        Value::Array(items) => items.iter().all(is_finite),
        _ => value.as_f64().is_some_and(|number| (number as f32).is_finite()),
    }
}

#[cfg(test)]
mod tests {
    use super::{groups, others, text};
    use serde_json::json;

    fn judged(group: serde_json::Value) -> Vec<String> {
        let mut sound = json!({"status": "recovered", "rho_d": [0.5, 0.5, 0.5], "rho_s": [0, 0, 0],
            "alpha_x": 0, "alpha_y": 0, "theta_deg": 0, "pixels": 9, "error": 0.1});
        for (key, value) in group.as_object().unwrap() {
            sound[key] = value.clone();
        }
        let file = json!({"groups": {"wall": sound}, "exposure": [1, 1, 1]});
        let seen = if file["groups"]["wall"]["pixels"] == 0 { 0 } else { 9 };
        let run = json!({"groups": {"wall": {"valid_pixels": seen}}});
        groups(&file, &run).chain(others(&file)).collect()
    }

    #[test]
    fn numbers_are_finite_and_what_is_recovered_has_a_small_error() {
        assert!(judged(json!({})).is_empty());
        assert!(judged(json!({"status": "doubtful", "error": 4.0})).is_empty());
        assert!(judged(json!({"pixels": 0, "error": null})).is_empty());
        for wrong in [json!({"error": 0.31}), json!({"error": null}), json!({"alpha_x": null})] {
            assert_eq!(judged(wrong.clone()).len(), 1, "{wrong}");
        }
        assert_eq!(judged(json!({"rho_d": [0.5, 1e39, 0.5]})).len(), 1, "infinite as it is read");
    }

    #[test]
    fn texts_say_no_number_that_is_none() {
        for sound in ["the infinite plane", "nano 3", "banana", "information: 4"] {
            assert_eq!(text(sound), None);
        }
        for wrong in
            ["error NaN %", "wall: inf", "(infinity)", "a\n2 value(s) were not finite numbers"]
        {
            assert!(text(wrong).is_some(), "{wrong}");
        }
    }
}
