//! A scene prepared for ray tracing: flat vertex and triangle arrays, the acceleration structure,
//! the light samplers.

use crate::accel::{Accel, Hit, Ray};
use crate::appearance::Appearance;
use crate::coplanar::{InFront, in_front};
use crate::emitters::{Emitters, TriangleEmission};
use crate::guiding::SpecularGuide;
use crate::shapes::Shapes;
use crate::surface::Surface;
use crate::veil::Veil;
use crate::virtual_lamps::{FlatFaces, VirtualLamps};
use glam::Vec3;
use std::borrow::Cow;
use unrender_scene::{BrdfModel, Scene, SceneError};

/// A scene prepared for ray tracing.
///
/// Geometry, lights and the BRDF model are fixed when it is built. Materials and the brightness of
/// lights ([`crate::Appearance`]) are arguments of each rendering, since recovery tries many on the
/// same geometry.
#[derive(Debug)]
pub struct Tracer {
    /// The triangles that no ray passes.
    pub(crate) accel: Accel,
    /// The others.
    pub(crate) veil: Option<Veil>,
    pub(crate) shapes: Shapes,
    pub(crate) emitters: Emitters,
    pub(crate) guide: SpecularGuide,
    pub(crate) flat_faces: FlatFaces,
    in_front: Vec<InFront>,
    pub(crate) model: BrdfModel,
}

impl Tracer {
    /// Prepares `scene`, which a reader of files or `Scene::validate` has checked.
    ///
    /// # Panics
    /// If [`Scene::check`] finds a fault, with its message; [`Tracer::try_new`] returns it.
    pub fn new(scene: &Scene) -> Self {
        Self::try_new(scene).unwrap_or_else(|fault| panic!("{fault}"))
    }

    /// Prepares `scene`, checked or not.
    ///
    /// ```
    /// use unrender_render::Tracer;
    /// use unrender_scene::{Mesh, Object, Scene};
    ///
    /// let mut scene = Scene::default();
    /// scene.objects.push(Object { name: "box".into(), group: 3, mesh: Mesh::default() });
    /// let fault = Tracer::try_new(&scene).unwrap_err();
    /// assert!(fault.to_string().contains("group 3"));
    /// ```
    ///
    /// # Errors
    /// Those of [`Scene::check`].
    pub fn try_new(scene: &Scene) -> Result<Self, SceneError> {
        scene.check()?;
        let flat_faces = FlatFaces::new(scene);
        let (moved, in_front) = in_front(scene, &flat_faces);
        let (scene, flat_faces) = match &moved {
            Cow::Borrowed(_) => (scene, flat_faces),
            Cow::Owned(moved) => (moved, FlatFaces::new(moved)),
        };
        let shapes = Shapes::new(scene);
        let triangles = shapes.triangles();
        let (veiled, opaque): (Vec<u32>, Vec<u32>) =
            (0..triangles.len() as u32).partition(|&triangle| shapes.is_veiled(triangle));
        let accel = Accel::of(&triangles, &opaque);
        let veil = (!veiled.is_empty()).then(|| Veil::new(&triangles, &veiled, &shapes));
        let group_of = |t: usize| shapes.object_and_group(t as u32).1;
        let emission = |t: usize| TriangleEmission {
            group: group_of(t),
            radiance: scene.groups[group_of(t) as usize].emission,
        };
        let grouped = &triangles[..shapes.grouped()];
        let bounds = bounds(grouped);
        let emitters = Emitters::new(
            grouped,
            emission,
            scene.groups.len() as u32,
            &scene.lights,
            bounds,
            scene.environment.as_ref(),
        );
        let guide = SpecularGuide::new(scene, emitters.layout().clone());
        let model = scene.brdf;
        Ok(Self { accel, veil, shapes, emitters, guide, flat_faces, in_front, model })
    }

    /// The nearest surface of a group along the ray, as if there were no glass.
    pub fn surface(&self, ray: &Ray) -> Option<Surface> {
        self.closest(ray).map(|hit| self.shapes.surface_at(ray, hit))
    }

    /// The same as where the ray hits it.
    #[inline]
    pub(crate) fn closest(&self, ray: &Ray) -> Option<Hit> {
        let hit = self.accel.closest(ray);
        match &self.veil {
            Some(veil) => veil.nearer(&self.shapes, ray, hit),
            None => hit,
        }
    }

    /// Whether it has glass.
    pub(crate) fn has_glass(&self) -> bool {
        self.veil.as_ref().is_some_and(Veil::has_glass)
    }

    /// The faces that lay in the plane of a larger one and were moved in front of it.
    pub fn in_front(&self) -> &[InFront] {
        &self.in_front
    }

    /// The indices of a triangle's object and group.
    pub fn object_and_group(&self, triangle: u32) -> (u32, u32) {
        self.shapes.object_and_group(triangle)
    }

    /// The lamps as planar mirrors show them under `appearance`.
    pub(crate) fn virtual_lamps(&self, appearance: &Appearance<'_>) -> VirtualLamps {
        VirtualLamps::new(&self.flat_faces, &self.accel, &self.emitters, appearance)
    }

    /// The unit normal of the front of a triangle.
    pub(crate) fn front_normal(&self, triangle: u32) -> Vec3 {
        self.shapes.front_normal(triangle)
    }
}

/// The lower and upper corner of the box around `triangles`; zero without any.
fn bounds(triangles: &[[Vec3; 3]]) -> [Vec3; 2] {
    let corners = triangles.iter().flatten().map(|&corner| [corner, corner]);
    let grown = |a: [Vec3; 2], b: [Vec3; 2]| [a[0].min(b[0]), a[1].max(b[1])];
    corners.reduce(grown).unwrap_or_default()
}
