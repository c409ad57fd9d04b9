//! Scores of made-up results against made-up truths.

use crate::kit::folder::Folder;
use std::path::Path;
use unrender::formats::materials::MaterialsFile;
use unrender::score::{
    GroupScore, Limits, ParameterScore, certainty, score, score_lights, table, worst,
};

fn parsed(groups: &str) -> MaterialsFile {
    serde_json::from_str(&format!("{{\"groups\": {{{groups}}}}}")).unwrap()
}

fn scores(results: &str, truth: &str) -> Vec<GroupScore> {
    let here = Path::new(".");
    score(&parsed(results), here, &parsed(truth), here).unwrap()
}

fn near(value: Option<f64>, wanted: f64) -> bool {
    value.is_some_and(|v| (v - wanted).abs() < 1e-3)
}

const FLOOR: &str = r#""floor": {"hypothesis": "anisotropic", "status": "recovered",
    "rho_d": [0.1, 0.1, 0.1], "rho_s": [0.9, 0.9, 0.9], "alpha_x": 0.07, "alpha_y": 0.11,
    "theta_deg": 0.0, "direction": [1, 0, 0]}"#;

#[test]
fn the_truth_against_itself_is_free_of_errors() {
    let score = &scores(FLOOR, FLOOR)[0];
    assert!(score.counted && score.is_hypothesis_right() && score.missing.is_empty());
    assert_eq!((score.rho_d, score.rho_s, score.alpha_percent), (Some(0.0), Some(0.0), Some(0.0)));
    assert_eq!(score.degrees, Some(0.0));
}

#[test]
fn swapped_alphas_with_a_turned_direction_are_the_same_lobe() {
    for place in ["\"direction\": [0, 0, -1]", "\"theta_deg\": -90"] {
        let found = format!(
            r#""floor": {{"hypothesis": "anisotropic", "rho_d": [0.1, 0.1, 0.1],
                "rho_s": [0.9, 0.9, 0.9], "alpha_x": 0.11, "alpha_y": 0.07, {place}}}"#
        );
        let score = &scores(&found, FLOOR)[0];
        assert!(near(score.alpha_percent, 0.0) && near(score.degrees, 0.0), "{place}: {score:?}");
    }
    // If they are swapped without the turn, it is another lobe, 90 degrees off.
    let found = FLOOR.replace("0.07", "0.2").replace("0.11", "0.07").replace("0.2,", "0.11,");
    assert!(near(scores(&found, FLOOR)[0].degrees, 90.0));
}

#[test]
fn directions_are_lines() {
    let found = FLOOR.replace("[1, 0, 0]", "[-0.999847695, 0, 0.017452406]");
    assert!(near(scores(&found, FLOOR)[0].degrees, 1.0));
    let found =
        FLOOR.replace("[1, 0, 0]", "null").replace("\"theta_deg\": 0.0", "\"theta_deg\": 178");
    assert!(near(scores(&found, FLOOR)[0].degrees, 2.0));
}

#[test]
fn errors_are_the_worst_of_the_channels_and_in_units_of_std() {
    let found = r#""floor": {"hypothesis": "isotropic", "rho_d": [0.1, 0.12, 0.1],
        "rho_s": [0.9, 0.9, 0.86], "alpha_x": 0.077, "alpha_y": 0.11, "theta_deg": 0,
        "std": {"rho_d": [0.01, 0.01, 0.01], "rho_s": [0.1, 0.1, 0.1], "alpha_x": 0.0014}}"#;
    let score = &scores(found, FLOOR)[0];
    assert!(!score.is_hypothesis_right());
    assert!(near(score.rho_d, 0.02) && near(score.rho_s, 0.04), "{score:?}");
    assert!(near(score.alpha_percent, 10.0) && near(score.in_std, 5.0), "{score:?}");
}

