//! What the surfaces of a USD material are made from, and the nodes that they are made of. [OpenUSD, UsdShade]

use super::stage::{Prim, Value};
use crate::export::layered::Layered;
use unrender_scene::{Material, Rgb};

/// A picture that a surface reads by the texture coordinates of meshes.
pub(super) struct Picture {
    /// The path of its file in the stage.
    pub(super) asset: String,
    /// Whether it repeats to the sides; else its edge is held.
    pub(super) repeats: [bool; 2],
}

/// What a surface shows of a group.
pub(super) struct Group<'a> {
    /// The material.
    pub(super) material: &'a Material,
    /// Its layers.
    pub(super) layered: Layered,
    /// The radiance that it emits.
    pub(super) emission: Rgb,
    /// The picture of its base colour.
    pub(super) texture: Option<Picture>,
    /// The picture of its normals, 0 to 1 for -1 to 1.
    pub(super) normals: Option<Picture>,
    /// The picture of its coverage, and the least coverage that is there.
    pub(super) holes: Option<(Picture, f32)>,
}

impl Group<'_> {
    /// Whether texture coordinates are read.
    pub(super) fn has_pictures(&self) -> bool {
        self.texture.is_some() || self.normals.is_some() || self.holes.is_some()
    }
}

/// A material prim in the making.
pub(super) struct Network {
    /// The material.
    pub(super) prim: Prim,
    /// Its path.
    pub(super) path: String,
}

impl Network {
    /// The material `name`, called `id`, below the path `parent`.
    pub(super) fn new(parent: &str, id: &str, name: &str) -> Self {
        let mut prim = Prim::new("Material", id).named(name).with_schema("MaterialXConfigAPI");
        // The version that has OpenPBR; readers take an older one if none is stated.
        prim.set_uniform("string", "config:mtlx:version", Value::String("1.39".into()));
        Self { prim, path: format!("{parent}/{id}") }
    }

    /// Adds the node `name` of the kind `id`, made by `inputs`, with its output `output` of the type `kind`; returns the
    /// path of that.
    pub(super) fn node(
        &mut self,
        name: &str,
        id: &str,
        (kind, output): (&'static str, &'static str),
        inputs: impl FnOnce(&mut Prim),
    ) -> String {
        let mut node = Prim::new("Shader", name);
        node.set_uniform("token", "info:id", Value::token(id));
        inputs(&mut node);
        node.declare(kind, output);
        self.prim.children.push(node);
        format!("{}/{name}.{output}", self.path)
    }
}
