//! Validation of scenes: errors and warnings.

use crate::reflectance::{IOR_MAX, Reflectance};
use crate::{
    Camera, Coverage, Detail, Environment, Group, Light, LightKind, Material, Mesh, NormalMap,
    Object, Rgb, Scene,
};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Warnings for the user: doubtful but usable input, and what was assumed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Warnings(pub Vec<String>);

/// The most warnings: nobody reads more, and each new one is compared with all before. With half of
/// it, real scenes with one per group could lose some; with double, nothing changes.
const MAX_WARNINGS: usize = 1000;

/// The most names of objects in a warning; they fit on a line or two.
const NAMED: usize = 5;

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
#[non_exhaustive]
pub enum SceneError {
    /// An object is in a group that does not exist.
    #[error(
        "object \"{object}\" is in group {group}, but there are only {count} groups; give it the index of its group"
    )]
    GroupOutOfRange {
        /// The object's name.
        object: String,
        /// The missing group.
        group: usize,
        /// The number of groups.
        count: usize,
    },
    /// An attribute does not have one entry per vertex.
    #[error(
        "object \"{object}\": {attribute} has {count} entries for {vertices} vertices; give each vertex one"
    )]
    AttributeCount {
        /// The object's name.
        object: String,
        /// Which attribute.
        attribute: &'static str,
        /// Its number of entries.
        count: usize,
        /// The number of vertices.
        vertices: usize,
    },
    /// A number of a material, a light or a camera is NaN or infinite, or negative where it cannot be.
    #[error("{owner}: {quantity} is not a finite number of zero or more; correct it")]
    NotUsable {
        /// What has the number: a group, a light or a camera, with its name.
        owner: String,
        /// Which number.
        quantity: &'static str,
    },
    /// A texture has no texels.
    #[error("group \"{group}\": its texture has no texels; give it a picture or none")]
    EmptyTexture {
        /// The group's name.
        group: String,
    },
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
        "the scene has no light: give a material an emission (emissiveFactor), add a KHR_lights_punctual light, or bring a light or an environment along: [[lights]] or [environment] in a project or an edit, --environment"
    )]
    NoLight,
}

impl Scene {
    /// Checks all that renderings rely on ([`Scene::check`]) and that there is something to see,
    /// removes triangles without area, gives objects without a name one, and returns warnings.
    ///
    /// # Errors
    /// Those of [`Scene::check`], and if triangles or lights are missing.
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
    /// Those of [`Scene::check`], and if triangles are missing.
    pub fn validate_meshes(&mut self) -> Result<Warnings, SceneError> {
        self.name_the_nameless();
        self.check()?;
        let (mut empty, mut turned) = (Found::default(), Found::default());
        for object in &mut self.objects {
            empty.add(drop_zero_area(&mut object.mesh), &object.name);
            turned.add(turned_normals(&object.mesh), &object.name);
        }
        let mut warnings = Warnings::default();
        let told = empty.told(|place, count| {
            format!("{place}: {count} triangle(s) without area were left out")
        });
        told.into_iter().for_each(|told| warnings.push(told));
        let told = turned.told(|place, count| {
            format!(
                "{place}: the normals of {count} triangle(s) point against their winding; the winding was taken as \
                 the front"
            )
        });
        told.into_iter().for_each(|told| warnings.push(told));
        for shape in &mut self.ungrouped {
            drop_zero_area(&mut shape.mesh);
        }
        if self.bounds().is_none() {
            return Err(SceneError::NoGeometry);
        }
        Ok(warnings)
    }

    /// Checks all that renderings rely on: each object's group exists, attributes have one entry a
    /// vertex, triangles name vertices, numbers are finite, textures have texels. A scene that passes
    /// does not make the renderer panic. Takes a few nanoseconds a vertex.
    ///
    /// ```
    /// use unrender_scene::{Material, Group, Mesh, Object, Rgb, Scene, SceneError};
    ///
    /// let mut scene = Scene::default();
    /// let material = Material::diffuse(Rgb::splat(0.5));
    /// scene.groups.push(Group { name: "wall".into(), material, emission: Rgb::ZERO });
    /// let mesh = Mesh::sphere(glam::Vec3::ZERO, 1.0);
    /// scene.objects.push(Object { name: "ball".into(), group: 0, mesh });
    /// assert_eq!(scene.check(), Ok(()));
    /// scene.objects[0].group = 1;
    /// let object = "ball".into();
    /// let fault = SceneError::GroupOutOfRange { object, group: 1, count: 1 };
    /// assert_eq!(scene.check(), Err(fault));
    /// ```
    ///
    /// # Errors
    /// The first fault, in the order objects, groups, lights, cameras.
    pub fn check(&self) -> Result<(), SceneError> {
        for object in &self.objects {
            check_group(object, self.groups.len())?;
            check_counts(&object.name, &object.mesh)?;
            check_indices(&object.name, &object.mesh)?;
            check_finite(&object.name, &object.mesh)?;
            check_detail(object)?;
        }
        for shape in &self.ungrouped {
            check_counts(&shape.material, &shape.mesh)?;
            check_indices(&shape.material, &shape.mesh)?;
            check_finite(&shape.material, &shape.mesh)?;
            let is_glass = shape.glass.is_none_or(|glass| glass.is_valid());
            let owner = || format!("material \"{}\"", shape.material);
            check_numbers(owner, &[("a number of its glass", is_glass)])?;
        }
        self.groups.iter().try_for_each(check_material)?;
        self.lights.iter().try_for_each(check_light)?;
        self.cameras.iter().try_for_each(check_camera)
    }

