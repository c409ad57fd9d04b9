//! Converts the raw project to a checked one; every error names its key.

use super::raw::{RawAnchor, RawGroup, RawProject};
use super::values::reflectance;
use super::{Anchor, Project, expected, known, lights, like, rungs, taken};
use crate::lighting::RawLight;
use crate::up_axis;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use unrender_formats::{LightUnits, Limits};
use unrender_paper::Paper;
use unrender_photo::Exposure;
use unrender_recover::Thresholds;
use unrender_restage::light::LightEdit;
use unrender_scene::{BrdfModel, ENVIRONMENT, Hypothesis, Layering, Warnings};

pub(super) fn parse(path: &Path, text: &str) -> Result<(Project, Warnings), String> {
    let raw: RawProject = toml::from_str(text).map_err(|error| with_line(&error, text))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut warnings = Warnings::default();
    let anchor = raw.anchor.as_ref().map(anchor).transpose()?;
    let mut taken = taken::all(&raw, folder, anchor.is_some(), &mut warnings)?;
    let first = taken.remove(0);
    let up_axis = up_axis::settled(raw.up_axis, first.camera.up_axis(), &mut warnings);
    let is_around_unknown = raw.environment.as_ref().is_some_and(|table| table.is_unknown());
    let any_light_unknown =
        is_around_unknown || raw.lights.unknown.iter().any(|(_, unknown)| *unknown);
    if anchor.is_some() && first.exposure != Exposure::Auto && !any_light_unknown {
        warnings.push("[anchor] was not used, as the exposure is stated and no light is unknown");
    }
    let group_rungs = group_rungs(&raw.groups)?;
    let ignored = ignored(&raw.groups)?;
    let same_as = same_as(&raw.groups)?;
    anchor.as_ref().map_or(Ok(()), |anchor| check_anchor(&anchor.group, &same_as, &ignored))?;
    let (list, max) = (raw.recover.rungs.as_deref(), raw.recover.max_rung.as_deref());
    let rungs = rungs::read("recover", list, max)?;
    let named_lights = |unknown| {
        let named = raw.lights.unknown.iter().filter(move |(_, is)| *is == unknown);
        let around = (unknown && is_around_unknown).then(|| ENVIRONMENT.to_owned());
        named.map(|(name, _)| name.clone()).chain(around).collect()
    };
    let environment = raw.environment.as_ref();
    let environment = environment.map(|table| table.choice(&|file| folder.join(file)));
    let brdf = raw.recover.brdf.as_deref().map(str::parse::<BrdfModel>).transpose();
    let brdf = brdf.map_err(|problem| format!("recover.brdf: {problem}"))?;
    let layering = raw.recover.layering.as_deref().map(str::parse::<Layering>).transpose();
    let layering = layering.map_err(|problem| format!("recover.layering: {problem}"))?;
    if layering.is_some() && brdf.is_some_and(|brdf| !brdf.is_principled()) {
        return Err("recover.layering: it is for brdf = \"principled\"; leave it out".into());
    }
    let brdf = brdf.map(|brdf| brdf.with_layering(layering));
    let rungs_of = |name: &String| {
        let stated = group_rungs.get(name).or(rungs.as_ref());
        stated.map_or(&Hypothesis::ALL[..], Vec::as_slice)
    };
    let anchored = anchor.as_ref().map(|anchor| anchor.group.as_str());
    let expected = expected::all(&raw.groups, &rungs_of, anchored, brdf.unwrap_or_default())?;
    let like = like::all(&raw.groups, anchored)?;
    let light_units = raw.light_units.as_deref().map(str::parse::<LightUnits>).transpose();
    let (thresholds, paper_thresholds) = thresholds(&raw.recover.thresholds)?;
    let project = Project {
        path: path.to_owned(),
        scene: folder.join(&raw.scene),
        photo: first.photo,
        bracket: first.bracket,
        mask: first.mask,
        response: first.response,
        black_level: first.black_level,
        white_level: first.white_level,
        vignetting: first.vignetting,
        exposure: first.exposure,
        camera: first.camera,
        switched: first.switched,
        further: taken,
        anchor,
        known: known::all(&raw.groups, folder)?,
        ignored,
        unknown_lights: named_lights(true),
        known_lights: named_lights(false),
        light_colors: lights::colors(&raw.lights.list)?,
        light_edits: light_edits(&raw.lights.list, folder, &mut warnings)?,
        light_profiles: light_profiles(&raw.lights.list, folder),
        environment: environment.transpose()?,
        brdf,
        layering,
        thresholds,
        paper_thresholds,
        rungs,
        group_rungs,
        expected,
        like,
        same_as,
        light_units: light_units.map_err(|problem| format!("light_units: {problem}"))?,
        up_axis,
        limits: Limits::default(),
    };
    Ok((project, warnings))
}

