//! Validation of scenes: errors and warnings.

use crate::{Environment, Mesh, Scene};
use glam::Vec3;

/// Warnings for the user: doubtful but usable input, and what was assumed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Warnings(pub Vec<String>);

/// Nobody reads more; each new one is compared with all before. With half of it, real scenes with a
/// doubt a group could lose some; with double, nothing changes.
const MAX_WARNINGS: usize = 1000;

impl Warnings {
    /// Adds `warning`, a whole sentence without a final line break; each only once.
    pub fn push(&mut self, warning: impl Into<String>) {
        if self.0.len() > MAX_WARNINGS {
            return;
        }
        let warning = if self.0.len() == MAX_WARNINGS {
            "There are more warnings, which are not shown.".into()
        } else {
            warning.into()
        };
        if !self.0.contains(&warning) {
            self.0.push(warning);
        }
    }

    /// Adds all warnings of `other`.
    pub fn extend(&mut self, other: Self) {
        other.0.into_iter().for_each(|w| self.push(w));
    }
}

/// Why a scene cannot be rendered.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// A triangle names a vertex that does not exist.
    #[error(
        "object \"{object}\": triangle {triangle} uses vertex {vertex}, but there are only {count}; export the scene again"
    )]
    IndexOutOfRange {
        /// The object's name.
        object: String,
        /// The triangle's number from zero.
        triangle: usize,
        /// The missing vertex.
        vertex: u32,
        /// The number of vertices.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error(
        "object \"{object}\": {attribute} of vertex {vertex} is not a finite number; repair the mesh and export it again"
    )]
    NotFinite {
        /// The object's name.
        object: String,
        /// Which attribute.
        attribute: &'static str,
        /// The vertex's number from zero.
        vertex: usize,
    },
    /// There are no triangles.
    #[error("the scene has no triangles; export it with its meshes")]
    NoGeometry,
    /// Nothing emits light.
    #[error(
        "the scene has no light: give a material an emission (emissiveFactor), add a KHR_lights_punctual light or an environment"
    )]
    NoLight,
}

impl Scene {
    /// Checks indices, attributes and lights, removes triangles without area, and returns warnings.
    ///
    /// # Errors
    /// If an index is out of range, an attribute is not finite, or triangles or lights are missing.
    pub fn validate(&mut self) -> Result<Warnings, SceneError> {
        let warnings = self.validate_meshes()?;
        let surrounded = self.environment.as_ref().is_some_and(Environment::is_bright);
        if self.lights.is_empty() && !self.has_emitting_triangle() && !surrounded {
            return Err(SceneError::NoLight);
        }
        Ok(warnings)
    }

    /// [`Scene::validate`] without lights, for a model to be inserted into a scene.
    ///
    /// # Errors
    /// If an index is out of range, an attribute is not finite, or triangles are missing.
    pub fn validate_meshes(&mut self) -> Result<Warnings, SceneError> {
        let mut warnings = Warnings::default();
        for object in &mut self.objects {
            check_indices(&object.name, &object.mesh)?;
            check_finite(&object.name, &object.mesh)?;
            let dropped = drop_zero_area(&mut object.mesh);
            if dropped > 0 {
                warnings.push(format!(
                    "object \"{}\": {dropped} triangle(s) without area were left out",
                    object.name
                ));
            }
            let turned = turned_normals(&object.mesh);
            if turned > 0 {
                warnings.push(format!(
                    "object \"{}\": the normals of {turned} triangle(s) point against their winding; \
                     the winding was taken as the front",
                    object.name
                ));
            }
        }
        if self.triangle_count() == 0 {
            return Err(SceneError::NoGeometry);
        }
        Ok(warnings)
    }

    fn has_emitting_triangle(&self) -> bool {
        self.objects
            .iter()
            .any(|o| self.groups[o.group].is_emitter() && !o.mesh.triangles.is_empty())
    }
}