    /// Gives objects without a name one by which messages and edits can say them: as of readers, "object" and its number from zero.
    fn name_the_nameless(&mut self) {
        let taken: BTreeSet<String> = self.objects.iter().map(|o| o.name.clone()).collect();
        for (index, object) in self.objects.iter_mut().enumerate() {
            if object.name.trim().is_empty() {
                let mut name = format!("object {index}");
                while taken.contains(&name) {
                    name += "'";
                }
                object.name = name;
            }
        }
    }

    fn has_emitting_triangle(&self) -> bool {
        self.objects
            .iter()
            .any(|o| self.groups[o.group].is_emitter() && !o.mesh.triangles.is_empty())
    }
}

fn check_group(object: &Object, count: usize) -> Result<(), SceneError> {
    if object.group < count {
        return Ok(());
    }
    Err(SceneError::GroupOutOfRange { object: object.name.clone(), group: object.group, count })
}

/// Normals are required; texture coordinates and tangents may be absent.
fn check_counts(object: &str, mesh: &Mesh) -> Result<(), SceneError> {
    let vertices = mesh.positions.len();
    let attributes = [
        ("NORMAL", mesh.normals.len(), true),
        ("TEXCOORD_0", mesh.uvs.len(), false),
        ("TANGENT", mesh.tangents.len(), false),
    ];
    for (attribute, count, is_required) in attributes {
        if count != vertices && (is_required || count != 0) {
            let object = object.to_owned();
            return Err(SceneError::AttributeCount { object, attribute, count, vertices });
        }
    }
    Ok(())
}

