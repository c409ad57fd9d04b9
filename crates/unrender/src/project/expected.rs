//! A project's bounds and initial values of a group's parameters: the keys `rho_d`, `rho_s`,
//! `alpha_x`, `alpha_y` and `theta_deg` of `[groups.NAME]`, each with a start and, except for the
//! direction, with bounds.

use super::raw::{RawBounds, RawGroup, RawStart};
use super::values::{number, reflectance};
use std::collections::BTreeMap;
use toml::Value;
use unrender_recover::Expected;
use unrender_scene::reflectance::ALPHA_RANGE;
use unrender_scene::{BrdfModel, Hypothesis, Rgb};

/// The keys that are stated for a group.
pub(super) fn stated(group: &RawGroup) -> Vec<&'static str> {
    let keys = [
        ("rho_d", group.rho_d.is_some()),
        ("rho_s", group.rho_s.is_some()),
        ("alpha_x", group.alpha_x.is_some()),
        ("alpha_y", group.alpha_y.is_some()),
        ("theta_deg", group.theta_deg.is_some()),
    ];
    keys.into_iter().filter(|(_, is_stated)| *is_stated).map(|(key, _)| key).collect()
}

/// The bounds and starts of all `groups`; `rungs_of` gives the hypotheses that one may have, and
/// `anchored` is the group that fixes the scale.
pub(super) fn all<'a>(
    groups: &BTreeMap<String, RawGroup>,
    rungs_of: &dyn Fn(&String) -> &'a [Hypothesis],
    anchored: Option<&str>,
    brdf: BrdfModel,
) -> Result<BTreeMap<String, Expected>, String> {
    let mut all = BTreeMap::new();
    for (name, group) in groups {
        let Some(expected) = read(name, group, rungs_of(name), brdf)? else { continue };
        if anchored == Some(name.as_str()) {
            return Err(format!(
                "groups.{name}: [anchor] states its reflectance; leave out {}",
                stated(group)[0]
            ));
        }
        all.insert(name.clone(), expected);
    }
    Ok(all)
}

/// The bounds and starts of the group `name`, which may have the hypotheses `rungs`; none if none
/// are stated.
fn read(
    name: &str,
    group: &RawGroup,
    rungs: &[Hypothesis],
    brdf: BrdfModel,
) -> Result<Option<Expected>, String> {
    let stated = stated(group);
    if stated.is_empty() {
        return Ok(None);
    }
    let key = format!("groups.{name}");
    if group.known.is_some() || group.ignore {
        let reason = if group.ignore { "ignore = true" } else { "known" };
        return Err(format!("{key}: with {reason} nothing is recovered; leave out {}", stated[0]));
    }
    for number in stated {
        are_free(&key, number, rungs)?;
    }
    let mut expected = Expected::default();
    let Expected { bounds, start, .. } = &mut expected;
    start.rho_d = interval(&key, "rho_d", &group.rho_d, &mut bounds.rho_d)?;
    start.rho_s = interval(&key, "rho_s", &group.rho_s, &mut bounds.rho_s)?;
    start.alpha_x = interval(&key, "alpha_x", &group.alpha_x, &mut bounds.alpha_x)?;
    start.alpha_y = interval(&key, "alpha_y", &group.alpha_y, &mut bounds.alpha_y)?;
    start.theta_rad = direction(&key, &group.theta_deg)?;
    agree(&key, &expected, rungs, brdf)?;
    Ok(Some(expected))
}

/// Checks that one of `rungs` has the parameter `number`.
fn are_free(key: &str, number: &str, rungs: &[Hypothesis]) -> Result<(), String> {
    use Hypothesis::{Anisotropic, Diffuse, DiffuseSpecular, Isotropic, PartialMirror, Textured};
    let of: &[Hypothesis] = match number {
        "rho_d" => &[Diffuse, DiffuseSpecular, Isotropic, Anisotropic, Textured],
        "rho_s" => &[PartialMirror, DiffuseSpecular, Isotropic, Anisotropic],
        "alpha_x" => &[Isotropic, Anisotropic],
        _ => &[Anisotropic],
    };
    if rungs.iter().any(|rung| of.contains(rung)) {
        return Ok(());
    }
    let names =
        |rungs: &[Hypothesis]| rungs.iter().map(|rung| rung.name()).collect::<Vec<_>>().join(", ");
    Err(format!(
        "{key}.{number}: none of the hypotheses that the group may have ({}) has it; it belongs to \
         {}",
        names(rungs),
        names(of)
    ))
}

