//! Shapes, cameras and colours of Mitsuba, with numbers that Mitsuba 3.9.1 itself gives (`scalar_rgb`): texture
//! coordinates, fronts, directions of pixels, and spectra as linear sRGB.

use crate::support::Folder;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_SQRT_2;
use unrender_formats::load_model;
use unrender_scene::{Mesh, Rgb, Scene, Warnings};

fn scene_in(folder: &Folder, inside: &str) -> (Scene, Warnings) {
    let text = format!("<scene version=\"3.0.0\">\n{inside}\n</scene>");
    load_model(&folder.file("scene.xml", text)).unwrap_or_else(|error| panic!("{error}"))
}

fn scene(inside: &str) -> (Scene, Warnings) {
    scene_in(&Folder::new(), inside)
}

/// The mesh of a shape of this type with `more` in it.
fn mesh(kind: &str, more: &str) -> Mesh {
    let (scene, _) = scene(&format!("<shape type=\"{kind}\">{more}</shape>"));
    scene.objects[0].mesh.clone()
}

fn to_world(steps: &str) -> String {
    format!("<transform name=\"to_world\">{steps}</transform>")
}

/// The first hit of a ray.
struct Hit {
    uv: Vec2,
    /// The front by the normals, and by the order of the corners.
    normal: Vec3,
    front: Vec3,
    /// The unit vector along which u grows.
    along_u: Vec3,
}

fn hit(mesh: &Mesh, origin: [f32; 3], direction: [f32; 3]) -> Hit {
    let (origin, direction) = (Vec3::from_array(origin), Vec3::from_array(direction));
    let mut nearest = f32::INFINITY;
    let mut found = None;
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let (ab, ac) = (b - a, c - a);
        let p = direction.cross(ac);
        let determinant = ab.dot(p);
        if determinant.abs() < 1e-9 {
            continue;
        }
        let u = (origin - a).dot(p) / determinant;
        let q = (origin - a).cross(ab);
        let (v, t) = (direction.dot(q) / determinant, ac.dot(q) / determinant);
        if u < -1e-6 || v < -1e-6 || u + v > 1.0 + 1e-6 || t < 0.0 || t >= nearest {
            continue;
        }
        nearest = t;
        let weights = [1.0 - u - v, u, v];
        let normals = triangle.map(|i| mesh.normals[i as usize]);
        let uvs = triangle.map(|i| *mesh.uvs.get(i as usize).unwrap_or(&Vec2::ZERO));
        let (d1, d2) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
        found = Some(Hit {
            uv: (0..3).map(|i| weights[i] * uvs[i]).sum(),
            normal: (0..3).map(|i| weights[i] * normals[i]).sum::<Vec3>().normalize(),
            front: ab.cross(ac).normalize(),
            along_u: ((ab * d2.y - ac * d1.y) * d1.perp_dot(d2).signum()).normalize_or_zero(),
        });
    }
    found.expect("the ray meets something")
}

/// A ray's origin and direction; (u, v), the normal and the direction of u where it hits.
type Ray = ([f32; 3], [f32; 3], [f32; 2], [f32; 3], [f32; 3]);

/// Asserts what rays meet.
fn meets(mesh: &Mesh, rays: &[Ray]) {
    for (from, along, uv, normal, along_u) in rays {
        let found = hit(mesh, *from, *along);
        let told = format!("{from:?} {along:?}: {} {} {}", found.uv, found.normal, found.along_u);
        assert!((found.uv - Vec2::from_array(*uv)).length() < 0.01, "{told}");
        assert!((found.normal - Vec3::from_array(*normal)).length() < 0.02, "{told}");
        assert!(found.front.dot(Vec3::from_array(*normal)) > 0.99, "{told}");
        assert!((found.along_u - Vec3::from_array(*along_u)).length() < 0.06, "{told}");
    }
}

