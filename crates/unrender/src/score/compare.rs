//! The errors of one group.
//!
//! Diffuse reflectances are compared as they are seen at normal incidence (`albedo_d`): under a dielectric `rho_d` is that of
//! the base, and what is a plastic on one side may be a matt group on the other.

use super::GroupScore;
use super::certainty::{ParameterScore, largest};
use super::lobe::Lobe;
use glam::Vec2;
use std::path::Path;
use unrender_formats::materials::{
    GroupEntry, MaterialsFile, Status, StatusEntry, mean_of, read_texture_beside,
};
use unrender_formats::{FileError, Limits};
use unrender_scene::{Image, Rgb, Texture, Wrap};

/// True if a group of `file` is compared with the truth: it was recovered, or the group whose material it
/// has.
pub(super) fn counts(file: &MaterialsFile, group: &GroupEntry) -> bool {
    let status = match &group.status {
        Some(StatusEntry::SameAs(name)) => file.groups.get(name).and_then(|g| g.status.as_ref()),
        status => status.as_ref(),
    };
    status.is_none_or(|status| status.is(Status::Recovered) || status.is(Status::Doubtful))
}

/// Compares one group; the caller sets its name, and whether it counts.
pub(super) fn group(
    found: &GroupEntry,
    found_folder: &Path,
    wanted: &GroupEntry,
    wanted_folder: &Path,
) -> Result<GroupScore, FileError> {
    let mut score = GroupScore {
        status: found.status.clone(),
        hypothesis: found.hypothesis,
        true_hypothesis: wanted.hypothesis,
        ..GroupScore::default()
    };
    match &wanted.texture {
        Some(texture) => {
            let (truth, _) = read_texture_beside(wanted_folder, texture, Limits::default())?;
            let share = wanted.base_seen();
            let truth = truth.map(|texel| *texel * share);
            match found_texture(found, found_folder)? {
                Some(texture) => {
                    let error = texture_error(&texture, &truth);
                    note("rho_d", &error, std_of_albedo(found), &mut score);
                    score.rho_d = Some(largest_of(&error));
                }
                None => score.missing.push("texture"),
            }
        }
        None => compare_rho_d(found, found_folder, wanted, &mut score)?,
    }
    compare_triple("rho_s", found.rho_s, wanted.rho_s, std_of(found, |s| s.rho_s), &mut score);
    if wanted.rho_s.is_some_and(|rho| rho.iter().any(|&r| r > 0.0)) {
        compare_lobes(found, wanted, &mut score);
    }
    score.in_std = largest(&score.parameters);
    Ok(score)
}

fn std_of<T>(
    entry: &GroupEntry,
    f: fn(&unrender_formats::materials::StdEntry) -> Option<T>,
) -> Option<T> {
    entry.std.as_ref().and_then(f)
}

fn compare_rho_d(
    found: &GroupEntry,
    folder: &Path,
    wanted: &GroupEntry,
    score: &mut GroupScore,
) -> Result<(), FileError> {
    let wanted = wanted.seen_albedo();
    let mut albedo = found.seen_albedo();
    if albedo.is_none() && wanted.is_some() {
        albedo = found_texture(found, folder)?.map(|t| mean_of(&t.image).to_array());
    }
    compare_triple("rho_d", albedo, wanted, std_of_albedo(found), score);
    Ok(())
}

/// The standard deviation of the diffuse reflectance as it is seen.
fn std_of_albedo(found: &GroupEntry) -> Option<[f32; 3]> {
    let share = found.base_seen();
    std_of(found, |s| s.rho_d).map(|std| std.map(|std| std * share))
}

fn compare_triple(
    key: &'static str,
    found: Option<[f32; 3]>,
    wanted: Option<[f32; 3]>,
    std: Option<[f32; 3]>,
    score: &mut GroupScore,
) {
    let Some(wanted) = wanted else { return };
    let Some(found) = found else {
        score.missing.push(key);
        return;
    };
    let error: [f64; 3] =
        std::array::from_fn(|c| (f64::from(found[c]) - f64::from(wanted[c])).abs());
    note(key, &error, std, score);
    if key == "rho_d" {
        score.rho_d = Some(largest_of(&error));
    } else {
        score.rho_s = Some(largest_of(&error));
    }
}

fn compare_lobes(found: &GroupEntry, wanted: &GroupEntry, score: &mut GroupScore) {
    let Some(truth) = Lobe::of(wanted).filter(|lobe| lobe.alphas[0] > 0.0) else { return };
    let Some(lobe) = Lobe::of(found) else {
        score.missing.push("alpha_x or alpha_y");
        return;
    };
    let error = |i: usize| (lobe.alphas[i] - truth.alphas[i]).abs();
    let percent = |i: usize| 100.0 * error(i) / truth.alphas[i];
    score.alpha_percent = Some(percent(0).max(percent(1)));
    // The two alphas of a lobe without a direction are one parameter.
    let is_one = [&lobe, &truth].iter().all(|lobe| lobe.alphas[0] == lobe.alphas[1]);
    for (key, i) in lobe.places().into_iter().take(if is_one { 1 } else { 2 }) {
        note(key, &[error(i)], lobe.stds[i].map(|std| [std]), score);
    }
    if truth.is_anisotropic() {
        score.degrees = lobe.degrees_from(&truth);
        match score.degrees {
            Some(degrees) => {
                let std = std_of(found, |s| s.theta_deg).map(|std| [std]);
                note("theta_deg", &[degrees], std, score);
            }
            None => score.missing.push("direction or theta_deg"),
        }
    }
}

/// Records a parameter if the results state its standard deviation.
fn note<const N: usize>(
    key: &'static str,
    error: &[f64; N],
    std: Option<[f32; N]>,
    score: &mut GroupScore,
) {
    score.parameters.extend(std.map(|std| ParameterScore::new(key, error, &std)));
}

fn largest_of(errors: &[f64; 3]) -> f64 {
    errors.iter().copied().fold(0.0, f64::max)
}

/// The group's texture as it is seen; without one, its mean rho_d; none if that is missing too.
fn found_texture(found: &GroupEntry, folder: &Path) -> Result<Option<Texture>, FileError> {
    let image = match (&found.texture, found.rho_d) {
        (Some(path), _) => read_texture_beside(folder, path, Limits::default())?.0,
        (None, Some(rho_d)) => Image::new(1, 1, vec![Rgb::from_array(rho_d)]),
        (None, None) => return Ok(None),
    };
    let texture = Texture { image, wrap_u: Wrap::ClampToEdge, wrap_v: Wrap::ClampToEdge };
    Ok(Some(texture.scaled(found.base_seen())))
}

/// The mean error over the texels of `truth`, per channel.
fn texture_error(found: &Texture, truth: &Image<Rgb>) -> [f64; 3] {
    let (width, height) = (truth.width() as f32, truth.height() as f32);
    let mut sum = [0.0f64; 3];
    for y in 0..truth.height() {
        for x in 0..truth.width() {
            let uv = Vec2::new((x as f32 + 0.5) / width, (y as f32 + 0.5) / height);
            let error = (found.sample(uv) - *truth.at(x, y)).abs().to_array();
            (0..3).for_each(|c| sum[c] += f64::from(error[c]));
        }
    }
    sum.map(|sum| sum / truth.pixels().len() as f64)
}