/// Checks that bounds and starts of different parameters do not contradict each other.
fn agree(
    key: &str,
    expected: &Expected,
    rungs: &[Hypothesis],
    brdf: BrdfModel,
) -> Result<(), String> {
    let Expected { bounds, start, .. } = expected;
    if bounds.alpha_x[0] > bounds.alpha_y[1] {
        return Err(format!(
            "{key}: alpha_x.min is above alpha_y.max, but alpha_x is the lesser of the two roughnesses"
        ));
    }
    if start.alpha_x.zip(start.alpha_y).is_some_and(|(x, y)| x > y) {
        return Err(format!(
            "{key}: alpha_x.start is above alpha_y.start, but alpha_x is the lesser of the two \
             roughnesses; exchange them, and turn theta_deg by 90"
        ));
    }
    if brdf.is_bounded() && (bounds.rho_d[0] + bounds.rho_s[0]).max_element() > 1.0 {
        return Err(format!(
            "{key}: rho_d.min and rho_s.min together are above 1, more than {} reflects",
            brdf.name()
        ));
    }
    if !rungs.iter().any(|rung| bounds.allow(*rung)) {
        let names: Vec<&str> = rungs.iter().map(|rung| rung.name()).collect();
        return Err(format!(
            "{key}: none of the hypotheses that the group may have ({}) can keep its bounds",
            names.join(", ")
        ));
    }
    Ok(())
}

/// A parameter of a group that has an interval.
trait Bounded: Copy {
    /// Reads the value of `key`.
    fn read(key: &str, value: &Value) -> Result<Self, String>;

    /// Whether it is at most `other` in every channel.
    fn is_at_most(self, other: Self) -> bool;
}

impl Bounded for Rgb {
    fn read(key: &str, value: &Value) -> Result<Self, String> {
        reflectance(key, value)
    }

    fn is_at_most(self, other: Self) -> bool {
        self.cmple(other).all()
    }
}

impl Bounded for f32 {
    fn read(key: &str, value: &Value) -> Result<Self, String> {
        let [low, high] = ALPHA_RANGE;
        let alpha = number(value).filter(|alpha| (low..=high).contains(alpha));
        alpha.ok_or_else(|| {
            format!("{key} is {value}; an unknown roughness is from {low} to {high}")
        })
    }

    fn is_at_most(self, other: Self) -> bool {
        self <= other
    }
}

/// Reads the table of one parameter `number` into `bounds`; returns the start, if it has one.
fn interval<T: Bounded>(
    key: &str,
    number: &str,
    raw: &Option<RawBounds>,
    bounds: &mut [T; 2],
) -> Result<Option<T>, String> {
    let Some(RawBounds { start, min, max }) = raw else { return Ok(None) };
    let key = format!("{key}.{number}");
    let read = |name: &str, value: &Option<Value>| {
        value.as_ref().map(|value| T::read(&format!("{key}.{name}"), value)).transpose()
    };
    let [start, min, max] = [read("start", start)?, read("min", min)?, read("max", max)?];
    if start.is_none() && min.is_none() && max.is_none() {
        return Err(format!("{key}: give start, min or max"));
    }
    *bounds = [min.unwrap_or(bounds[0]), max.unwrap_or(bounds[1])];
    if !bounds[0].is_at_most(bounds[1]) {
        return Err(format!("{key}: min is above max"));
    }
    if let Some(start) = start {
        for (name, is_kept) in
            [("min", bounds[0].is_at_most(start)), ("max", start.is_at_most(bounds[1]))]
        {
            if !is_kept {
                return Err(format!("{key}: start lies beyond {name}"));
            }
        }
    }
    Ok(start)
}

/// The initial direction, radians.
fn direction(key: &str, raw: &Option<RawStart>) -> Result<Option<f32>, String> {
    let Some(RawStart { start }) = raw else { return Ok(None) };
    match number(start).filter(|theta| theta.is_finite()) {
        Some(theta) => Ok(Some(theta.to_radians())),
        None => Err(format!("{key}.theta_deg.start is {start}; give an angle in degrees")),
    }
}