#[test]
fn texture_coordinates_lie_as_mitsuba_lays_them() {
    let down = [0.0, 0.0, -1.0];
    let up = [0.0, 0.0, 1.0];
    meets(
        &mesh("disk", ""),
        &[
            ([0.5, 0.2, 5.0], down, [0.539, 0.061], up, [0.928, 0.371, 0.0]),
            ([-0.3, 0.4, 5.0], down, [0.5, 0.352], up, [-0.6, 0.8, 0.0]),
            ([0.1, -0.7, 5.0], down, [0.707, 0.773], up, [0.141, -0.99, 0.0]),
        ],
    );
    meets(&mesh("rectangle", ""), &[([0.5, 0.2, 5.0], down, [0.75, 0.6], up, [1.0, 0.0, 0.0])]);
    meets(
        &mesh("cylinder", ""),
        &[
            (
                [5.0, 0.3, 0.25],
                [-1.0, 0.0, 0.0],
                [0.048, 0.25],
                [0.954, 0.3, 0.0],
                [-0.3, 0.954, 0.0],
            ),
            (
                [0.3, 5.0, 0.75],
                [0.0, -1.0, 0.0],
                [0.202, 0.75],
                [0.3, 0.954, 0.0],
                [-0.954, 0.3, 0.0],
            ),
            (
                [0.3, -5.0, 0.75],
                [0.0, 1.0, 0.0],
                [0.798, 0.75],
                [0.3, -0.954, 0.0],
                [0.954, 0.3, 0.0],
            ),
        ],
    );
    let lying =
        "<point name=\"p1\" x=\"0\" y=\"2\" z=\"0\"/><float name=\"radius\" value=\"0.5\"/>";
    meets(
        &mesh("cylinder", lying),
        &[
            (
                [5.0, 0.5, 0.2],
                [-1.0, 0.0, 0.0],
                [0.935, 0.25],
                [0.917, 0.0, 0.4],
                [0.4, 0.0, -0.917],
            ),
            ([0.2, 0.5, 5.0], down, [0.815, 0.25], [0.4, 0.0, 0.917], [0.917, 0.0, -0.4]),
        ],
    );
    meets(
        &mesh("sphere", ""),
        &[
            (
                [5.0, 0.3, 0.25],
                [-1.0, 0.0, 0.0],
                [0.05, 0.42],
                [0.921, 0.3, 0.25],
                [-0.31, 0.951, 0.0],
            ),
            (
                [0.3, -5.0, 0.75],
                [0.0, 1.0, 0.0],
                [0.825, 0.23],
                [0.3, -0.589, 0.75],
                [0.891, 0.454, 0.0],
            ),
        ],
    );
}

#[test]
fn each_side_of_a_cube_has_the_picture_as_mitsuba_turns_it() {
    let down = [0.0, 0.0, -1.0];
    let up = [0.0, 0.0, 1.0];
    meets(
        &mesh("cube", ""),
        &[
            ([5.0, 0.2, 0.3], [-1.0, 0.0, 0.0], [0.6, 0.35], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            ([-5.0, 0.2, 0.3], [1.0, 0.0, 0.0], [0.6, 0.65], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            ([0.5, 5.0, 0.3], [0.0, -1.0, 0.0], [0.25, 0.35], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]),
            ([0.5, -5.0, 0.3], [0.0, 1.0, 0.0], [0.65, 0.75], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]),
            ([0.5, 0.2, 5.0], down, [0.6, 0.75], up, [0.0, 1.0, 0.0]),
            ([0.5, 0.2, -5.0], up, [0.4, 0.75], down, [0.0, -1.0, 0.0]),
        ],
    );
}

