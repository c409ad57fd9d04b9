//! The tables of an edit file. Each is read by the file of its kind of edit. Values are checked where
//! they are read (`toml_values`), so that an error has the line of the value; names are checked
//! against the scene later.

use super::insert::RawInsert;
use super::remove::RawRemove;
use super::repaint::RawPaint;
use crate::lighting::{RawEnvironment, RawLight};
use serde::Deserialize;
use std::path::PathBuf;
use toml::{Spanned, Value};
use unrender_scene::UpAxis;

/// All keys of an edit file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawEdits {
    pub(super) recovered: Option<Spanned<PathBuf>>,
    pub(super) project: Option<Spanned<PathBuf>>,
    pub(super) scene: Option<Spanned<PathBuf>>,
    pub(super) materials: Option<Spanned<PathBuf>>,
    pub(super) up_axis: Option<UpAxis>,
    pub(super) camera: Option<Spanned<Value>>,
    pub(super) environment: Option<Spanned<RawEnvironment>>,
    #[serde(default)]
    pub(super) remove: Vec<Spanned<RawRemove>>,
    #[serde(default)]
    pub(super) repaint: Vec<Spanned<RawPaint>>,
    #[serde(default)]
    pub(super) lights: Vec<Spanned<RawLight>>,
    #[serde(default)]
    pub(super) insert: Vec<Spanned<RawInsert>>,
}
