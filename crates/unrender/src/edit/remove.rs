//! `[[remove]]`: objects and groups that are removed.

use serde::Deserialize;
use unrender_restage::Edit;
use unrender_restage::remove::{Bearer, Remove};

/// One entry as in TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRemove {
    pub(super) name: Option<String>,
    object: Option<String>,
    group: Option<String>,
}

impl RawRemove {
    /// The edit of this entry.
    pub(super) fn edit(&self) -> Result<Edit, String> {
        let (name, what) = match (&self.name, &self.object, &self.group) {
            (Some(name), None, None) => (name, Bearer::Any),
            (None, Some(name), None) => (name, Bearer::Object),
            (None, None, Some(name)) => (name, Bearer::Group),
            _ => return Err("remove: give one of name, object and group".into()),
        };
        Ok(Edit::Remove(Remove { name: name.clone(), what }))
    }
}
