//! Replacing the environment.

use crate::stage::Stage;
use unrender_scene::Environment;

/// Replaces or removes the environment.
#[derive(Clone, Debug, PartialEq)]
pub struct Surround {
    /// The new environment.
    pub environment: Option<Environment>,
}

pub(crate) fn apply(surround: &Surround, stage: &mut Stage<'_>) -> Result<(), String> {
    stage.claim("environment", "panorama")?;
    let up = stage.scene.up;
    stage.scene.environment = surround.environment.clone().map(|around| around.with_up(up));
    Ok(())
}