fn with_line(error: &toml::de::Error, text: &str) -> String {
    let message = error.message();
    let Some(before) = error.span().and_then(|span| text.get(..span.start)) else {
        return message.to_owned();
    };
    let index = before.matches('\n').count();
    let hint = text.lines().nth(index).and_then(|line| hint_of_lights(message, line));
    format!("line {}: {message}{}", index + 1, hint.unwrap_or_default())
}

/// A hint about the two forms of lights, of which `[lights.NAME]` has fewer keys.
fn hint_of_lights(message: &str, line: &str) -> Option<&'static str> {
    const COLOURS: [&str; 4] = ["`color`", "`colour`", "`same_color_as`", "`same_colour_as`"];
    let key = line.trim_start().trim_start_matches('[').trim_start();
    let unknown = message.strip_prefix("unknown field ");
    let is_alone = message.ends_with("expected `unknown`");
    if is_alone && unknown.is_some_and(|of| COLOURS.iter().any(|key| of.starts_with(key))) {
        return Some(
            "; the colour of an unknown light goes into a list: instead of [lights.NAME] write [[lights]] with \
             name = \"NAME\", unknown = true, and its colour",
        );
    }
    // In TOML, a table after a list belongs to the last entry of it.
    let is_twice = message.contains("duplicate key") && key.starts_with("lights");
    let is_behind = key.starts_with("lights.") && unknown.is_some() && !is_alone;
    (is_twice || is_behind).then_some(
        "; lights are a list [[lights]] or tables [lights.NAME], not both in one file: write the table as an entry of \
         the list, [[lights]] with name = \"NAME\" and unknown = true",
    )
}

/// The hypotheses of groups that state their own.
fn group_rungs(
    groups: &BTreeMap<String, RawGroup>,
) -> Result<BTreeMap<String, Vec<Hypothesis>>, String> {
    let mut all = BTreeMap::new();
    for (name, group) in groups {
        let (list, max) = (group.rungs.as_deref(), group.max_rung.as_deref());
        if let Some(list) = rungs::read(&format!("groups.{name}"), list, max)? {
            all.insert(name.clone(), list);
        }
    }
    Ok(all)
}

/// Checks that the group `anchor` is recovered, under its own name.
fn check_anchor(
    anchor: &str,
    same_as: &BTreeMap<String, String>,
    ignored: &BTreeSet<String>,
) -> Result<(), String> {
    if let Some(other) = same_as.get(anchor) {
        return Err(format!(
            "anchor.group: groups.{anchor} has same_as = \"{other}\"; take that one"
        ));
    }
    if ignored.contains(anchor) {
        return Err(format!("anchor.group: groups.{anchor} has ignore = true; take another group"));
    }
    Ok(())
}

/// The groups that are ignored.
fn ignored(groups: &BTreeMap<String, RawGroup>) -> Result<BTreeSet<String>, String> {
    let ignored = groups.iter().filter(|(_, group)| group.ignore);
    let name = |(name, group): (&String, &RawGroup)| match &group.rungs_key() {
        Some(key) => {
            Err(format!("groups.{name}: with ignore = true nothing is recovered; leave out {key}"))
        }
        None => Ok(name.clone()),
    };
    ignored.map(name).collect()
}

