//! The key `like`: groups whose materials are about the same.

use super::raw::{RawGroup, RawLike};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The default of `within`: the relative difference between similar groups. Half of it is the difference of
/// one paint from wall to wall; double of it that of two dyes of one colour.
const WITHIN: f32 = 0.1;

/// The group that another one is like.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LikeGroup {
    /// Its name.
    pub group: String,
    /// The standard deviation of the differences, as a share of the parameters.
    pub within: f32,
}

/// The similar group of each of the `groups` that states one; `anchored` is the group that fixes the scale.
pub(super) fn all(
    groups: &BTreeMap<String, RawGroup>,
    anchored: Option<&str>,
) -> Result<BTreeMap<String, LikeGroup>, String> {
    let mut all = BTreeMap::new();
    for (name, group) in groups {
        let Some(RawLike { group: other, within }) = &group.like else { continue };
        let fault = |problem: &str| Err(format!("groups.{name}.like: {problem}"));
        let within = within.unwrap_or(WITHIN);
        if !(within > 0.0 && within <= 1.0) {
            return fault(&format!(
                "within is {within}; give a share above 0 and up to 1, say 0.1 for 10 %"
            ));
        }
        if other == name {
            return fault("it names the group itself; name another");
        }
        if group.known.is_some() || group.ignore || anchored == Some(name.as_str()) {
            return fault("the group itself is not recovered; leave it out");
        }
        if let Some(named) = groups.get(other) {
            if let Some(third) = &named.same_as {
                return fault(&format!("groups.{other} has same_as = \"{third}\"; name that one"));
            }
            if named.ignore && named.known.is_none() {
                return fault(&format!("groups.{other} has ignore = true; name another group"));
            }
            if named.like.as_ref().is_some_and(|back| back.group == *name) {
                return fault(&format!(
                    "groups.{other} is like \"{name}\" already; state it for one of the two"
                ));
            }
        }
        all.insert(name.clone(), LikeGroup { group: other.clone(), within });
    }
    Ok(all)
}
