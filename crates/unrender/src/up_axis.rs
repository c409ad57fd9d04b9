//! Which axis of a scene points upwards, where a project or an edit does not state it.

use unrender_scene::{UpAxis, Warnings};

/// The axis upwards: as stated, else as the camera says, which is told.
pub(crate) fn settled(
    stated: Option<UpAxis>,
    of_camera: Option<UpAxis>,
    warnings: &mut Warnings,
) -> UpAxis {
    let up = stated.or(of_camera).unwrap_or_default();
    if stated.is_none() && up != UpAxis::default() {
        let name = up.name();
        warnings.push(format!(
            "the camera's up is +{name}, so {name} was taken to point upwards in the scene, for panoramas and for what is \
             inserted; up_axis = \"{name}\" at the top of the file states it, up_axis = \"y\" the contrary"
        ));
    }
    up
}