/// The groups that share another's material, by their names.
fn same_as(groups: &BTreeMap<String, RawGroup>) -> Result<BTreeMap<String, String>, String> {
    let mut same_as = BTreeMap::new();
    for (name, group) in groups {
        let Some(other) = &group.same_as else { continue };
        let fault = |problem: &str| Err(format!("groups.{name}.same_as: {problem}"));
        if other == name {
            return fault("it names the group itself; name another");
        }
        if let Some(third) = groups.get(other).and_then(|other| other.same_as.as_ref()) {
            return fault(&format!(
                "groups.{other} has same_as = \"{third}\" itself; name one group in all of them"
            ));
        }
        let stated_number = expected::stated(group).first().copied();
        let stated = [
            ("known", group.known.is_some()),
            ("ignore", group.ignore),
            (group.rungs_key().unwrap_or_default(), group.rungs_key().is_some()),
            (stated_number.unwrap_or_default(), stated_number.is_some()),
            ("like", group.like.is_some()),
        ];
        if let Some((key, _)) = stated.iter().find(|(_, is_there)| *is_there) {
            return fault(&format!("{key} belongs to groups.{other}, and applies to both"));
        }
        same_as.insert(name.clone(), other.clone());
    }
    Ok(same_as)
}

/// The IES files of the lights.
fn light_profiles(list: &[RawLight], folder: &Path) -> Vec<PathBuf> {
    list.iter().filter_map(|light| light.profile.as_ref()).map(|file| folder.join(file)).collect()
}

/// The changes of the scene's lights, each light once.
fn light_edits(
    list: &[RawLight],
    folder: &Path,
    warnings: &mut Warnings,
) -> Result<Vec<LightEdit>, String> {
    let mut edits: Vec<LightEdit> = Vec::new();
    for raw in list {
        let name = &raw.name;
        let fault = |problem: &str| format!("lights.{name}: {problem}");
        if edits.iter().any(|edit| edit.name == *name) {
            return Err(fault("the list [[lights]] has this name twice; put both into one"));
        }
        if raw.on.is_some() {
            return Err(fault(
                "on is a key of edit files; lights_off in [[photos]] states which lights were off, or scale = 0",
            ));
        }
        if raw.remove && raw.unknown.is_some() {
            return Err(fault("a light that is removed has no brightness; leave out unknown"));
        }
        let edit = raw.edit(&|file| folder.join(file), Limits::default(), warnings);
        edits.push(edit.map_err(|problem| fault(&problem))?);
    }
    Ok(edits)
}

fn anchor(raw: &RawAnchor) -> Result<Anchor, String> {
    let rho_d = reflectance("anchor.rho_d", &raw.rho_d)?;
    if rho_d.min_element() <= 0.0 {
        return Err("anchor.rho_d: a channel is zero, which cannot fix the scale".into());
    }
    Ok(Anchor { group: raw.group.clone(), rho_d })
}

/// The table `[recover] thresholds`: those of the default ladder by their names, and those of the paper's by the rung that
/// a group leaves above them.
fn thresholds(raw: &BTreeMap<String, f64>) -> Result<(Thresholds, [f64; 6]), String> {
    let (mut thresholds, mut of_paper) = (Thresholds::default(), Paper::default().thresholds);
    for (name, &value) in raw {
        if !(value.is_finite() && value > 0.0) {
            return Err(format!("recover.thresholds.{name} is {value}; it must be positive"));
        }
        let rung = unrender_recover::hypothesis::UNIFORM.iter().position(|h| h.name() == name);
        match (name.as_str(), rung) {
            ("explained", _) => thresholds.explained = value,
            ("simpler", _) => thresholds.simpler = Some(value),
            ("textured", _) => thresholds.textured = value,
            ("dispersion", _) => thresholds.dispersion = value,
            (_, Some(rung)) => of_paper[rung] = value,
            _ => {
                let rungs = unrender_recover::hypothesis::UNIFORM.map(|h| h.name()).join(", ");
                return Err(format!(
                    "recover.thresholds.{name}: there is no such threshold; there are explained, \
                     simpler, textured, dispersion, and for the paper's ladder {rungs}"
                ));
            }
        }
    }
    Ok((thresholds, of_paper))
}
