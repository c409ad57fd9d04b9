//! The transfer function of a project's photograph, from the project and the file.

use crate::bracket::{Place, read_and_merge};
use crate::project::{Frames, Project, ResponseChoice, VignettingChoice};
use crate::{Error, photometric};
use std::path::Path;
use unrender_formats::picture::{self, Orientation, Picture, Profile};
use unrender_formats::{FileError, Input, response_curve};
use unrender_photo::bracket::Settings;
use unrender_photo::vignetting::{DARKEST, Law};
use unrender_photo::{Curve, Response, Transfer, Vignetting, choose_response, declared_response};
use unrender_scene::{Camera, Rgb, Warnings};

/// The transfer function of `project`'s `picture`, which `camera` took; its exposure is the stated
/// one, or one if it is unknown.
pub(crate) fn transfer(
    project: &Project,
    picture: &Picture,
    camera: &Camera,
) -> Result<(Transfer, Warnings), Error> {
    let profile = picture.profile.as_ref();
    let asked = project.response == Some(ResponseChoice::Auto);
    let by_format = picture.is_linear.then_some(Response::Linear);
    let declared = by_format.or_else(|| profile.filter(|_| !asked).and_then(declared_response));
    let (response, mut warnings) = choose_response(picture.depth, stated(project)?, declared);
    warnings.extend(profile_warnings(profile));
    let size = (picture.values.width(), picture.values.height());
    let law = project.vignetting.map(|choice| match choice {
        VignettingChoice::Stated(law) => law,
        VignettingChoice::Auto => Law::Radial([0.0; 3]),
    });
    let vignetting = law.map(|law| Vignetting { law, camera: camera.clone(), size });
    if let Some(vignetting) = &vignetting {
        check(vignetting).map_err(|problem| FileError::new(&project.path, problem))?;
    }
    let of_merged = picture.merged.as_ref().map(|merged| merged.white_level);
    let white_level = project.white_level.or(of_merged).unwrap_or(Rgb::INFINITY);
    if picture.depth.max_code().is_some() && project.white_level.is_some_and(is_beyond_one) {
        let [r, g, b] = white_level.to_array();
        let problem = format!(
            "white_level is [{r}, {g}, {b}]; it is a code of at most 1, which is the photo's \
             greatest: divide that of an 8-bit file by 255"
        );
        return Err(FileError::new(&project.path, problem).into());
    }
    let transfer = Transfer {
        black_level: project.black_level,
        white_level,
        vignetting,
        srgb_from_file: profile.and_then(|profile| profile.srgb_from_file),
        ..Transfer::plain(response, project.exposure.or_one())
    };
    Ok((transfer, warnings))
}

fn is_beyond_one(code: Rgb) -> bool {
    code.max_element() > 1.0
}

/// Warnings of the colours that the photograph declares.
fn profile_warnings(profile: Option<&Profile>) -> Warnings {
    let mut warnings = Warnings::default();
    match profile {
        Some(Profile { understood: false, source, .. }) => warnings.push(format!(
            "the photo has {source} of a kind that is not understood: its colours were taken as \
             those of sRGB"
        )),
        Some(Profile { srgb_from_file: Some(_), source, .. }) => warnings.push(format!(
            "the photo's primaries are not those of sRGB, by {source}; its colours were converted \
             to them"
        )),
        _ => {}
    }
    warnings
}

/// The response that the project states.
fn stated(project: &Project) -> Result<Option<Response>, Error> {
    let response = match &project.response {
        None => return Ok(None),
        Some(ResponseChoice::Stated(response)) => response.clone(),
        Some(ResponseChoice::Auto) => Response::Gamma(photometric::GAMMA),
        Some(ResponseChoice::Measured(path)) => measured(path)?,
    };
    Ok(Some(response))
}

/// The response in the file at `path`.
pub(crate) fn measured(path: &Path) -> Result<Response, FileError> {
    let rows = response_curve::read(path)?;
    Ok(Response::measured(rows.linear.each_ref().map(|linear| Curve::new(&rows.codes, linear))))
}

/// Merges the bracket that `project` names as its photograph. The project's response, black level and white
/// level are those of the photographs; the merged picture is linear, and the project's response is set to
/// that.
pub(crate) fn merged(
    project: &mut Project,
    frames: &Frames,
    warnings: &mut Warnings,
) -> Result<Picture, Error> {
    let response = match &project.response {
        Some(ResponseChoice::Auto) | None => None,
        Some(_) => stated(project)?,
    };
    let settings = Settings {
        response,
        black_level: project.black_level,
        white_level: project.white_level.unwrap_or(Rgb::INFINITY),
    };
    let place = Place::Project(&project.path);
    let (merged, noted) = read_and_merge(frames, &settings, project.limits, place)?;
    warnings.extend(noted);
    project.response = Some(ResponseChoice::Stated(Response::Linear));
    project.black_level = Rgb::ZERO;
    project.white_level = None;
    Ok(merged.picture)
}

/// The orientation of the pixels in the file of `project`'s photograph, or in those of its bracket.
pub(crate) fn orientation(project: &Project) -> Result<Orientation, Error> {
    let of = |file: &Path| {
        let stored = picture::stored(Input::new(file, project.limits))?;
        Ok::<_, FileError>(stored.map_or(Orientation::UPRIGHT, |stored| stored.orientation))
    };
    let first = of(&project.photo)?;
    for file in project.bracket.iter().flat_map(|bracket| &bracket.files) {
        let (one, other) = (first.number(), of(file)?.number());
        if one != other {
            let problem = format!(
                "has the EXIF orientation {other}, and the first photograph of the bracket {one}, \
                 so one camera of stored pixels cannot fit both; give all of them the same \
                 orientation"
            );
            return Err(FileError::new(file, problem).into());
        }
    }
    Ok(first)
}

/// Checks that the vignetting lets some light through everywhere.
fn check(vignetting: &Vignetting) -> Result<(), String> {
    let darkest = vignetting.darkest();
    if darkest >= DARKEST {
        return Ok(());
    }
    Err(format!(
        "vignetting: a pixel of the photo would get {darkest:.3} of the light; r is 1 at half the \
         picture's diagonal, and 1 + a1 r^2 + a2 r^4 + a3 r^6 must stay above {DARKEST}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_lens_must_let_light_through() {
        let camera = Camera::look_at("c", Vec3::Z, Vec3::ZERO, Vec3::Y, 1.0);
        let noted = |law| check(&Vignetting { law, camera: camera.clone(), size: (40, 30) });
        assert_eq!(noted(Law::Radial([-1.511, 1.506, -0.64])), Ok(()));
        let problem = noted(Law::Radial([-1.1, 0.0, 0.0])).unwrap_err();
        assert!(problem.contains("half the picture's diagonal"), "{problem}");
    }
}