#[test]
fn every_parameter_is_compared_with_its_std() {
    let found = r#""floor": {"hypothesis": "anisotropic", "status": "recovered",
        "rho_d": [0.1, 0.12, 0.1], "rho_s": [0.9, 0.9, 0.86], "alpha_x": 0.11, "alpha_y": 0.077,
        "direction": [0.017452406, 0, 0.999847695],
        "std": {"rho_d": [0.01, 0.01, 0], "rho_s": [0.1, 0.1, 0.1], "alpha_x": 0.001,
                "alpha_y": 0.0014, "theta_deg": 0.5}},
        "wall": {"status": "assumed", "rho_d": [1, 1, 1], "std": {"rho_d": [0.1, 0.1, 0.1]}},
        "plain": {"status": "recovered", "rho_d": [0.5, 0.5, 0.5]}"#;
    let truth = format!(
        "{FLOOR}, \"wall\": {{\"rho_d\": [0, 0, 0]}}, \"plain\": {{\"rho_d\": [0.5, 0.5, 0.5]}}"
    );
    let all = scores(found, &truth);
    let ratios = |i: usize| -> Vec<(&str, Vec<Option<f64>>)> {
        let rounded = |r: &Option<f64>| r.map(|r| (1e3 * r).round() / 1e3);
        let parameter = |p: &ParameterScore| (p.parameter, p.in_std.iter().map(rounded).collect());
        all[i].parameters.iter().map(parameter).collect()
    };
    let wanted = [
        ("rho_d", vec![Some(0.0), Some(2.0), None]),
        ("rho_s", vec![Some(0.0), Some(0.0), Some(0.4)]),
        // The same lobe, turned: alpha_x is the truth's alpha_y.
        ("alpha_x", vec![Some(0.0)]),
        ("alpha_y", vec![Some(5.0)]),
        ("theta_deg", vec![Some(2.0)]),
    ];
    assert_eq!(ratios(0), wanted);
    assert!(near(all[0].in_std, 5.0) && all[2].parameters.is_empty());
    let sum = certainty(&all, &[]).unwrap();
    assert_eq!(sum.parameters, 8, "zeros, and groups that do not count, are left out");
    assert!(near(Some(sum.percent_within_one), 62.5) && near(Some(sum.worst), 5.0), "{sum:?}");
    let text = table::parameters(&all, &[], &sum);
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 7, "{text}");
    let columns: Vec<&str> = lines[4].split_whitespace().collect();
    assert_eq!(columns, ["floor", "alpha_y", "0.0070", "0.0014", "5.00"]);
    assert!(lines[1].ends_with("0.00 2.00 -"), "{text}");
    assert!(lines[6].starts_with("8 parameters: 62 % within 1 std, "), "{text}");
    assert!(certainty(&all[2..], &[]).is_none());
}

#[test]
fn one_alpha_is_one_parameter() {
    let pot = |alpha: f64| {
        format!(
            r#""pot": {{"rho_s": [0.1, 0.1, 0.1], "alpha_x": {alpha}, "alpha_y": {alpha},
                "std": {{"alpha_x": 0.01, "alpha_y": 0.01}}}}"#
        )
    };
    let score = scores(&pot(0.22), &pot(0.2)).remove(0);
    assert_eq!(score.parameters.len(), 1, "{score:?}");
    assert!(near(score.in_std, 2.0), "{score:?}");
}