/// Checks that all `quantities` of `owner` are as they should be.
fn check_numbers(
    owner: impl Fn() -> String,
    quantities: &[(&'static str, bool)],
) -> Result<(), SceneError> {
    match quantities.iter().find(|(_, is_good)| !is_good) {
        Some(&(quantity, _)) => Err(SceneError::NotUsable { owner: owner(), quantity }),
        None => Ok(()),
    }
}

fn is_amount(rgb: Rgb) -> bool {
    rgb.is_finite() && rgb.min_element() >= 0.0
}

fn check_material(group: &Group) -> Result<(), SceneError> {
    let Material { rho_d, rho_s, reflectance, alpha_x, alpha_y, theta_rad, texture } =
        &group.material;
    let is_dense = match reflectance {
        Reflectance::Dielectric { ior, .. } => (1.0..=IOR_MAX).contains(ior),
        Reflectance::Free | Reflectance::Metal { .. } => true,
    };
    let is_roughness = |alpha: &f32| alpha.is_finite() && *alpha >= 0.0;
    let quantities = [
        ("its diffuse reflectance", is_amount(*rho_d)),
        ("its specular reflectance", is_amount(*rho_s)),
        ("its refractive index", is_dense),
        ("its roughness", is_roughness(alpha_x) && is_roughness(alpha_y)),
        ("the angle of its anisotropy direction", theta_rad.is_finite()),
        ("its emission", is_amount(group.emission)),
    ];
    check_numbers(|| format!("group \"{}\"", group.name), &quantities)?;
    if texture.as_ref().is_some_and(|texture| texture.image.pixels().is_empty()) {
        return Err(SceneError::EmptyTexture { group: group.name.clone() });
    }
    Ok(())
}

fn check_light(light: &Light) -> Result<(), SceneError> {
    let is_placed = match light.kind {
        LightKind::Point { position, .. } => position.is_finite(),
        LightKind::Spot { position, direction, inner_rad, outer_rad, .. } => {
            let angles_are_finite = inner_rad.is_finite() && outer_rad.is_finite();
            position.is_finite() && direction.is_finite() && angles_are_finite
        }
        LightKind::Directional { direction, .. } => direction.is_finite(),
        LightKind::Profiled { position, direction, upright, .. } => {
            position.is_finite() && direction.is_finite() && upright.is_finite()
        }
    };
    let quantities = [
        ("its position, direction or angle", is_placed),
        ("its brightness", is_amount(light.kind.strength())),
    ];
    check_numbers(|| format!("light \"{}\"", light.name), &quantities)
}

fn check_camera(camera: &Camera) -> Result<(), SceneError> {
    let fov = camera.fov_y_rad;
    let quantities = [
        ("its pose", camera.world_from_camera.is_finite()),
        ("its field of view", fov.is_finite() && fov > 0.0),
        ("its lens", camera.lens.is_valid()),
    ];
    check_numbers(|| format!("camera \"{}\"", camera.name), &quantities)
}

/// The maps of a mesh have texels that are numbers.
fn check_detail(object: &Object) -> Result<(), SceneError> {
    let Detail { normals, coverage } = &object.mesh.detail;
    let are_normals = |map: &NormalMap| {
        let normals = map.normals.image.pixels();
        !normals.is_empty() && normals.iter().all(|normal| normal.is_finite())
    };
    let is_coverage = |map: &Coverage| {
        let alphas = map.alpha.image.pixels();
        !alphas.is_empty() && alphas.iter().all(|alpha| alpha.is_finite())
    };
    let quantities = [
        ("a number of its normal map", normals.as_deref().is_none_or(are_normals)),
        ("a number of its coverage", coverage.as_deref().is_none_or(is_coverage)),
    ];
    check_numbers(|| format!("object \"{}\"", object.name), &quantities)
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

/// Triangles with one fault, and the objects that have some.
#[derive(Default)]
struct Found {
    triangles: usize,
    objects: Vec<String>,
}

impl Found {
    fn add(&mut self, triangles: usize, object: &str) {
        if triangles > 0 {
            self.triangles += triangles;
            self.objects.push(object.to_owned());
        }
    }

    /// One sentence about all of them; none without a fault.
    fn told(&self, sentence: impl Fn(&str, usize) -> String) -> Option<String> {
        let named: Vec<String> =
            self.objects.iter().take(NAMED).map(|name| format!("\"{name}\"")).collect();
        let place = match self.objects.len() - named.len() {
            0 if named.len() == 1 => format!("object {}", named[0]),
            0 => format!("objects {}", named.join(", ")),
            rest => format!("objects {} and {rest} more", named.join(", ")),
        };
        (self.triangles > 0).then(|| sentence(&place, self.triangles))
    }
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
    use glam::{Vec2, Vec4};
    use std::sync::Arc;

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
    fn objects_without_a_name_get_one_that_messages_can_say() {
        let mut scene = lit_triangle();
        let of = |name: &str| Object { name: name.into(), ..scene.objects[0].clone() };
        scene.objects = vec![of("object 1"), of(""), of(" ")];
        scene.validate().unwrap();
        let names: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
        assert_eq!(names, ["object 1", "object 1'", "object 2"]);
        scene.objects[2].name.clear();
        scene.objects[2].group = 9;
        assert!(scene.validate().unwrap_err().to_string().starts_with("object \"object 2\" is in"));
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

    /// What makes the lit triangle unusable, and a part of the error's message.
    type Fault = (fn(&mut Scene), &'static str);

    const FAULTS: [Fault; 14] = [
        (|s| s.objects[0].group = 1, "is in group 1, but there are only 1 groups"),
        (|s| s.objects[0].group = usize::MAX, "is in group"),
        (|s| s.groups.clear(), "there are only 0 groups"),
        (|s| s.objects[0].mesh.normals.truncate(2), "NORMAL has 2 entries for 3 vertices"),
        (|s| s.objects[0].mesh.uvs.push(Vec2::ZERO), "TEXCOORD_0 has 1 entries"),
        (|s| s.objects[0].mesh.tangents = vec![Vec4::X; 4], "TANGENT has 4 entries"),
        (|s| s.groups[0].emission.y = f32::INFINITY, "group \"lamp\": its emission"),
        (|s| s.groups[0].material.rho_d.x = f32::NAN, "its diffuse reflectance"),
        (|s| s.groups[0].material.rho_s.x = -0.1, "its specular reflectance"),
        (|s| s.groups[0].material.alpha_y = f32::NAN, "its roughness"),
        (|s| s.groups[0].material.theta_rad = f32::NAN, "anisotropy direction"),
        (|s| s.groups[0].material.texture = Some(Arc::default()), "has no texels"),
        (|s| s.lights[0].kind = sun(Vec3::NAN), "light \"sun\": its position, direction"),
        (|s| s.cameras[0].fov_y_rad = 0.0, "camera \"c\": its field of view"),
    ];

    fn sun(direction: Vec3) -> LightKind {
        LightKind::Directional { direction, irradiance: Rgb::ONE }
    }

    #[test]
    fn what_would_make_a_rendering_panic_is_an_error() {
        let mut good = lit_triangle();
        good.lights.push(Light { name: "sun".into(), kind: sun(Vec3::NEG_Z) });
        good.cameras.push(Camera::look_at("c", Vec3::Z, Vec3::ZERO, Vec3::Y, 0.5));
        assert_eq!(good.check(), Ok(()));
        for (spoil, expected) in FAULTS {
            let mut scene = good.clone();
            spoil(&mut scene);
            let error = scene.check().expect_err(expected);
            assert!(error.to_string().contains(expected), "{error}");
            assert_eq!(scene.validate(), Err(error.clone()));
            assert_eq!(scene.validate_meshes(), Err(error));
        }
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
