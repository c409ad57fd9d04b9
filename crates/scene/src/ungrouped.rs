//! Shapes that belong to no group.
//!
//! They are not recovered, and the recovery leaves out the pixels that show them: those are of glass, which is rendered
//! as its file states it, or of something that takes no part in light transport.

use crate::{Glass, Mesh, Scene};
use serde::{Deserialize, Serialize};

/// The most names in [`Scene::glass_told`]; they fit on a line or two.
const NAMED: usize = 12;

/// A shape that belongs to no group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ungrouped {
    /// The name of its material, which is no group of the scene.
    pub material: String,
    /// Its mesh in world space.
    pub mesh: Mesh,
    /// What it does to light; without, nothing.
    pub glass: Option<Glass>,
}

impl Scene {
    /// The materials of the shapes that belong to no group, each once, in the order of the file.
    pub fn ungrouped_materials(&self) -> Vec<&str> {
        self.names(|_| true)
    }

    fn names(&self, is_meant: impl Fn(&Ungrouped) -> bool) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for shape in self.ungrouped.iter().filter(|shape| is_meant(shape)) {
            if !names.contains(&shape.material.as_str()) {
                names.push(&shape.material);
            }
        }
        names
    }

    /// One sentence that names the materials of glass; none without glass.
    ///
    /// ```
    /// use unrender_scene::{Glass, Mesh, Scene, Ungrouped};
    ///
    /// let glass = Some(Glass::pane(1.5));
    /// let pane = Ungrouped { material: "window".into(), mesh: Mesh::default(), glass };
    /// let scene = Scene { ungrouped: vec![pane], ..Scene::default() };
    /// assert!(scene.glass_told().unwrap().contains("\"window\""));
    /// assert_eq!(Scene::default().glass_told(), None);
    /// ```
    pub fn glass_told(&self) -> Option<String> {
        let names = self.names(|shape| shape.glass.is_some());
        if names.is_empty() {
            return None;
        }
        let quoted: Vec<String> =
            names.iter().take(NAMED).map(|name| format!("\"{name}\"")).collect();
        let more = match names.len().saturating_sub(NAMED) {
            0 => String::new(),
            rest => format!(" and {rest} more"),
        };
        let (is, it) = if names.len() == 1 { ("is", "it is") } else { ("are", "they are") };
        Some(format!(
            "{}{more} {is} glass: {it} rendered as the file says, smooth, and not recovered",
            quoted.join(", ")
        ))
    }
}
