//! run.json: the story of a recovery, turn by turn and rung by rung, for reports and for the
//! curious.
//!
//! `registration`: how far the model's edges were from the photograph's under the camera as given
//! (null where too few were found), and the camera that was used, as in a project's `[camera]`.
//! `turns`: each global re-rendering, whether it was a pass of the joint refinement, its largest
//! `change`, `worst_error` (relative, noise taken out) and the groups still open. `groups.NAME.story`: every rung tried, in which turn, with its
//! parameters, its error, the standard deviation of the error's square, and whether it was taken.

use crate::Error;
use crate::engine::Recovered;
use crate::project::CameraTable;
use crate::registration::Laid;
use glam::Vec3;
use serde_json::{Map, Value, json};
use std::path::Path;
use unrender_formats::{FileError, atomic};
use unrender_recover::record::Trial;
use unrender_scene::Lens;

/// Writes run.json.
pub(super) fn write(recovered: &Recovered, path: &Path) -> Result<(), Error> {
    let recovery = &recovered.recovery;
    let turns: Vec<Value> = recovery
        .turns
        .iter()
        .map(|turn| {
            json!({
                "turn": turn.turn,
                "refining": turn.refining,
                "change": turn.change,
                "worst_error": turn.worst_error,
                "open_groups": turn.open_groups,
            })
        })
        .collect();
    let groups: Map<String, Value> = recovery
        .groups
        .iter()
        .map(|group| {
            let story: Vec<Value> = group.story.iter().map(trial).collect();
            let value = json!({
                "hypothesis": group.hypothesis.name(),
                "trusted_pixels": group.trusted_pixels,
                "error": group.error,
                "story": story,
            });
            (group.name.clone(), value)
        })
        .collect();
    let run = json!({
        "version": 1,
        "seconds": recovered.seconds,
        "termination": recovery.termination.message(recovery.turns.len()),
        "registration": registration(&recovered.laid),
        "turns": turns,
        "groups": groups,
    });
    Ok(atomic::write(path, format!("{run:#}\n").as_bytes())?)
}

/// How the model lay on the photograph, and the camera that was used.
fn registration(laid: &Laid) -> Value {
    let table = CameraTable::of(&laid.camera, 1.0);
    let lens = table.lens;
    let camera = json!({
        "eye": table.eye.to_array(),
        "target": table.target.to_array(),
        "up": table.up.to_array(),
        "fov_y_deg": table.fov_y_deg,
        "principal_point": lens.principal_point,
        "k1": lens.k1,
        "k2": lens.k2,
    });
    let found = laid.registration.as_ref();
    json!({
        "camera": camera,
        "displacement_pixels": found.map(|r| r.displacement),
        "uncertainty_pixels": found.map(|r| r.uncertainty),
        "deviation_pixels": found.map(|r| r.deviation),
        "confirmed_edge_points": found.map(|r| r.confirmed),
    })
}

/// The camera that the recovery with the run file at `path` used; none if the file does not say.
///
/// # Errors
/// If the file is damaged.
pub(crate) fn camera(path: &Path) -> Result<Option<CameraTable>, FileError> {
    let Ok(text) = std::fs::read_to_string(path) else { return Ok(None) };
    let run: Value = serde_json::from_str(&text)
        .map_err(|error| FileError::new(path, format!("is not JSON: {error}")))?;
    let camera = &run["registration"]["camera"];
    let number = |value: &Value| value.as_f64().map(|number| number as f32);
    let vector = |key: &str| {
        let [x, y, z] = [0, 1, 2].map(|index| number(&camera[key][index]));
        Some(Vec3::new(x?, y?, z?))
    };
    let table = || {
        let [right, down] = [0, 1].map(|index| number(&camera["principal_point"][index]));
        let (k1, k2) = (number(&camera["k1"])?, number(&camera["k2"])?);
        let lens = Lens { principal_point: [right?, down?], k1, k2 };
        let (eye, target, up) = (vector("eye")?, vector("target")?, vector("up")?);
        Some(CameraTable { eye, target, up, fov_y_deg: number(&camera["fov_y_deg"])?, lens })
    };
    Ok(table())
}

fn trial(trial: &Trial) -> Value {
    let material = &trial.material;
    json!({
        "turn": trial.turn,
        "hypothesis": trial.hypothesis.name(),
        "error": trial.misfit.relative(),
        "deviation_of_square": trial.misfit.deviation,
        "rho_d": material.rho_d.to_array(),
        "rho_s": material.rho_s.to_array(),
        "alpha_x": material.alpha_x,
        "alpha_y": material.alpha_y,
        "theta_deg": material.theta_rad.to_degrees(),
        "taken": trial.taken,
    })
}