#[test]
fn lights_are_compared_by_name() {
    let file = |lights: &str| -> MaterialsFile {
        serde_json::from_str(&format!(r#"{{"groups": {{}}, "lights": {{{lights}}}}}"#)).unwrap()
    };
    let truth = file(
        r#""lamp": {"intensity": [40, 20, 0]}, "sun": {"intensity": [1, 1, 1]},
           "moon": {"intensity": [1, 1, 1]}, "dim": {}"#,
    );
    let results = file(
        r#""sun": {"intensity": [1.1, 1, 1]}, "other": {"intensity": [1, 1, 1]}, "dim": {},
           "lamp": {"intensity": [41, 20.2, 0.1], "std": [0.5, 0.4, 0.1]}"#,
    );
    let lights = score_lights(&results, &truth);
    let names: Vec<&str> = lights.iter().map(|light| light.light.as_str()).collect();
    assert_eq!(names, ["lamp", "sun"]);
    assert!(near(lights[0].percent, 2.5) && near(lights[1].percent, 10.0), "{lights:?}");
    let sum = certainty(&[], &lights).unwrap();
    assert_eq!((sum.parameters, sum.percent_within_two), (3, 100.0));
    assert!(near(Some(sum.worst), 2.0), "{sum:?}");
    assert_eq!(table::lights(&lights), "light  error %\nlamp      2.50\nsun      10.00\n");
    let text = table::parameters(&[], &lights, &sum);
    assert!(text.contains("lamp   intensity  1.0 0.20 0.10  0.50 0.40 0.10"), "{text}");
}

#[test]
fn what_is_not_in_the_truth_is_not_compared() {
    let wall = r#""wall": {"hypothesis": "diffuse", "rho_d": [0.5, 0.5, 0.5], "rho_s": [0, 0, 0],
        "alpha_x": 0, "alpha_y": 0}"#;
    let found = r#""wall": {"hypothesis": "diffuse", "rho_d": [0.5, 0.5, 0.5], "rho_s": [0, 0, 0],
        "alpha_x": 0.3}, "other": {}"#;
    let all = scores(found, wall);
    assert_eq!((all.len(), all[0].alpha_percent, all[0].degrees), (1, None, None));
    assert!(all[0].missing.is_empty());
}

#[test]
fn known_and_assumed_groups_are_shown_but_not_counted() {
    let known = FLOOR.replace("recovered", "known").replace("0.9, 0.9, 0.9", "0.5, 0.5, 0.5");
    let all = scores(&known, FLOOR);
    let limits = Limits { rho: Some(0.01), ..Limits::default() };
    assert_eq!(worst(&all).counted, 0);
    assert!(limits.exceeded(&all)[0].contains("nothing was compared"));
    let text = table::table(&all, &worst(&all));
    assert!(text.contains("(known)") && text.contains("0.4000"), "{text}");
}

#[test]
fn limits_hypotheses_and_missing_groups_are_held() {
    let truth = format!("{FLOOR}, {}", FLOOR.replace("floor", "gone"));
    let found = FLOOR.replace("0.07", "0.0721").replace("\"anisotropic\"", "\"isotropic\"");
    let all = scores(&found, &truth);
    let limits = Limits { alpha_percent: Some(2.0), ..Limits::default() };
    let faults = limits.exceeded(&all).join("\n");
    for part in
        ["floor: the hypothesis", "floor: alpha (percent)", "gone: the results have no group"]
    {
        assert!(faults.contains(part), "{part} in {faults}");
    }
    let text = table::table(&all, &worst(&all));
    assert!(text.contains("isotropic, is anisotropic"), "{text}");
}

#[test]
fn textures_are_compared_by_their_texels() {
    use unrender::formats::picture;
    use unrender::scene::{Image, Rgb};
    let folder = Folder::new();
    let folder = folder.root();
    let stripes = |off: f32| {
        Image::from_fn(4, 4, move |x, _| Rgb::splat(if x < 2 { 0.2 } else { 0.6 + off }))
    };
    picture::write(&folder.join("t.exr"), &stripes(0.0)).unwrap();
    picture::write(&folder.join("f.exr"), &stripes(0.1)).unwrap();
    let truth = parsed(r#""a": {"hypothesis": "textured", "texture": "t.png"}"#);
    let against = |entry: &str| {
        let found = parsed(&format!("\"a\": {entry}"));
        score(&found, folder, &truth, folder).unwrap().remove(0)
    };
    assert!(near(against(r#"{"texture": "f.png"}"#).rho_d, 0.05));
    assert!(near(against(r#"{"rho_d": [0.4, 0.4, 0.4]}"#).rho_d, 0.2));
    assert_eq!(against("{}").missing, ["texture"]);
    let score = against(r#"{"texture": "f.png", "std": {"rho_d": [0.05, 0.1, 0.025]}}"#);
    let ratios: Vec<Option<f64>> = score.parameters[0].in_std.clone();
    assert!(ratios.iter().zip([1.0, 0.5, 2.0]).all(|(&r, wanted)| near(r, wanted)), "{ratios:?}");
}