#[test]
fn the_front_of_what_is_mirrored_is_where_mitsuba_has_it() {
    let down = [0.0, 0.0, -1.0];
    let front = |mesh: &Mesh| {
        let found = hit(mesh, [0.5, 0.2, 5.0], down);
        assert!(found.normal.dot(found.front) > 0.9, "{} {}", found.normal, found.front);
        found.front.z.signum()
    };
    let [across, along] = ["<scale x=\"-1\"/>", "<scale z=\"-1\"/>"].map(to_world);
    let of = |kind: &str, more: &str| front(&mesh(kind, more));
    assert_eq!((of("rectangle", &across), of("rectangle", &along)), (1.0, -1.0));
    assert_eq!((of("disk", &across), of("disk", &along)), (1.0, -1.0));
    assert_eq!((of("cube", &across), of("sphere", &across)), (1.0, -1.0));
    assert_eq!(
        (of("sphere", "<boolean name=\"flip_normals\" value=\"TRUE\"/>"), of("sphere", "")),
        (-1.0, 1.0)
    );
    let folder = Folder::new();
    let corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n";
    folder.file("q.obj", format!("{corners}f 1 2 3\nf 1 3 4\n"));
    folder.file("qn.obj", format!("{corners}vn 0 0 1\nf 1//1 2//1 3//1\nf 1//1 3//1 4//1\n"));
    let of = |name: &str, more: &str| {
        let shape = format!(
            "<shape type=\"obj\"><string name=\"filename\" value=\"{name}\"/>{more}</shape>"
        );
        front(&scene_in(&folder, &shape).0.objects[0].mesh)
    };
    let flat = "<boolean name=\"face_normals\" value=\"True\"/>";
    let flipped = "<boolean name=\"flip_normals\" value=\"true\"/>";
    // Without normals the order of the corners decides the front, also after mirroring.
    assert_eq!((of("q.obj", ""), of("q.obj", &across), of("q.obj", &along)), (1.0, -1.0, 1.0));
    assert_eq!(of("q.obj", &(across.clone() + flipped)), 1.0);
    assert_eq!((of("qn.obj", &across), of("qn.obj", &along)), (1.0, -1.0));
    assert_eq!(
        (of("qn.obj", &(across.clone() + flat)), of("qn.obj", &(along.clone() + flat))),
        (-1.0, 1.0)
    );
    assert_eq!(of("qn.obj", &(along + flipped)), 1.0);
}

#[test]
fn meshes_without_normals_are_smooth_unless_told_otherwise() {
    let folder = Folder::new();
    let roof = "0 0 0\n1 0 1\n1 1 1\n0 1 0\n2 0 0\n2 1 0\n";
    let vertices: String = roof.lines().map(|line| format!("v {line}\n")).collect();
    folder.file(
        "roof.obj",
        format!("mtllib none.mtl\nusemtl none\n{vertices}f 1 2 3 4\nf 2 5 6 3\n"),
    );
    // The same with a seam of texture coordinates along the ridge.
    let uvs = "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";
    folder.file("seam.obj", format!("{vertices}{uvs}f 1/1 2/2 3/3 4/4\nf 2/1 5/2 6/3 3/4\n"));
    let header = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n\
                  property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
    folder.file("roof.ply", format!("{header}{roof}4 0 1 2 3\n4 1 4 5 2\n"));
    let ridge = |kind: &str, name: &str, more: &str| {
        let shape = format!(
            "<shape type=\"{kind}\"><string name=\"filename\" value=\"{name}\"/>{more}</shape>"
        );
        let (scene, warnings) = scene_in(&folder, &shape);
        assert!(warnings.0.is_empty(), "{warnings:?}");
        let mesh = &scene.objects[0].mesh;
        let ridge = (0..mesh.positions.len()).filter(|&i| mesh.positions[i].z > 0.5);
        ridge.map(|i| mesh.normals[i].z).fold(1.0, f32::min)
    };
    let flat = "<boolean name=\"face_normals\" value=\"True\"/>";
    assert!(ridge("obj", "roof.obj", "") > 0.999);
    assert!(ridge("ply", "roof.ply", "") > 0.999);
    let sloped = 0.5f32.sqrt();
    assert!((ridge("obj", "roof.obj", flat) - sloped).abs() < 1e-3);
    assert!((ridge("ply", "roof.ply", flat) - sloped).abs() < 1e-3);
    assert!((ridge("obj", "seam.obj", "") - sloped).abs() < 1e-3);
}

