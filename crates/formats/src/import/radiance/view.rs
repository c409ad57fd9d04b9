//! View files: `-vp` where from, `-vd` where to, `-vu` upwards, `-vh` and `-vv` how wide.

use crate::entry::{Entry, Taken, find, read, refused, told};
use crate::input::Scope;
use glam::{DVec3, Vec3};
use std::path::Path;
use unrender_scene::{Camera, Lens, Warnings};

/// The options of a view, and how they are taken.
pub(super) const OPTIONS: [Entry; 11] = [
    read("-vtv", "a perspective; views of other kinds (-vtl, -vth, -vta, ...) are refused"),
    read("-vp", "where from"),
    read("-vd", "where to"),
    read("-vu", "upwards; (0, 0, 1) by default"),
    read("-vh", "the angle across, degrees; 45 by default"),
    read("-vv", "the angle upwards, degrees; 45 by default"),
    read("-vs", "how far the view is shifted to the right, in its widths"),
    read("-vl", "how far it is shifted upwards, in its heights"),
    told("-vo", "zero clips nothing; otherwise what it clips is seen here"),
    told("-va", "zero clips nothing; otherwise what it clips is seen here"),
    refused("-vtl", "its view is not a perspective (-vtv)"),
];

/// The camera of the view file that belongs to the scene at `path`, if there is one.
pub(super) fn beside(
    scope: &Scope,
    path: &Path,
    warnings: &mut Warnings,
) -> Result<Option<Camera>, String> {
    let candidates = [path.with_extension("vf"), path.with_file_name("view.vf")];
    let Some(found) = candidates.iter().find(|candidate| candidate.is_file()) else {
        return Ok(None);
    };
    let name = found.display();
    let folder = path.parent().unwrap_or(Path::new(""));
    let file = found.file_name().unwrap_or_default().to_string_lossy();
    let text = scope.beside(folder, &file).and_then(|path| scope.text(&path));
    let text = text.map_err(|problem| format!("{name} {problem}"))?;
    let words: Vec<&str> = text
        .lines()
        .rfind(|line| line.contains("-v"))
        .map_or(Vec::new(), |line| line.split_whitespace().collect());
    // Our export writes zero, which clips nothing.
    let cuts = OPTIONS.iter().filter(|option| option.taken == Taken::WarnedOf);
    for option in cuts.map(|option| option.name) {
        let value = words.iter().skip_while(|word| **word != option).nth(1);
        if value.is_some_and(|value| value.parse::<f32>().is_ok_and(|value| value > 0.0)) {
            warnings.push(format!("{name}: what {option} clips is seen here"));
        }
    }
    camera(&words, scope.origin()).map(Some).map_err(|problem| format!("{name}: {problem}"))
}

/// The camera of the view `words`, its position counted from `origin`.
fn camera(words: &[&str], origin: DVec3) -> Result<Camera, String> {
    let numbers = |option: &str, count: usize| -> Option<Vec<f64>> {
        let known = find(&OPTIONS, option).filter(|known| known.taken == Taken::Read)?;
        let at = words.iter().position(|word| *word == known.name)?;
        let these = words.get(at + 1..at + 1 + count)?;
        let finite = |v: &f64| (*v as f32).is_finite();
        these.iter().map(|word| word.parse().ok().filter(finite)).collect()
    };
    let point = |option: &str| numbers(option, 3).map(|v| DVec3::from_slice(&v));
    let vector = |option: &str| point(option).map(|v| v.as_vec3());
    let number = |option: &str| numbers(option, 1).map(|v| v[0] as f32);
    if words.iter().any(|word| word.starts_with("-vt") && *word != "-vtv") {
        let refused = OPTIONS.iter().find(|option| option.taken == Taken::Refused);
        return Err(refused.map_or("", |option| option.done).into());
    }
    let missing = |option: &str| format!("its view has no {option}");
    let eye = point("-vp").ok_or_else(|| missing("-vp"))?;
    let eye = (eye - origin).as_vec3();
    let ahead = vector("-vd").ok_or_else(|| missing("-vd"))?;
    let up = vector("-vu").unwrap_or(Vec3::Z);
    let [wide, high] = ["-vh", "-vv"].map(|o| number(o).unwrap_or(45.0).to_radians());
    let aspect = (0.5 * wide).tan() / (0.5 * high).tan();
    let shift = [number("-vs").unwrap_or(0.0), number("-vl").unwrap_or(0.0)];
    let camera = Camera::look_at("camera", eye, eye + ahead, up, high);
    let lens = Lens { principal_point: [-shift[0] * aspect, shift[1]], ..Lens::default() };
    Ok(Camera { aspect: Some(aspect), lens, ..camera })
}