fn check_indices(object: &str, mesh: &Mesh) -> Result<(), SceneError> {
    let count = mesh.positions.len();
    for (triangle, indices) in mesh.triangles.iter().enumerate() {
        if let Some(&vertex) = indices.iter().find(|&&i| i as usize >= count) {
            let object = object.to_owned();
            return Err(SceneError::IndexOutOfRange { object, triangle, vertex, count });
        }
    }
    Ok(())
}

fn check_finite(object: &str, mesh: &Mesh) -> Result<(), SceneError> {
    let error = |attribute, vertex| {
        Err(SceneError::NotFinite { object: object.to_owned(), attribute, vertex })
    };
    if let Some(vertex) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return error("POSITION", vertex);
    }
    if let Some(vertex) = mesh.normals.iter().position(|n| !n.is_finite()) {
        return error("NORMAL", vertex);
    }
    if let Some(vertex) = mesh.uvs.iter().position(|uv| !uv.is_finite()) {
        return error("TEXCOORD_0", vertex);
    }
    if let Some(vertex) = mesh.tangents.iter().position(|t| !t.is_finite()) {
        return error("TANGENT", vertex);
    }
    Ok(())
}

/// Removes triangles whose area is zero in single precision; returns their number.
fn drop_zero_area(mesh: &mut Mesh) -> usize {
    let before = mesh.triangles.len();
    let positions = &mesh.positions;
    mesh.triangles.retain(|triangle| {
        let [a, b, c] = triangle.map(|i| positions[i as usize].as_dvec3());
        (b - a).cross(c - a).length_squared() > 0.0
    });
    before - mesh.triangles.len()
}

/// The number of triangles whose normals all oppose the winding.
fn turned_normals(mesh: &Mesh) -> usize {
    let turned = |index: &usize| {
        let [a, b, c] = mesh.corners(*index);
        let front: Vec3 = (b - a).cross(c - a);
        mesh.triangles[*index].iter().all(|&i| mesh.normals[i as usize].dot(front) < 0.0)
    };
    (0..mesh.triangles.len()).filter(turned).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Group, Material, Object, Rgb};

    fn lit_triangle() -> Scene {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let mesh = Mesh::flat(&positions, &[], &[[0, 1, 2]]);
        let group = Group {
            name: "lamp".into(),
            material: Material::diffuse(Rgb::ZERO),
            emission: Rgb::ONE,
        };
        Scene {
            objects: vec![Object { name: "o".into(), group: 0, mesh }],
            groups: vec![group],
            ..Scene::default()
        }
    }

    #[test]
    fn a_good_scene_passes_in_silence() {
        assert_eq!(lit_triangle().validate(), Ok(Warnings::default()));
    }

    #[test]
    fn each_fault_is_named() {
        let mut scene = lit_triangle();
        scene.objects[0].mesh.triangles[0][1] = 9;
        let error = scene.validate().unwrap_err();
        assert!(matches!(error, SceneError::IndexOutOfRange { vertex: 9, count: 3, .. }));

        let mut scene = lit_triangle();
        scene.objects[0].mesh.positions[2].y = f32::NAN;
        let error = scene.validate().unwrap_err();
        assert!(matches!(error, SceneError::NotFinite { attribute: "POSITION", vertex: 2, .. }));

        let mut scene = lit_triangle();
        scene.groups[0].emission = Rgb::ZERO;
        assert_eq!(scene.validate(), Err(SceneError::NoLight));

        let panorama = crate::RgbImage::new(1, 1, vec![Rgb::ONE]);
        scene.environment = Environment::new(panorama, 0.0).ok();
        assert_eq!(scene.validate(), Ok(Warnings::default()));

        let mut scene = lit_triangle();
        scene.objects.clear();
        assert_eq!(scene.validate(), Err(SceneError::NoGeometry));
    }

    #[test]
    fn triangles_without_area_are_dropped_and_turned_normals_named() {
        let mut scene = lit_triangle();
        scene.objects[0].mesh.triangles.push([0, 1, 1]);
        scene.objects[0].mesh.normals = vec![Vec3::NEG_Z; 3];
        let warnings = scene.validate().unwrap();
        assert_eq!(scene.triangle_count(), 1);
        assert_eq!(warnings.0.len(), 2);
    }
}
