//! The list of rooms, from `benches/rooms/rooms.json`.

use crate::Failure;
use serde::Deserialize;
use serde_json::Value;
use std::path::Path;

/// The list; the scripts read the same one.
const LIST: &str = include_str!("../../rooms/rooms.json");
/// A trial's pictures have this many times fewer pixels in a row and in a column: an eighth of the time with
/// the fewer samples, and every step is still tested.
const QUICK_SHRINK: u64 = 2;

/// All rooms, and what others published about them.
pub(crate) struct Rooms {
    pub(crate) all: Vec<Room>,
    pub(crate) published: Vec<Published>,
    /// The list for the scripts.
    pub(super) text: Value,
}

/// One room.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Room {
    #[serde(skip)]
    pub(crate) name: String,
    /// The scene file, from the folder of the trees.
    pub(crate) file: String,
    /// Width and height of the photograph, pixels.
    pub(crate) size: (usize, usize),
    pub(crate) title: String,
    /// What others changed in it.
    #[serde(default)]
    pub(crate) changed: Option<String>,
    pub(crate) author: String,
    pub(crate) licence: String,
}

/// A figure that others published.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Published {
    pub(crate) room: String,
    pub(crate) method: String,
    pub(crate) albedo_db: f64,
    pub(crate) roughness_db: f64,
    pub(crate) minutes: f64,
    pub(crate) source: String,
    /// What differs from our measurement.
    pub(crate) differs: String,
}

impl Rooms {
    /// The list; with smaller pictures for a trial.
    ///
    /// # Errors
    /// If it is damaged.
    pub(crate) fn load(quick: bool) -> Result<Self, Failure> {
        let mut text: Value = serde_json::from_str(LIST)?;
        let rooms = text["rooms"].as_object_mut().ok_or("rooms.json has no rooms")?;
        if quick {
            for size in rooms.values_mut().filter_map(|room| room["size"].as_array_mut()) {
                for side in size {
                    *side = (side.as_u64().unwrap_or_default() / QUICK_SHRINK).into();
                }
            }
        }
        let all = rooms
            .iter()
            .map(|(name, value)| {
                let room: Room = serde_json::from_value(value.clone())?;
                Ok(Room { name: name.clone(), ..room })
            })
            .collect::<Result<Vec<Room>, Failure>>()?;
        let published = serde_json::from_value(text["published"].clone())?;
        Ok(Self { all, published, text })
    }

    /// The rooms of these names, or all.
    ///
    /// # Errors
    /// If a name is unknown.
    pub(crate) fn choose(&self, names: &[String]) -> Result<Vec<&Room>, Failure> {
        if names.is_empty() {
            return Ok(self.all.iter().collect());
        }
        names.iter().map(|name| self.named(name)).collect()
    }

    fn named(&self, name: &str) -> Result<&Room, Failure> {
        self.all.iter().find(|room| room.name == name).ok_or_else(|| {
            let known: Vec<&str> = self.all.iter().map(|room| room.name.as_str()).collect();
            format!("there is no room {name}; there are {}", known.join(", ")).into()
        })
    }

    /// The place of a room in the list, which orders the page.
    pub(crate) fn place(&self, name: &str) -> usize {
        self.all.iter().position(|room| room.name == name).unwrap_or(self.all.len())
    }
}

impl Room {
    /// Whether its licence allows to show pictures of it.
    pub(crate) fn may_be_shown(&self) -> bool {
        self.licence.starts_with("CC")
    }

    /// Whether its file is in the folder of the trees; if not, that is said.
    pub(super) fn is_present(&self, folder: &Path) -> bool {
        Self::is_file_present(&self.name, &self.file, folder)
    }

    /// The same for the file of a room or task called `name`.
    pub(super) fn is_file_present(name: &str, file: &str, folder: &Path) -> bool {
        let path = folder.join(file);
        let found = path.is_file();
        if !found {
            eprintln!("{name}: {} is not there; left out", path.display());
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_is_whole_and_a_trial_is_smaller() {
        let (full, quick) = (Rooms::load(false).unwrap(), Rooms::load(true).unwrap());
        assert_eq!(full.all.len(), quick.all.len());
        for (room, small) in full.all.iter().zip(&quick.all) {
            let (width, height) = room.size;
            assert!(
                (70_000..100_000).contains(&(width * height)),
                "{}: {width} x {height}",
                room.name
            );
            assert_eq!(small.size, (width / 2, height / 2));
        }
        for figure in &full.published {
            assert!(full.named(&figure.room).is_ok(), "{}", figure.room);
        }
    }

    #[test]
    fn an_unknown_room_is_refused_and_none_means_all() {
        let rooms = Rooms::load(false).unwrap();
        assert_eq!(rooms.choose(&[]).unwrap().len(), rooms.all.len());
        assert!(rooms.choose(&["cellar".to_owned()]).is_err());
        assert_eq!(rooms.choose(&["kitchen".to_owned()]).unwrap()[0].name, "kitchen");
    }
}
