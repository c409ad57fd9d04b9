//! The transfer function of a project's photograph, from what project and file say of it.

use crate::Error;
use crate::project::{Project, ResponseChoice};
use unrender_formats::{FileError, picture::Picture, response_curve};
use unrender_photo::{Curve, Response, Transfer, Vignetting, choose_response, vignetting};
use unrender_scene::{Camera, Warnings};

/// The transfer function of `project`'s `picture`, which `camera` took; its exposure is the stated
/// one, or one where that is asked for.
pub(crate) fn transfer(
    project: &Project,
    picture: &Picture,
    camera: &Camera,
) -> Result<(Transfer, Warnings), Error> {
    let (response, warnings) = choose_response(picture.depth, stated(project)?);
    let size = (picture.values.width(), picture.values.height());
    let vignetting = project.vignetting.map(|law| Vignetting { law, camera: camera.clone(), size });
    if let Some(vignetting) = &vignetting {
        check(vignetting).map_err(|problem| FileError::new(&project.path, problem))?;
    }
    let transfer = Transfer {
        black_level: project.black_level,
        vignetting,
        ..Transfer::plain(response, project.exposure.or_one())
    };
    Ok((transfer, warnings))
}

/// The response that the project states.
fn stated(project: &Project) -> Result<Option<Response>, Error> {
    let response = match &project.response {
        None => return Ok(None),
        Some(ResponseChoice::Stated(response)) => response.clone(),
        Some(ResponseChoice::Measured(path)) => {
            let rows = response_curve::read(path)?;
            Response::measured(rows.linear.each_ref().map(|linear| Curve::new(&rows.codes, linear)))
        }
    };
    Ok(Some(response))
}

/// A lens that lets nothing through says nothing of the corners.
fn check(vignetting: &Vignetting) -> Result<(), String> {
    let darkest = vignetting.darkest();
    if darkest >= vignetting::DARKEST {
        return Ok(());
    }
    Err(format!(
        "vignetting: by it a pixel of the photo gets {darkest:.3} of the light; r is 1 at half the \
         picture's diagonal, and 1 + a1 r^2 + a2 r^4 + a3 r^6 must stay above {}",
        vignetting::DARKEST
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use unrender_photo::vignetting::Law;

    #[test]
    fn a_lens_must_let_light_through() {
        let camera = Camera::look_at("c", Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0);
        let told = |law| check(&Vignetting { law, camera: camera.clone(), size: (40, 30) });
        assert_eq!(told(Law::Radial([-1.511, 1.506, -0.64])), Ok(()));
        let problem = told(Law::Radial([-1.1, 0.0, 0.0])).unwrap_err();
        assert!(problem.contains("half the picture's diagonal"), "{problem}");
    }
}
