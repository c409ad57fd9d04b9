//! A room with a rough ball on uneven ground, with any number of triangles and groups.

use super::cube::blown_up_cube;
use super::noise::fbm;
use glam::Vec3;
use unrender::scene::{Camera, Group, Material, Mesh, Object, Rgb, Scene};

/// Half of the room's width and length, metres.
const HALF: f32 = 2.0;
const HEIGHT: f32 = 3.0;
const RADIUS: f32 = 0.75;
const OCTAVES: i32 = 7;

/// The size of a room.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    /// The least number of triangles; ten of them and those of the panels are flat.
    pub(crate) triangles: usize,
    /// Panels of the back wall, each with its own group.
    pub(crate) panels: usize,
}

/// A closed room, seen from inside: three fifths of the triangles are those of a ball, the rest
/// those of the ground, both displaced by noise. A small lamp hangs below the ceiling.
pub(crate) fn room(wanted: Room) -> Scene {
    let side = |share: f64, per_cell: f64| {
        (share * wanted.triangles as f64 / per_cell).sqrt().ceil().max(1.0) as i32
    };
    let mut scene = Scene::default();
    let mut add = |name: &str, material: Material, emission: Rgb, mesh: Mesh| {
        let group = scene.groups.len();
        scene.groups.push(Group { name: name.to_owned(), material, emission });
        scene.objects.push(Object { name: name.to_owned(), group, mesh });
    };
    let ground = Material::isotropic(Rgb::new(0.35, 0.3, 0.25), Rgb::splat(0.2), 0.15);
    add("ground", ground, Rgb::ZERO, ground_mesh(side(0.4, 2.0)));
    let ball = Material::isotropic(Rgb::new(0.2, 0.3, 0.45), Rgb::splat(0.3), 0.2);
    add("ball", ball, Rgb::ZERO, ball_mesh(side(0.6, 12.0)));
    let [x, y, z] = [Vec3::X * 2.0 * HALF, Vec3::Y * (HEIGHT + 0.5), Vec3::Z * 2.0 * HALF];
    let low = Vec3::new(-HALF, -0.5, -HALF);
    let walls = [
        ("left_wall", Rgb::new(0.6, 0.15, 0.1), low + z, -z, y),
        ("right_wall", Rgb::new(0.15, 0.5, 0.15), low + x, z, y),
        ("front_wall", Rgb::splat(0.6), low + x + z, -x, y),
        ("ceiling", Rgb::splat(0.75), low + y, x, z),
    ];
    for (name, rho_d, corner, across, up) in walls {
        add(name, Material::diffuse(rho_d), Rgb::ZERO, quad(corner, across, up));
    }
    for panel in 0..wanted.panels {
        let width = x / wanted.panels as f32;
        let material = Material::diffuse(panel_color(panel));
        let mesh = quad(low + width * panel as f32, width, y);
        add(&format!("panel_{panel}"), material, Rgb::ZERO, mesh);
    }
    let lamp = Vec3::new(-0.3, HEIGHT - 0.05, -0.1);
    let mesh = quad(lamp, Vec3::X * 0.6, Vec3::Z * 0.6);
    add("lamp", Material::diffuse(Rgb::ZERO), Rgb::splat(24.0), mesh);
    let eye = Vec3::new(0.5, 1.5, 1.95);
    scene.cameras.push(Camera::look_at("camera", eye, Vec3::new(0.0, 0.9, 0.0), Vec3::Y, 1.1));
    scene
}

/// Muted colours, all different.
fn panel_color(panel: usize) -> Rgb {
    let share = |step: f32| 0.35 + 0.3 * ((panel as f32 * step).fract() - 0.5);
    Rgb::new(share(0.618), share(0.382), share(0.271))
}

/// A parallelogram; seen from its front, `up` is counter-clockwise from `across`.
fn quad(corner: Vec3, across: Vec3, up: Vec3) -> Mesh {
    let positions = [corner, corner + across, corner + across + up, corner + up];
    Mesh::flat(&positions, &[], &[[0, 1, 2], [0, 2, 3]])
}

/// Uneven ground of `cells` x `cells` x 2 triangles; it extends a little into the walls.
fn ground_mesh(cells: i32) -> Mesh {
    let at = |i: i32, j: i32| {
        let side = |k: i32| (HALF + 0.05) * (2 * k - cells) as f32 / cells as f32;
        let (x, z) = (side(i), side(j));
        Vec3::new(x, 0.12 * fbm(Vec3::new(1.5 * x, 7.3, 1.5 * z), OCTAVES), z)
    };
    let mut mesh = Mesh::default();
    let row = cells as u32 + 1;
    for j in 0..=cells {
        mesh.positions.extend((0..=cells).map(|i| at(i, j)));
    }
    for (j, i) in (0..row - 1).flat_map(|j| (0..row - 1).map(move |i| (j, i))) {
        let near = j * row + i;
        mesh.triangles.push([near, near + row, near + row + 1]);
        mesh.triangles.push([near, near + row + 1, near + 1]);
    }
    smooth(mesh)
}

/// A rough ball of `cells` x `cells` x 12 triangles.
fn ball_mesh(cells: i32) -> Mesh {
    smooth(blown_up_cube(cells, |direction| {
        let radius = RADIUS * (1.0 + 0.25 * fbm(2.0 * direction + Vec3::splat(31.7), OCTAVES));
        Vec3::new(0.0, 0.95, 0.0) + radius * direction
    }))
}

/// The mesh with normals that are the means of those of the adjacent triangles, weighted by area.
fn smooth(mut mesh: Mesh) -> Mesh {
    mesh.normals = vec![Vec3::ZERO; mesh.positions.len()];
    for index in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(index);
        for vertex in mesh.triangles[index] {
            mesh.normals[vertex as usize] += (b - a).cross(c - a);
        }
    }
    mesh.normals.iter_mut().for_each(|normal| *normal = normal.normalize_or(Vec3::Y));
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender::render::Tracer;

    #[test]
    fn a_room_is_closed_and_has_what_was_asked_for() {
        let mut scene = room(Room { triangles: 20_000, panels: 3 });
        assert!((20_000..22_000).contains(&scene.triangle_count()), "{}", scene.triangle_count());
        assert_eq!(scene.groups.len(), 10);
        assert_eq!(scene.validate().unwrap().0, Vec::<String>::new());
        let geometry = Tracer::new(&scene).geometry(&scene.cameras[0], 64, 48);
        let seen = |group: usize| geometry.pixels().iter().any(|p| p.group as usize == group);
        assert!(geometry.pixels().iter().all(|p| p.group != unrender::render::NOTHING));
        assert!(seen(0) && seen(1) && (6..9).all(seen), "ground, ball and panels are seen");
    }
}
