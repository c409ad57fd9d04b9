//! The scenes that are mutated by meaning: four small ones, each with other lamps.

use glam::{Vec2, Vec3};
use std::sync::Arc;
use unrender::scene::reflectance::Layering;
use unrender::scene::{
    BrdfModel, Camera, Group, Image, Light, LightKind, Material, Mesh, Object, Rgb, Scene, Texture,
    Wrap,
};

/// A scene and the light from all around, which no glTF file holds.
#[derive(Clone, Debug, Default)]
pub(super) struct World {
    pub(super) scene: Scene,
    /// The radiance from everywhere, if there is any.
    pub(super) around: Option<Rgb>,
}

/// The seeds.
pub(super) const ROOMS: [fn() -> World; 4] = [closed_room, table, yard, shelf];

/// A closed room with a box on its floor, and a lamp below the ceiling.
fn closed_room() -> World {
    let mut world = World::principled();
    let grey = |share| Material::diffuse(Rgb::splat(share));
    world.quad("floor", Vec3::ZERO, Vec3::X * 2.0, Vec3::NEG_Z * 2.0, checks());
    world.quad("ceiling", Vec3::Y * 2.0, Vec3::NEG_Z * 2.0, Vec3::X * 2.0, grey(0.8));
    world.quad("back", Vec3::NEG_Z * 2.0, Vec3::X * 2.0, Vec3::Y * 2.0, grey(0.7));
    let red = Material::diffuse(Rgb::new(0.6, 0.1, 0.1));
    world.quad("left", Vec3::ZERO, Vec3::NEG_Z * 2.0, Vec3::Y * 2.0, red);
    let plastic = Material::plastic(Rgb::new(0.1, 0.4, 0.1), 1.5, Layering::default(), 0.2);
    world.quad("right", Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::NEG_Z * 2.0, plastic);
    world.cuboid("box", Vec3::new(0.5, 0.0, -1.5), Vec3::new(0.6, 0.8, 0.6), grey(0.5));
    world.lamp(Vec3::new(0.6, 1.95, -1.4), Vec3::X * 0.8, Vec3::Z * 0.8, 6.0);
    world.seen(Vec3::new(1.0, 1.2, 2.0), Vec3::new(1.0, 0.8, -1.5))
}

/// A metal ball and a box on a table before a wall, lit by a bulb and a point.
fn table() -> World {
    let mut world = World::principled();
    let wood = Material::isotropic(Rgb::new(0.4, 0.25, 0.1), Rgb::splat(0.05), 0.15);
    world.quad("table", Vec3::new(-1.0, 0.0, 1.0), Vec3::X * 2.0, Vec3::NEG_Z * 2.0, wood);
    let wall = Material::diffuse(Rgb::splat(0.75));
    world.quad("wall", Vec3::new(-1.0, 0.0, -1.0), Vec3::X * 2.0, Vec3::Y * 1.5, wall);
    let metal = Material::metal(Rgb::new(0.9, 0.7, 0.4), true, 0.25);
    world.ball("ball", Vec3::new(0.4, 0.3, 0.0), 0.3, metal, 0.0);
    let box_material = Material::diffuse(Rgb::new(0.2, 0.3, 0.6));
    world.cuboid("box", Vec3::new(-0.7, 0.0, -0.4), Vec3::splat(0.4), box_material);
    world.ball("lamp", Vec3::new(-0.3, 1.3, 0.5), 0.08, Material::diffuse(Rgb::ZERO), 60.0);
    let (position, intensity) = (Vec3::new(0.9, 1.0, 0.9), Rgb::new(0.8, 0.7, 0.5));
    world.shine("point", LightKind::Point { position, intensity });
    world.seen(Vec3::new(0.0, 0.9, 2.2), Vec3::new(0.0, 0.3, 0.0))
}

/// Two walls and a pillar under the sun and a sky.
fn yard() -> World {
    let mut world = World { around: Some(Rgb::new(0.5, 0.6, 0.8)), ..World::default() };
    let ground = Material::diffuse(Rgb::new(0.35, 0.3, 0.25));
    world.quad("ground", Vec3::new(-3.0, 0.0, 3.0), Vec3::X * 6.0, Vec3::NEG_Z * 6.0, ground);
    world.quad("wall", Vec3::new(-3.0, 0.0, -3.0), Vec3::X * 6.0, Vec3::Y * 2.0, checks());
    let side = Material::diffuse(Rgb::splat(0.6));
    world.quad("side", Vec3::new(-3.0, 0.0, 3.0), Vec3::NEG_Z * 6.0, Vec3::Y * 2.0, side);
    let mirror = Material::mirror(Rgb::splat(0.8));
    world.cuboid("pillar", Vec3::new(0.5, 0.0, -1.0), Vec3::new(0.5, 1.8, 0.5), mirror);
    let direction = Vec3::new(0.4, -1.0, -0.5).normalize();
    world.shine("sun", LightKind::Directional { direction, irradiance: Rgb::new(3.0, 2.8, 2.4) });
    world.seen(Vec3::new(0.5, 1.5, 4.5), Vec3::new(0.0, 0.7, -1.0))
}