#[test]
fn what_depends_on_texture_coordinates_has_some() {
    let folder = Folder::new();
    folder.file("q.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nf 1 3 4\n");
    let brushed = "<bsdf type=\"roughconductor\"><float name=\"alpha_u\" value=\"0.1\"/>\
                   <float name=\"alpha_v\" value=\"0.3\"/></bsdf>";
    let of = |more: &str| {
        let shape = format!(
            "<shape type=\"obj\"><string name=\"filename\" value=\"q.obj\"/>{more}</shape>"
        );
        scene_in(&folder, &shape).0.objects[0].mesh.clone()
    };
    assert!(of("").uvs.is_empty());
    let down = [0.0, 0.0, -1.0];
    let up = [0.0, 0.0, 1.0];
    let at = [0.5, 0.2, 5.0];
    meets(&of(brushed), &[(at, down, [0.15, 0.6], up, [1.0, 0.0, 0.0])]);
    let mirrored = of(&(to_world("<scale x=\"-1\"/>") + brushed));
    meets(&mirrored, &[(at, down, [0.25, 0.35], down, [-0.707, 0.707, 0.0])]);
    // A vertex without vt has zeros, the others keep theirs.
    folder.file(
        "q.obj",
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\nf 1 3 4\n",
    );
    meets(&of(brushed), &[([0.5, -0.6, 5.0], down, [0.75, 0.8], up, [1.0, 0.0, 0.0])]);
}

#[test]
fn rotations_about_an_axis_that_is_no_unit_vector_shear() {
    let corner = |axis: &str| {
        let turned = to_world(&format!("<rotate {axis} angle=\"15\"/>"));
        let mesh = mesh("rectangle", &turned);
        mesh.positions.iter().copied().max_by(|a, b| (a.x + a.y).total_cmp(&(b.x + b.y))).unwrap()
    };
    let sheared = corner("y=\"1\" z=\"1\"");
    assert!(sheared.distance(Vec3::new(FRAC_1_SQRT_2, 1.258_819, -0.224_745)) < 1e-5, "{sheared}");
    let rigid = corner("y=\"0.70710678\" z=\"0.70710678\"");
    assert!(rigid.distance(Vec3::new(0.782_913, 1.165_976, -0.165_976)) < 1e-5, "{rigid}");
}

#[test]
fn textures_are_laid_by_their_own_transform() {
    let board =
        "<bsdf type=\"diffuse\" id=\"board\"><texture type=\"checkerboard\" name=\"reflectance\">
        <transform name=\"to_uv\"><scale x=\"4\" y=\"2\"/><translate x=\"0.5\"/></transform>
        <rgb name=\"color0\" value=\"0.8\"/><rgb name=\"color1\" value=\"0.1\"/></texture></bsdf>";
    let (scene, warnings) = scene(&format!("<shape type=\"rectangle\">{board}</shape>"));
    let mesh = &scene.objects[0].mesh;
    let corner = mesh.positions.iter().position(|p| p.x > 0.0 && p.y > 0.0).unwrap();
    assert_eq!(mesh.uvs[corner], Vec2::new(4.5, 2.0));
    let material = &scene.groups[0].material;
    assert!((material.rho_d.x - 0.45).abs() < 1e-3);
    for (uv, wanted) in
        [([0.2, 0.2], 0.8), ([0.7, 0.2], 0.1), ([1.7, -0.3], 0.8), ([0.2, 0.7], 0.1)]
    {
        assert!((material.rho_d_at(Vec2::from_array(uv)).x - wanted).abs() < 1e-6, "{uv:?}");
    }
    assert!(warnings.0.is_empty(), "{warnings:?}");
    let folder = Folder::new();
    let image = unrender_scene::Image::new(2, 1, vec![Rgb::ZERO, Rgb::splat(0.5)]);
    unrender_formats::picture::write_exr(&folder.path("t.exr"), &image).unwrap();
    let sharp = "<shape type=\"rectangle\"><bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\">
        <string name=\"filename\" value=\"t.exr\"/><string name=\"filter_type\" value=\"nearest\"/></texture></bsdf></shape>";
    let material = &scene_in(&folder, sharp).0.groups[0].material;
    let at = |u: f32| material.rho_d_at(Vec2::new(u, 0.5)).x;
    assert_eq!((at(0.45), at(0.55)), (0.0, 0.5));
}

