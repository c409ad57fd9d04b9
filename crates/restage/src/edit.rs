//! Edits, and how they are applied to a scene.

use crate::environment::{self, Surround};
use crate::insert::{self, Insert};
use crate::light::{self, LightEdit};
use crate::remove::{self, Remove};
use crate::repaint::{self, Repaint};
use crate::stage::{Change, Stage};
use unrender_scene::Scene;

/// One edit.
#[derive(Clone, Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "there are a few edits, and each is moved a few times"
)]
pub enum Edit {
    /// Objects are removed.
    Remove(Remove),
    /// A group gets another reflectance.
    Repaint(Repaint),
    /// A light is changed, added or removed.
    Light(LightEdit),
    /// The environment is replaced.
    Surround(Surround),
    /// A model is inserted.
    Insert(Insert),
}

/// Why an edit cannot be applied.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{problem}")]
#[non_exhaustive]
pub struct EditError {
    /// The index of the edit.
    pub edit: usize,
    /// What is wrong with it and what to do.
    pub problem: String,
}

/// Applies `edits` to `scene`, one after the other.
///
/// ```
/// use unrender_restage::remove::{Bearer, Remove};
/// use unrender_restage::repaint::{Paint, Repaint};
/// use unrender_restage::{Edit, apply};
/// use unrender_scene::{Group, Material, Mesh, Object, Rgb, Scene};
///
/// let mut scene = Scene::default();
/// let material = Material::diffuse(Rgb::splat(0.5));
/// scene.groups.push(Group { name: "wall".into(), material, emission: Rgb::ZERO });
/// for name in ["left", "right"] {
///     let mesh = Mesh::sphere(glam::Vec3::ZERO, 1.0);
///     scene.objects.push(Object { name: name.into(), group: 0, mesh });
/// }
/// let paint = Paint { rho_d: Some(Rgb::new(0.6, 0.1, 0.1)), ..Paint::default() };
/// let edits = [
///     Edit::Remove(Remove { name: "left".into(), what: Bearer::Object }),
///     Edit::Repaint(Repaint { group: "wall".into(), paint }),
/// ];
/// apply(&mut scene, &edits)?;
/// assert_eq!(scene.objects[0].name, "right");
/// assert_eq!(scene.groups[0].material.rho_d.x, 0.6);
/// # Ok::<(), unrender_restage::EditError>(())
/// ```
///
/// # Errors
/// If an edit names something missing, or adds a name that exists. The scene is then partly edited.
pub fn apply(scene: &mut Scene, edits: &[Edit]) -> Result<Change, EditError> {
    let mut stage = Stage::new(scene);
    for (index, edit) in edits.iter().enumerate() {
        let done = match edit {
            Edit::Remove(remove) => remove::apply(remove, &mut stage),
            Edit::Repaint(repaint) => repaint::apply(repaint, &mut stage),
            Edit::Light(light) => light::apply(light, &mut stage),
            Edit::Surround(surround) => environment::apply(surround, &mut stage),
            Edit::Insert(insert) => insert::apply(insert, &mut stage),
        };
        done.map_err(|problem| EditError { edit: index, problem })?;
    }
    Ok(stage.change)
}
