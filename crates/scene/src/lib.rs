//! The world as plain data: what a photograph shows, before anyone asks how it got there.
//!
//! A [`Scene`] is meshes in world space, sorted into [`Group`]s that share one reflectance, with
//! lights and cameras. Everything here is data without files, clocks or threads; readers and
//! writers live in `unrender-formats`, light transport in `unrender-render`.
//!
//! Frames, units and colour are fixed once for all crates in `docs/conventions.md`: metres, y up,
//! counter-clockwise front faces, linear RGB, radiance in W sr^-1 m^-2 per channel, radians.

pub mod camera;
pub mod color;
pub mod environment;
pub mod hypothesis;
pub mod image;
pub mod lens;
pub mod light;
pub mod material;
pub mod mesh;
pub mod validate;

pub use camera::Camera;
pub use color::Rgb;
pub use environment::{Environment, EnvironmentError};
pub use hypothesis::{Hypothesis, Status};
pub use image::{Image, RgbImage};
pub use lens::Lens;
pub use light::{Light, LightKind, Source};
pub use material::{BrdfModel, Lobe, Material, Texture, WardModel, Wrap};
pub use mesh::{Mesh, Object};
pub use validate::{SceneError, Warnings};

/// All objects that share one reflectance. In glTF: all primitives that share a material.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// The name of the material in the scene file; unique within a scene.
    pub name: String,
    /// How the group reflects light.
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

/// A complete scene: what to render, from where, in which light.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Scene {
    /// Meshes in world space; each refers to its group by index.
    pub objects: Vec<Object>,
    /// The groups, in the order of the scene file.
    pub groups: Vec<Group>,
    /// Point, spot and directional lights. Area lights are groups with an emission.
    pub lights: Vec<Light>,
    /// Light from all around, if there is any.
    pub environment: Option<Environment>,
    /// The cameras, in the order of the scene file.
    pub cameras: Vec<Camera>,
    /// Which lobe the groups' materials mean.
    pub brdf: BrdfModel,
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

    /// The number of triangles of all objects together.
    pub fn triangle_count(&self) -> usize {
        self.objects.iter().map(|o| o.mesh.triangles.len()).sum()
    }
}
