//! The key `status` of a group in `materials.json`: where its numbers come from.

use super::Status;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Where the numbers of a group come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StatusEntry {
    /// From a recovery, or as the project gives them.
    Of(Status),
    /// The project leaves the group out (`ignore`): its numbers are those of the scene.
    Ignored,
    /// Its numbers are those of the group of this name, whose material it shares (`same_as`).
    SameAs(String),
}

const IGNORED: &str = "ignored";
const SAME_AS: &str = "same as ";

impl StatusEntry {
    /// Whether it is this status of a recovery.
    pub fn is(&self, status: Status) -> bool {
        *self == Self::Of(status)
    }
}

impl fmt::Display for StatusEntry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Of(status) => status.fmt(f),
            Self::Ignored => f.pad(IGNORED),
            Self::SameAs(name) => write!(f, "{SAME_AS}{name}"),
        }
    }
}

impl Serialize for StatusEntry {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for StatusEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        if let Some(name) = text.strip_prefix(SAME_AS) {
            return Ok(Self::SameAs(name.to_owned()));
        }
        let all =
            [Status::Recovered, Status::Known, Status::Assumed, Status::Doubtful].map(Self::Of);
        let mut all = all.into_iter().chain([Self::Ignored]);
        all.find(|status| status.to_string() == text).ok_or_else(|| {
            serde::de::Error::custom(format!(
                "there is no status \"{text}\"; there are recovered, known, assumed, doubtful, {IGNORED} and \
                 \"{SAME_AS}NAME\""
            ))
        })
    }
}
