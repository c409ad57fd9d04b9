//! Shapes of a scene's file that are not rendered.
//!
//! Surfaces that let light through are not modelled. Their shapes take no part in light transport; a photograph shows
//! them all the same, so the recovery leaves out the pixels that they cover ([`unseen`](Scene::left_out)).

use crate::{Mesh, Scene};
use serde::{Deserialize, Serialize};

/// The most names in [`Scene::left_out_told`]; they fit on a line or two.
const NAMED: usize = 12;

/// A shape that takes no part in light transport.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
    /// The name of its material, which is no group of the scene.
    pub material: String,
    /// Its mesh in world space.
    pub mesh: Mesh,
}

impl Scene {
    /// The materials of the shapes that are left out, each once, in the order of the file.
    pub fn materials_left_out(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for shape in &self.left_out {
            if !names.contains(&shape.material.as_str()) {
                names.push(&shape.material);
            }
        }
        names
    }

    /// One sentence that names the materials of the shapes that are left out; none if there are no such shapes.
    ///
    /// ```
    /// use unrender_scene::{LeftOut, Mesh, Scene};
    ///
    /// let pane = LeftOut { material: "window".into(), mesh: Mesh::default() };
    /// let scene = Scene { left_out: vec![pane], ..Scene::default() };
    /// assert!(scene.left_out_told().unwrap().contains("\"window\""));
    /// assert_eq!(Scene::default().left_out_told(), None);
    /// ```
    pub fn left_out_told(&self) -> Option<String> {
        let names = self.materials_left_out();
        if names.is_empty() {
            return None;
        }
        let quoted: Vec<String> =
            names.iter().take(NAMED).map(|name| format!("\"{name}\"")).collect();
        let more = match names.len().saturating_sub(NAMED) {
            0 => String::new(),
            rest => format!(" and {rest} more"),
        };
        let (lets, its) = if names.len() == 1 { ("lets", "its") } else { ("let", "their") };
        let shapes = match self.left_out.len() {
            1 => "shape is".to_owned(),
            count => format!("{count} shapes are"),
        };
        Some(format!(
            "{}{more} {lets} light through, which is not modelled: {its} {shapes} left out",
            quoted.join(", ")
        ))
    }
}