#[test]
fn cameras_see_what_mitsubas_see() {
    let film = "<integer name=\"width\" value=\"320\"/><integer name=\"height\" value=\"240\"/>";
    let crop = format!(
        "{film}<integer name=\"crop_offset_x\" value=\"150\"/><integer name=\"crop_offset_y\" value=\"20\"/>\
         <integer name=\"crop_width\" value=\"160\"/><integer name=\"crop_height\" value=\"100\"/>"
    );
    let fov = "<float name=\"fov\" value=\"50\"/>";
    let offset = format!(
        "{fov}<string name=\"fov_axis\" value=\"Y\"/><float name=\"principal_point_offset_x\" value=\"0.1\"/>\
         <float name=\"principal_point_offset_y\" value=\"-0.05\"/>"
    );
    let focal = |text: &str| format!("<string name=\"focal_length\" value=\"{text}\"/>");
    let (full, cropped) = ((320, 240), (160, 100));
    let cases = [
        (fov, film, full, [[-0.22384, -0.32343, -0.9194], [0.40287, 0.15601, -0.90187]]),
        (fov, &crop, cropped, [[0.08687, -0.09194, -0.99197], [0.387, 0.10895, -0.91562]]),
        (&offset, &crop, cropped, [[0.23197, -0.02174, -0.97248], [0.54409, 0.20379, -0.8139]]),
        (
            &focal("85mm"),
            film,
            full,
            [[-0.10099, -0.2378, -0.96605], [0.19732, -0.01335, -0.98025]],
        ),
        (&focal("85"), film, full, [[-0.10099, -0.2378, -0.96605], [0.19732, -0.01335, -0.98025]]),
        ("", film, full, [[-0.16915, -0.28582, -0.94324], [0.31767, 0.08413, -0.94446]]),
    ];
    for (inner, film, (width, height), wanted) in cases {
        let at = to_world("<lookat origin=\"0,2,6\" target=\"0,1,0\" up=\"0,1,0\"/>");
        let sensor = format!(
            "<sensor type=\"perspective\">{inner}{at}<film type=\"hdrfilm\">{film}</film></sensor>"
        );
        let (scene, warnings) = scene(&(sensor + "<shape type=\"cube\"/>"));
        assert!(warnings.0.is_empty(), "{warnings:?}");
        let camera = &scene.cameras[0];
        assert_eq!(camera.aspect, Some(width as f32 / height as f32));
        let (w, h) = (width as f32, height as f32);
        let seen =
            [(0.25 * w, 0.75 * h), (w, 0.0)].map(|(x, y)| camera.direction(x, y, width, height));
        for (seen, wanted) in seen.iter().zip(wanted) {
            assert!((*seen - Vec3::from_array(wanted)).length() < 1e-4, "{inner} {film}: {seen}");
        }
    }
    for (inner, said) in [
        ("<float name=\"fov\" value=\"180\"/>", "\"fov\" is not between 0 and 180"),
        ("<string name=\"focal_length\" value=\"long\"/>", "\"focal_length\" is not a length"),
        (
            "<film type=\"hdrfilm\"><integer name=\"crop_width\" value=\"9000\"/></film>",
            "beyond the film",
        ),
    ] {
        let folder = Folder::new();
        let text = format!(
            "<scene version=\"3.0.0\"><sensor type=\"perspective\">{inner}</sensor></scene>"
        );
        let told = load_model(&folder.file("scene.xml", text)).unwrap_err().to_string();
        assert!(told.contains("line 1: ") && told.contains(said), "{told}");
    }
}

