//! Group by group: how many pixels show it and are valid, whether it is lit, and what shows its
//! roughness.

use super::finding::{Findings, Gravity};
use super::identifiability::RoughnessCue;
use super::uvs::UvFault;
use super::{Subject, some};
use serde::Serialize;
use unrender_recover::{PixelStatus, Role};

/// Below this many valid pixels, the noise of a photograph shows in the second digit.
const FEW: usize = 40;
/// A group with less light than this share of the groups' median is in the dark.
const DARK: f32 = 0.02;
/// A group is mostly clipped from this share of its pixels on.
const CLIPPED: f32 = 0.5;

/// The role of a group that the project leaves out.
pub(super) const IGNORED: &str = "ignored";
/// The beginning of the role of a group that shares the material of another.
pub(super) const SAME_AS: &str = "same as ";

/// The pixels and the light of one group in the photograph.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GroupCheck {
    /// Its name.
    pub name: String,
    /// "unknown", "known", "emitter", "ignored", or "same as NAME", whose pixels are counted there.
    pub role: String,
    /// Pixels that show it.
    pub pixels: usize,
    /// The valid ones of them.
    pub valid: usize,
    /// Invalid ones because the photograph is clipped, too dark or without a measurement there, or
    /// the project masks them.
    pub clipped: usize,
    /// Invalid ones because an edge is too close.
    pub edge: usize,
    /// Invalid ones because they are single outliers.
    pub spike: usize,
    /// The share of it in the picture that gets light straight from a lamp; none if it is unseen or
    /// emits.
    pub lit: Option<f32>,
    /// "highlight", "mirror image", "highlight, mirror image" or "nothing"; none as above.
    pub roughness: Option<&'static str>,
    /// The largest contribution of a lamp and of the surroundings, relative to its diffuse light.
    pub contrast: Option<[f32; 2]>,
    /// Whether all its meshes have texture coordinates.
    pub texture_coordinates: bool,
    /// "uv overlaps" or "uv repeats", where they do and a texture is the average of all places that share a texel.
    pub texture_fault: Option<&'static str>,
}

/// One entry per group.
pub(super) fn all(subject: &Subject<'_>) -> Vec<GroupCheck> {
    (0..subject.specs.len()).map(|group| one(subject, group)).collect()
}

fn one(subject: &Subject<'_>, group: usize) -> GroupCheck {
    let observation = subject.observation;
    let all = &observation.all_pixels_of_group[group];
    let count = |status: PixelStatus| {
        all.iter().filter(|&&p| observation.status.pixels()[p as usize] == status).count()
    };
    let identifiability = subject.identifiabilities[group];
    let of_group = || subject.job.scene.objects.iter().filter(move |o| o.group == group);
    GroupCheck {
        name: subject.group_name(group).to_owned(),
        role: role(subject, group),
        pixels: all.len(),
        valid: observation.pixels_of_group[group].len(),
        clipped: count(PixelStatus::Clipped),
        edge: count(PixelStatus::Edge),
        spike: count(PixelStatus::Spike),
        lit: identifiability.map(|p| p.lit),
        roughness: identifiability.map(|p| match p.roughness_cue() {
            RoughnessCue::Highlight => "highlight",
            RoughnessCue::Image => "mirror image",
            RoughnessCue::Both => "highlight, mirror image",
            RoughnessCue::Nothing => "nothing",
        }),
        contrast: identifiability.map(|p| [p.highlight, p.image]),
        texture_coordinates: of_group().count() > 0
            && of_group().all(|object| !object.mesh.uvs.is_empty()),
        texture_fault: UvFault::of(&subject.job.scene, group).map(UvFault::word),
    }
}

fn role(subject: &Subject<'_>, group: usize) -> String {
    let (project, name) = (&subject.job.project, subject.group_name(group));
    if let Some(other) = project.same_as.get(name) {
        return format!("{SAME_AS}{other}");
    }
    match subject.specs[group].role {
        _ if project.ignored.contains(name) => IGNORED,
        Role::Unknown => "unknown",
        Role::Known => "known",
        Role::Emitter => "emitter",
    }
    .into()
}

/// Warnings of groups with too few pixels or too little light.
pub(super) fn warnings(subject: &Subject<'_>) -> Findings {
    let mut found = Findings::default();
    let unknown = || (0..subject.specs.len()).filter(|&g| subject.specs[g].role == Role::Unknown);
    let named = |groups: &dyn Fn(usize) -> bool| -> Vec<&str> {
        unknown().filter(|&g| groups(g)).map(|g| subject.group_name(g)).collect()
    };
    let all = |g: usize| subject.observation.all_pixels_of_group[g].len();
    let unseen = named(&|g| all(g) == 0);
    if !unseen.is_empty() {
        found.push(Gravity::Note, format!(
            "no pixel shows {}: a group that is not seen is recovered only from the light that it \
             sends to other surfaces; if you know its reflectance, state it as known in \
             [groups.NAME]",
            some(&unseen)
        ));
    }
    let checked: Vec<GroupCheck> =
        unknown().map(|g| one(subject, g)).filter(|check| check.pixels > 0).collect();
    let is_clipped = |check: &&GroupCheck| check.clipped as f32 > CLIPPED * check.pixels as f32;
    let (clipped, others): (Vec<&GroupCheck>, Vec<&GroupCheck>) =
        checked.iter().partition(is_clipped);
    let few: Vec<&GroupCheck> = others.into_iter().filter(|check| check.valid < FEW).collect();
    if !clipped.is_empty() {
        let sentence = format!(
            "most pixels of {} are clipped, masked, in the noise of black or without a measurement; take a photo of \
             another exposure",
            counted(&clipped, |check| format!("{} of {}", check.clipped, check.pixels))
        );
        found.push(Gravity::Note, sentence);
    }
    if !few.is_empty() {
        let sentence = format!(
            "fewer than {FEW} valid pixels show {}; give it the material of a larger, similar group, state it as known, \
             or use a larger photo",
            counted(&few, |check| check.valid.to_string())
        );
        found.push(Gravity::Note, sentence);
    }
    let light = |g: usize| subject.identifiabilities[g].map(|p| p.light);
    let usual = super::median((0..subject.specs.len()).filter_map(light)).unwrap_or(0.0);
    let dark = named(&|g| light(g).is_some_and(|light| light <= DARK * usual));
    if !dark.is_empty() {
        found.push(Gravity::Part, format!(
            "next to no light reaches {}: the reflectance of a surface in the dark cannot be recovered; is a lamp \
             missing from the scene, or something in its way?",
            some(&dark)
        ));
    }
    found
}

/// The names of groups with a number each, the largest groups first, no more than a few.
fn counted(groups: &[&GroupCheck], number: impl Fn(&GroupCheck) -> String) -> String {
    const MOST: usize = 5;
    let mut groups = groups.to_vec();
    groups.sort_by_key(|check| std::cmp::Reverse(check.pixels));
    let named = |check: &&GroupCheck| format!("\"{}\" ({})", check.name, number(check));
    let named: Vec<String> = groups.iter().take(MOST).map(named).collect();
    let more = match groups.len().saturating_sub(MOST) {
        0 => String::new(),
        1 => " and one more group".to_owned(),
        more => format!(" and {more} more groups"),
    };
    named.join(", ") + &more
}
