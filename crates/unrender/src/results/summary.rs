//! The table at the end: the results at a glance. Black lamps are left out.

use super::difference::Difference;
use crate::Job;
use crate::project::some_names;
use crate::recovered::{Recovered, entries, labels};
use crate::text_table::table;
use unrender_formats::materials::{PhotographEntry, StatusEntry};
use unrender_recover::{GroupResult, Recovery, Status, Termination};
use unrender_scene::{Hypothesis, Rgb};

const HEADER: [&str; 8] =
    ["group", "hypothesis", "rho_d", "rho_s", "alpha", "direction", "error", "pixels"];

/// The header and a row for each group that reflects something.
fn rows(job: &Job, recovery: &Recovery) -> ([&'static str; 8], Vec<[String; 8]>) {
    let reflects = |g: &&GroupResult| {
        g.status != Status::Known || (g.material.rho_d + g.material.rho_s).max_element() > 0.0
    };
    (HEADER, recovery.groups.iter().filter(reflects).map(|group| row(job, group)).collect())
}

/// The summary of a recovery: a line per group and per unknown light, then time and iterations.
pub(crate) fn summary(job: &Job, recovered: &Recovered) -> String {
    let recovery = &recovered.recovery;
    let (header, groups) = rows(job, recovery);
    let mut lines = vec![header.map(str::to_owned)];
    lines.extend(groups);
    let mut text = table(&lines);
    for (name, light) in entries::lights(job, recovered) {
        let [found, std] =
            [light.intensity, light.std].map(|v| rgb(Rgb::from_array(v.unwrap_or_default())));
        let what = if light.panorama.is_some() { "mean radiance" } else { "intensity" };
        text.push_str(&format!("{name}: {what} {found}, std {std}\n"));
    }
    for (k, found) in recovered.photographs.iter().enumerate() {
        let lines = found.as_ref().map_or(String::new(), photograph);
        for line in lines.lines() {
            text.push_str(&format!("{}{line}\n", job.called(k)));
        }
    }
    for group in &recovery.groups {
        if let Some(note) = &group.note {
            text.push_str(&format!("{}: {note}\n", group.name));
        }
    }
    let labels = labels::labels(&job.scene);
    for (group, parts) in recovered.parts(job) {
        let named =
            |part: &Vec<usize>| some_names(part.iter().map(|object| labels[*object].as_str()));
        text.push_str(&format!(
            "{}: one material does not explain all its objects: {}; unrender split splits it\n",
            recovery.groups[group].name,
            parts.iter().map(named).collect::<Vec<_>>().join(" | ")
        ));
    }
    for (name, others) in recovered.alike(job) {
        // Each pair once.
        let others: Vec<&str> = others.into_iter().filter(|other| *other > name).collect();
        if !others.is_empty() {
            text.push_str(&format!(
                "{name}: agrees with {} within the standard deviations; if they are one \
                 material, state it by same_as\n",
                some_names(others.into_iter())
            ));
        }
    }
    if job.side > 1 {
        text.push_str(&format!("the photo was reduced to squares of {0} x {0} pixels\n", job.side));
    }
    text.push_str(&outcome(job, recovered));
    text
}

/// How it came out, in a sentence or three: the statuses of the groups, how far the re-rendering is from the photograph, and
/// why it ended.
fn outcome(job: &Job, recovered: &Recovered) -> String {
    let recovery = &recovered.recovery;
    let of = |status: Status| -> Vec<&str> {
        let groups = recovery.groups.iter().filter(|group| group.status == status);
        groups.map(|group| group.name.as_str()).collect()
    };
    let (done, doubtful) = (of(Status::Recovered).len(), of(Status::Doubtful));
    let groups = if done == 1 { "group" } else { "groups" };
    let mut text = format!("{done} {groups} recovered, ");
    // The whole picture may match where groups do not.
    let subject =
        if doubtful.is_empty() { "The re-rendering" } else { "Over all pixels, the re-rendering" };
    match doubtful.len() {
        0 => text.push_str("none doubtful"),
        count => text.push_str(&format!("{count} doubtful ({})", some_names(doubtful.into_iter()))),
    }
    match of(Status::Assumed).len() {
        0 => {}
        count => text.push_str(&format!(", {count} assumed")),
    }
    text.push_str(". ");
    if job.photographs() == 1 {
        let [beyond, noise, _] = Difference::of(job, recovery).means();
        text.push_str(&match beyond > 0.0 {
            true => format!(
                "{subject} differs from the photo by {}, beside noise of {}. ",
                share(beyond),
                share(noise)
            ),
            false => format!("{subject} matches the photo within noise of {}. ", share(noise)),
        });
    }
    let passes = match recovery.iterations.len() {
        1 => "1 pass".to_owned(),
        count => format!("{count} passes"),
    };
    let seconds = format!("{:.0} s", recovered.times.all);
    text.push_str(&match recovery.termination {
        Termination::Settled | Termination::Refined => {
            format!("(Converged after {passes}, {seconds}.)\n")
        }
        Termination::IterationLimit | Termination::RefinementLimit => format!(
            "(Stopped after {passes}, {seconds}, before all parameters had settled: some still moved by more than their \
             standard deviation.)\n"
        ),
        Termination::Interrupted => format!(
            "(Interrupted after {passes}, {seconds}: the results are as far as it had come.)\n"
        ),
        other => format!("({}, {seconds}.)\n", other.message(recovery.iterations.len())),
    });
    text
}

/// A share in percent.
fn share(value: f64) -> String {
    if value < 0.0005 { "less than 0.1 %".to_owned() } else { format!("{:.1} %", 100.0 * value) }
}

/// The photometric parameters, a line each.
fn photograph(found: &PhotographEntry) -> String {
    let std = found.std.clone().unwrap_or_default();
    let with_std = |std: Option<f64>| std.map_or(String::new(), |std| format!(", std {std:.4}"));
    let mut text = String::new();
    if let Some(gamma) = found.gamma {
        text.push_str(&format!("response: gamma {gamma:.4}{}\n", with_std(std.gamma)));
    }
    if let Some([r, g, b]) = found.exposure {
        let std =
            std.exposure.map_or(String::new(), |[r, g, b]| format!(", std {r:.4} {g:.4} {b:.4}"));
        text.push_str(&format!("exposure: {r:.4} {g:.4} {b:.4}{std}\n"));
    }
    if let (Some([a1, a2, a3]), Some(corner)) = (found.vignetting, found.corner) {
        text.push_str(&format!(
            "vignetting: radial {a1:.3} {a2:.3} {a3:.3}; {corner:.4} of the light in the corners{}\n",
            with_std(std.corner)
        ));
    }
    if let Some(note) = &found.note {
        text.push_str(&format!("photo: {note}\n"));
    }
    text
}

fn rgb(v: Rgb) -> String {
    format!("{:.3} {:.3} {:.3}", v.x, v.y, v.z)
}

fn row(job: &Job, group: &GroupResult) -> [String; 8] {
    let material = &group.material;
    let dash = || "-".to_owned();
    let specular = material.rho_s.max_element() > 0.0;
    let hypothesis = match entries::status(job, group) {
        StatusEntry::Of(Status::Recovered) => group.hypothesis.named(material).to_string(),
        other => format!("{} ({other})", group.hypothesis.named(material)),
    };
    let alpha = match group.hypothesis {
        Hypothesis::Isotropic => format!("{:.4}", material.alpha_x),
        Hypothesis::Anisotropic => format!("{:.4} {:.4}", material.alpha_x, material.alpha_y),
        _ => dash(),
    };
    let direction = if group.hypothesis == Hypothesis::Anisotropic {
        format!("{:.1} deg", material.theta_rad.to_degrees())
    } else {
        dash()
    };
    [
        group.name.clone(),
        hypothesis,
        rgb(material.rho_d),
        if specular { rgb(material.rho_s) } else { dash() },
        alpha,
        direction,
        group.error.map_or_else(dash, |e| format!("{:.2} %", 100.0 * e)),
        group.pixels.to_string(),
    ]
}