#[test]
fn colors_are_those_of_mitsubas_rgb_modes() {
    let folder = Folder::new();
    folder.file("warm.spd", "# a lamp\n400 0\n500 8\n600 15.6\n700 18.4\n");
    let emitted = |radiance: &str| {
        let shape =
            format!("<shape type=\"sphere\"><emitter type=\"area\">{radiance}</emitter></shape>");
        scene_in(&folder, &shape).0.groups[0].emission
    };
    let close = |found: Rgb, wanted: [f32; 3]| {
        assert!(
            (found - Rgb::from_array(wanted)).length() < 1e-3 * found.length(),
            "{found} {wanted:?}"
        );
    };
    close(emitted("<spectrum name=\"radiance\" value=\"10\"/>"), [12.0479, 9.4829, 9.0892]);
    let warm = [20.7108, 10.8546, 2.7712];
    close(
        emitted("<spectrum name=\"radiance\" value=\"400:0, 500:8, 600:15.6, 700:18.4\"/>"),
        warm,
    );
    close(emitted("<spectrum name=\"radiance\" filename=\"warm.spd\"/>"), warm);
    let irregular = "<spectrum type=\"irregular\" name=\"radiance\"><string name=\"wavelengths\" value=\"400 500 600 700\"/>\
                     <string name=\"values\" value=\"0, 8, 15.6, 18.4\"/></spectrum>";
    close(emitted(irregular), warm);
    let regular = "<spectrum type=\"regular\" name=\"radiance\"><float name=\"wavelength_min\" value=\"400\"/>\
                   <float name=\"wavelength_max\" value=\"700\"/><string name=\"values\" value=\"0 8 15.6 18.4\"/></spectrum>";
    close(emitted(regular), warm);
    close(emitted("<float name=\"radiance\" value=\"2\"/>"), [2.0; 3]);
    close(
        emitted(
            "<spectrum name=\"radiance\" type=\"d65\"><float name=\"scale\" value=\"3\"/></spectrum>",
        ),
        [3.0; 3],
    );
    close(
        emitted(
            "<spectrum name=\"radiance\" type=\"uniform\"><float name=\"value\" value=\"3\"/></spectrum>",
        ),
        [3.0; 3],
    );
    let hot = "<spectrum name=\"radiance\" type=\"blackbody\"><float name=\"temperature\" value=\"6500\"/></spectrum>";
    let hot = emitted(hot);
    assert!((hot / hot.y - Rgb::ONE).abs().max_element() < 0.1, "{hot}");

    let reflected = |color: &str| {
        let shape = format!("<shape type=\"sphere\"><bsdf type=\"diffuse\">{color}</bsdf></shape>");
        scene_in(&folder, &shape).0.groups[0].material.rho_d
    };
    close(reflected("<spectrum name=\"reflectance\" value=\"0.3\"/>"), [0.3; 3]);
    let red = "<spectrum name=\"reflectance\" value=\"400:0.05, 550:0.1, 600:0.7, 700:0.7\"/>";
    close(reflected(red), [0.8364, 0.1592, 0.0415]);
    close(
        reflected("<spectrum name=\"reflectance\" value=\"400:0.5, 700:0.5\"/>"),
        [0.4977, 0.4999, 0.4975],
    );

    let mirrored = |metal: &str| {
        let shape =
            format!("<shape type=\"sphere\"><bsdf type=\"conductor\">{metal}</bsdf></shape>");
        scene_in(&folder, &shape).0.groups[0].material.rho_s
    };
    close(mirrored(""), [1.0; 3]);
    close(mirrored("<string name=\"material\" value=\"Cu\"/>"), [0.952, 0.620, 0.511]);
    close(
        mirrored("<spectrum name=\"eta\" value=\"0.789\"/><spectrum name=\"k\" value=\"6.15\"/>"),
        [0.92307; 3],
    );
    let spectra = "<spectrum name=\"eta\" value=\"400:0.2,700:1\"/><spectrum name=\"k\" value=\"400:3,700:5\"/>";
    close(mirrored(spectra), [0.86248, 0.87172, 0.90004]);

    let plastic = |more: &str| {
        let color = "<rgb name=\"diffuse_reflectance\" value=\"0.1 0.5 0.9\"/>";
        let shape =
            format!("<shape type=\"sphere\"><bsdf type=\"plastic\">{color}{more}</bsdf></shape>");
        let material = &scene_in(&folder, &shape).0.groups[0].material;
        material.rho_d * material.base_seen()
    };
    let near = |found: Rgb, wanted: [f32; 3]| {
        assert!((found - Rgb::from_array(wanted)).length() < 0.01, "{found} {wanted:?}");
    };
    // pi f from the normal to the normal of Mitsuba 3.9.1's.
    near(plastic(""), [0.1017, 0.5085, 0.9153]);
    near(plastic("<boolean name=\"nonlinear\" value=\"true\"/>"), [0.0443, 0.2955, 0.8000]);
}
