//! The results of a recovery, and what follows from them: the entries of materials.json, groups to
//! split and groups that agree, and the last picture in all pixels of the photograph.

mod alike;
mod around;
pub(crate) mod entries;
mod full_picture;
pub(crate) mod labels;
mod odd_photograph;
mod outcome;
mod parts;
#[cfg(feature = "cli")]
mod shown;

pub use outcome::{Recovered, Times};