/// Boards with few pixels each under a spot; one is brushed.
fn shelf() -> World {
    let mut world = World::default();
    let back = Material::diffuse(Rgb::splat(0.5));
    world.quad("back", Vec3::new(-1.0, 0.0, 0.0), Vec3::X * 2.0, Vec3::Y * 2.0, back);
    let brushed = Material { alpha_x: 0.1, alpha_y: 0.4, ..Material::mirror(Rgb::splat(0.6)) };
    let glossy = Material::isotropic(Rgb::new(0.5, 0.4, 0.1), Rgb::splat(0.1), 0.05);
    let plain = Material::diffuse(Rgb::new(0.1, 0.5, 0.5));
    let black = Material::diffuse(Rgb::ZERO);
    for (row, (name, material)) in
        [("brushed", brushed), ("glossy", glossy), ("plain", plain), ("black", black)]
            .into_iter()
            .enumerate()
    {
        let corner = Vec3::new(-0.9, 0.3 + 0.4 * row as f32, 0.0);
        world.cuboid(name, corner, Vec3::new(1.8, 0.06, 0.4), material);
    }
    world.lamp(Vec3::new(-0.3, 2.2, 0.2), Vec3::X * 0.6, Vec3::Z * 0.3, 3.0);
    let (position, direction) = (Vec3::new(0.3, 1.8, 2.0), Vec3::new(-0.1, -0.5, -1.0).normalize());
    let intensity = Rgb::splat(5.0);
    let (inner_rad, outer_rad) = (0.3, 0.6);
    let kind = LightKind::Spot { position, direction, intensity, inner_rad, outer_rad };
    world.shine("spot", kind);
    world.scene.brdf = BrdfModel::Ggx;
    world.seen(Vec3::new(0.2, 1.6, 2.6), Vec3::new(0.0, 0.9, 0.0))
}

/// A diffuse material with a texture of four texels.
fn checks() -> Material {
    let image = Image::from_fn(2, 2, |x, y| if x == y { Rgb::splat(0.7) } else { Rgb::splat(0.3) });
    let texture = Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat };
    Material { texture: Some(Arc::new(texture)), ..Material::diffuse(Rgb::splat(0.5)) }
}

impl World {
    fn principled() -> Self {
        let brdf = BrdfModel::Principled(Layering::default());
        Self { scene: Scene { brdf, ..Scene::default() }, around: None }
    }

    /// Adds a group of one object.
    pub(super) fn add(&mut self, name: &str, mesh: Mesh, material: Material, emission: Rgb) {
        let group = self.scene.groups.len();
        self.scene.groups.push(Group { name: name.into(), material, emission });
        self.scene.objects.push(Object { name: name.into(), group, mesh });
    }

    fn quad(&mut self, name: &str, corner: Vec3, along: Vec3, up: Vec3, material: Material) {
        self.add(name, quad(corner, along, up), material, Rgb::ZERO);
    }

    fn lamp(&mut self, corner: Vec3, along: Vec3, up: Vec3, radiance: f32) {
        let material = Material::diffuse(Rgb::ZERO);
        self.add("lamp", quad(corner, along, up), material, Rgb::splat(radiance));
    }

    fn ball(&mut self, name: &str, at: Vec3, radius: f32, material: Material, radiance: f32) {
        self.add(name, Mesh::sphere(at, radius), material, Rgb::splat(radiance));
    }

    fn cuboid(&mut self, name: &str, corner: Vec3, sides: Vec3, material: Material) {
        let corners: Vec<Vec3> = (0..8)
            .map(|i| {
                corner + sides * Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)
            })
            .collect();
        let faces =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        let triangles: Vec<[u32; 3]> = faces.into_iter().flat_map(halves).collect();
        self.add(name, Mesh::flat(&corners, &[], &triangles), material, Rgb::ZERO);
    }

    pub(super) fn shine(&mut self, name: &str, kind: LightKind) {
        self.scene.lights.push(Light { name: name.into(), kind });
    }

    fn seen(mut self, eye: Vec3, target: Vec3) -> Self {
        let camera = Camera::look_at("camera", eye, target, Vec3::Y, 0.8);
        self.scene.cameras.push(Camera { aspect: Some(4.0 / 3.0), ..camera });
        self
    }
}

/// A parallelogram; its front is where `along` to `up` goes counter-clockwise.
pub(super) fn quad(corner: Vec3, along: Vec3, up: Vec3) -> Mesh {
    let corners = [corner, corner + along, corner + along + up, corner + up];
    let uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    Mesh::flat(&corners, &uvs, &[[0, 1, 2], [0, 2, 3]])
}
