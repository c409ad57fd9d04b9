//! The scene as plain data: geometry, materials, lights and cameras.
//!
//! A [`Scene`] has meshes in world space, in [`Group`]s that share one material, lights, an
//! environment and cameras. This crate reads no files; readers and writers are in
//! `unrender-formats`, light transport is in `unrender-render`.
//!
//! Frames, units and colour spaces of all crates are defined in `docs/reference/conventions.md`: metres, y
//! up, counter-clockwise front faces, linear RGB, radiance in W sr^-1 m^-2 per channel, radians.

pub mod camera;
pub mod color;
pub mod detail;
pub mod environment;
pub mod glass;
pub mod hypothesis;
pub mod image;
pub mod lens;
pub mod light;
pub mod light_profile;
pub mod lobe_albedo;
pub mod material;
pub mod measured;
pub mod mesh;
pub mod origin;
pub mod picture;
pub mod points;
pub mod reflectance;
mod serial;
pub mod sheet;
pub mod texture;
pub mod ungrouped;
pub mod up_axis;
pub mod validate;

pub use camera::Camera;
pub use color::Rgb;
pub use detail::{Coverage, Detail, NormalMap};
pub use environment::{Corners, Environment, EnvironmentError};
pub use glass::Glass;
pub use hypothesis::{Hypothesis, Status};
pub use image::{Image, RgbImage};
pub use lens::Lens;
pub use light::{ENVIRONMENT, LUMENS_PER_WATT, Light, LightKind, Reach, Source};
pub use light_profile::{LightProfile, Photometry};
pub use lobe_albedo::LobeAlbedo;
pub use material::{BrdfModel, Lobe, Material, WardModel};
pub use measured::MeasuredBrdf;
pub use mesh::{Mesh, Object};
pub use picture::{Depth, Merged, Picture, Profile};
pub use points::{AxisLine, Pair};
pub use reflectance::{Layering, Reflectance};
pub use sheet::Sheet;
pub use texture::{Mapped, Texture, Wrap};
pub use ungrouped::Ungrouped;
pub use up_axis::UpAxis;
pub use validate::{SceneError, Warnings};

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// The objects that share one material. In glTF: all primitives with that material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Group {
    /// The name of the material in the scene file; unique within a scene.
    pub name: String,
    /// The material.
    pub material: Material,
    /// Radiance that the group's surfaces emit from their front, W sr^-1 m^-2 per channel.
    pub emission: Rgb,
}

impl Group {
    /// True for area lights: groups that emit light.
    pub fn is_emitter(&self) -> bool {
        self.emission.max_element() > 0.0
    }
}

/// A complete scene.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Scene {
    /// Meshes in world space; each refers to its group by index.
    pub objects: Vec<Object>,
    /// The groups, in the order of the scene file.
    pub groups: Vec<Group>,
    /// Point, spot and directional lights. Area lights are groups with an emission.
    pub lights: Vec<Light>,
    /// The environment map, if any.
    pub environment: Option<Environment>,
    /// The cameras, in the order of the scene file.
    pub cameras: Vec<Camera>,
    /// The BRDF model of the groups' materials.
    pub brdf: BrdfModel,
    /// The shapes that belong to no group: glass, and what takes no part in light transport.
    #[serde(default)]
    pub ungrouped: Vec<Ungrouped>,
    /// The origin of all positions here in the world of the scene's file, metres. It is zero except for scenes far from
    /// zero, whose positions would lose their digits in single precision.
    pub origin: DVec3,
    /// Which axis points upwards. An [`Environment`] has its own, which is to be the same.
    #[serde(default)]
    pub up: UpAxis,
}

impl Scene {
    /// The index of the group called `name`.
    pub fn group_index(&self, name: &str) -> Option<usize> {
        self.groups.iter().position(|g| g.name == name)
    }

    /// The materials of all groups, in the order of [`Scene::groups`].
    pub fn materials(&self) -> Vec<Material> {
        self.groups.iter().map(|g| g.material.clone()).collect()
    }

    /// Gives all materials a free reflectance, for models that know no other.
    pub fn free(&mut self) {
        for group in self.groups.iter_mut().filter(|group| !group.material.reflectance.is_free()) {
            group.material = group.material.clone().freed();
        }
    }

    /// Gives all dielectrics the same layering.
    pub fn layer(&mut self, layering: Layering) {
        for group in &mut self.groups {
            if let Reflectance::Dielectric { layering: former, .. } =
                &mut group.material.reflectance
            {
                *former = layering;
            }
        }
    }

    /// The lowest and the highest corner of the box around all triangles, those of glass too; none without a triangle.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        let glass = self.ungrouped.iter().filter(|shape| shape.glass.is_some());
        let meshes = self.objects.iter().map(|o| &o.mesh).chain(glass.map(|shape| &shape.mesh));
        let corners =
            meshes.flat_map(|mesh| (0..mesh.triangles.len()).flat_map(|index| mesh.corners(index)));
        corners.map(|p| [p, p]).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }

    /// The meshes of all objects, and of the shapes that belong to no group.
    pub fn meshes_mut(&mut self) -> impl Iterator<Item = &mut Mesh> {
        let objects = self.objects.iter_mut().map(|object| &mut object.mesh);
        objects.chain(self.ungrouped.iter_mut().map(|shape| &mut shape.mesh))
    }

    /// The number of triangles of all objects together.
    pub fn triangle_count(&self) -> usize {
        self.objects.iter().map(|o| o.mesh.triangles.len()).sum()
    }
}
