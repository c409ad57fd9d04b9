//! The light from all around, exchanged.

use crate::edit::Stage;
use unrender_scene::Environment;

/// Puts another panorama around the scene, or none.
#[derive(Clone, Debug, PartialEq)]
pub struct Surround {
    /// What surrounds the scene from now on.
    pub environment: Option<Environment>,
}

pub(crate) fn apply(surround: &Surround, stage: &mut Stage<'_>) -> Result<(), String> {
    stage.claim("environment", "panorama")?;
    stage.scene.environment.clone_from(&surround.environment);
    Ok(())
}
