//! The shapes of glass of a scene, for those who write it: which kinds there are, by names of their own.

use std::collections::BTreeSet;
use unrender_scene::{Glass, Mesh, Scene};

/// A kind of glass: a material of the file where it is of one kind alone.
pub(crate) struct Kind<'a> {
    /// The name of its material, numbered where that is of several kinds or the name of a group.
    pub(crate) name: String,
    /// What it does to light.
    pub(crate) glass: &'a Glass,
    /// The material that it is named after.
    material: &'a str,
}

/// A shape of glass.
pub(crate) struct Shape<'a> {
    /// A name that no other object has.
    pub(crate) name: String,
    /// Its mesh.
    pub(crate) mesh: &'a Mesh,
    /// The index of its kind.
    pub(crate) kind: usize,
}

/// All of a scene.
pub(crate) struct Glasses<'a> {
    /// The kinds.
    pub(crate) kinds: Vec<Kind<'a>>,
    /// The shapes that have triangles.
    pub(crate) shapes: Vec<Shape<'a>>,
}

impl<'a> Glasses<'a> {
    /// Those of `scene`.
    pub(crate) fn of(scene: &'a Scene) -> Self {
        let mut all = Self { kinds: Vec::new(), shapes: Vec::new() };
        let mut materials: BTreeSet<String> =
            scene.groups.iter().map(|group| group.name.clone()).collect();
        let mut objects: BTreeSet<String> =
            scene.objects.iter().map(|object| object.name.clone()).collect();
        for shape in scene.ungrouped.iter().filter(|shape| !shape.mesh.triangles.is_empty()) {
            let (Some(glass), material) = (&shape.glass, shape.material.as_str()) else { continue };
            let is_of = |kind: &Kind| kind.material == material && kind.glass == glass;
            let kind = all.kinds.iter().position(is_of).unwrap_or_else(|| {
                all.kinds.push(Kind {
                    name: given_once(material, &mut materials),
                    glass,
                    material,
                });
                all.kinds.len() - 1
            });
            let name = given_once(material, &mut objects);
            all.shapes.push(Shape { name, mesh: &shape.mesh, kind });
        }
        all
    }

    /// Whether a kind is so.
    pub(crate) fn any(&self, is_so: impl Fn(&Glass) -> bool) -> bool {
        self.kinds.iter().any(|kind| is_so(kind.glass))
    }
}

/// `name`, numbered if it is `taken`, which it is then.
fn given_once(name: &str, taken: &mut BTreeSet<String>) -> String {
    let numbered = (2..).map(|number| format!("{name} {number}"));
    let mut candidates = std::iter::once(name.to_owned()).chain(numbered);
    candidates.find(|name| taken.insert(name.clone())).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use unrender_scene::{Group, Material, Rgb, Ungrouped};

    #[test]
    fn kinds_and_shapes_have_names_of_their_own() {
        let mesh = Mesh::flat(&[Vec3::ZERO, Vec3::X, Vec3::Y], &[], &[[0, 1, 2]]);
        let shape = |material: &str, glass| Ungrouped {
            material: material.into(),
            mesh: mesh.clone(),
            glass,
        };
        let (pane, body) = (Some(Glass::pane(1.5)), Some(Glass::solid(1.5)));
        let ungrouped =
            vec![shape("a", pane), shape("b", None), shape("a", body), shape("a", pane)];
        let material = Material::diffuse(Rgb::ONE);
        let group = Group { name: "a 2".into(), material, emission: Rgb::ZERO };
        let scene = Scene { groups: vec![group], ungrouped, ..Scene::default() };
        let glasses = Glasses::of(&scene);
        let kinds: Vec<&str> = glasses.kinds.iter().map(|kind| kind.name.as_str()).collect();
        assert_eq!(kinds, ["a", "a 3"]);
        let shapes: Vec<(&str, usize)> =
            glasses.shapes.iter().map(|shape| (shape.name.as_str(), shape.kind)).collect();
        assert_eq!(shapes, [("a", 0), ("a 2", 1), ("a 3", 0)]);
    }
}
