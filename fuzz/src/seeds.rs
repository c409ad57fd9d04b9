//! The seed files: small files of every kind, written here or kept in `fuzz/seeds`, and the findings of
//! earlier searches.

use glam::{Vec2, Vec3};
use std::fs;
use std::path::Path;
use std::sync::Arc;
use unrender::formats::export::{SceneView, Target as Program, export};
use unrender::formats::{LightUnits, gltf, merl, picture, planes};
use unrender::scene::{
    Camera, Group, Image, Material, MeasuredBrdf, Mesh, Object, Rgb, Scene, Texture, Wrap,
};

const PROJECT: &str = r#"scene = "a.glb"
photo = "a.png"
response = { gamma = 2.2 }
exposure = [1.0, 2.0, 3.0]
black_level = 0.01
camera = { eye = [0, 1, 2], target = [0, 0, 0], up = [0, 1, 0], fov_y_deg = 40 }
[groups.wall]
known = { rho_d = [0.5, 0.5, 0.5], rho_s = 0.1, alpha_x = 0.1, alpha_y = 0.2, theta_deg = 3 }
[recover]
brdf = "ward-1992"
"#;
const EDIT: &str = r#"scene = "seed.glb"
[camera]
eye = [0, 1, 2]
target = [0, 0, 0]
[[remove]]
name = "wall"
[[repaint]]
group = "lamp"
rho_d = [0.5, 0.1, 0.1]
[[lights]]
name = "l"
add = "area"
strength = 3
position = [0, 1, 0]
direction = [0, -1, 0]
size = [1, 1]
"#;
const TABLES: [&str; 2] =
    ["name,x_px,y_px,x_m,y_m,z_m\na,1,2,3,4,5\nb,2,3,4,5,6\n", "code,linear\n0,0\n0.5,0.2\n1,1\n"];
const OBJ: &str = "# a\no a\nv 0 0 0\nv 1 0 0 1 1 1\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\ns 1\nusemtl m\n\
                   f 1/1/1 2/1/1 3/1/1 \\\n 4/1/1\nf -1 -2 -3\ng b\nf 1//1 2//1 3//1\nl 1 2\np 1\n\
                   usemtl n #2\nf 1/1 2 3//1\n";
const MTL: &str = "newmtl m\nKd 0.5 0.4 0.3\nKs 0.1 0.1 0.1\nNs 20\nillum 2\nKe 0 \\\n0 0\nd 0.5\n\
                   map_Ke e.png\nmap_Kd -s 1 1 1 -clamp off seed.png\n";

const CALIBRATIONS: [&str; 3] = [
    "%YAML:1.0\n---\nimage_width: 4\nimage_height: 3\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   \
     cols: 3\n   dt: d\n   data: [ 5., 0., 2., 0., 5., 1., 0., 0., 1. ]\nD: [0.1, 0, 0, 0, 0]\n\
     rvec: [1, 2, 3]\ntvec: [1, 2, 3]\n",
    "{\"K\": [[5, 0, 2], [0, 5, 1], [0, 0, 1]], \"extrinsic_parameters\": [[1, 2, 3, 4, 5, 6]]}",
    "<opencv_storage><K><rows>3</rows><cols>3</cols><data>5 0 2 0 5 1 0 0 1</data></K></opencv_storage>",
];
const RECONSTRUCTIONS: [&str; 2] = [
    "# cameras\n1 OPENCV 640 480 500 510 321 241 -0.1 0.02 0.001 -0.002\n",
    "# images\n1 1 0 0 0 0.5 0 2 1 hall/a.jpg\n100.5 20.25 -1\n",
];

const PROFILES: [&str; 2] = [
    "IESNA:LM-63-1995\n[TEST] a\nTILT=INCLUDE\n1\n2\n0 90\n1 0.9\n1 1000 1 3 2 1 2 0.1 0.2 0\n1 0.9 20\n0 45 90\n\
     0 90\n100 70 0\n100 60 0\n",
    "a lamp\nTILT=NONE\n1,1000,1 2 3 2 1 0 0 0\n1 1 0\n-90 90\n-45 0 45\n1 2 3 4 5 6\n",
];
const MATERIALX: &str = r#"<?xml version="1.0"?>
<materialx version="1.39" colorspace="lin_rec709" fileprefix="">
<nodegraph name="g"><input name="t" type="color3" value="0.5, 1, 1"/>
<image name="i" type="color3"><input name="file" type="filename" value="seed.png" colorspace="srgb_texture"/></image>
<multiply name="p" type="color3"><input name="in1" type="color3" nodename="i"/><input name="in2" type="color3" interfacename="t"/></multiply>
<separate3 name="s" type="multioutput"><input name="in" type="color3" nodename="i"/></separate3>
<normalmap name="n" type="vector3"><input name="in" type="vector3" nodename="i"/></normalmap>
<output name="c" type="color3" nodename="p"/><output name="r" type="float" nodename="s" output="outy"/></nodegraph>
<open_pbr_surface name="o" type="surfaceshader"><input name="base_color" type="color3" nodegraph="g" output="c"/>
<input name="specular_roughness" type="float" nodegraph="g" output="r"/><input name="coat_weight" type="float" value="0.5"/></open_pbr_surface>
<gltf_pbr name="q" type="surfaceshader"><input name="anisotropy_strength" type="float" value="0.5"/></gltf_pbr>
<surfacematerial name="m" type="material"><input name="surfaceshader" type="surfaceshader" nodename="o"/></surfacematerial>
<surfacematerial name="Gold" type="material"><input name="surfaceshader" type="surfaceshader" nodename="q"/></surfacematerial>
<look name="l"><materialassign name="x" material="Gold" geom="/a"/></look></materialx>
"#;

/// The seeds of the target called `name`.
pub(crate) fn of(name: &str) -> Vec<Vec<u8>> {
    let mut seeds = match name {
        "project" => vec![PROJECT.into()],
        "edit" => vec![EDIT.into()],
        "csv" => TABLES.map(Into::into).to_vec(),
        "obj" => vec![OBJ.into()],
        "mtl" => vec![MTL.into()],
        "fspy" => vec![fspy()],
        "ies" => PROFILES.map(Into::into).to_vec(),
        "binary" => vec![measured()],
        "mtlx" => [exported("mtlx"), vec![MATERIALX.into()]].concat(),
        "opencv" => CALIBRATIONS.map(Into::into).to_vec(),
        "colmap" => RECONSTRUCTIONS.map(Into::into).to_vec(),
        "colmap_bin" => vec![colmap_images()],
        "part" => vec![part()],
        "glb" => gltf::to_glb(&scene()).into_iter().collect(),
        "ply" | "xml" | "rad" | "vf" => exported(name),
        "png" | "exr" | "hdr" => written(name),
        _ => Vec::new(),
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for folder in ["seeds", "../crates/formats/tests/data/hostile"] {
        let files = fs::read_dir(root.join(folder)).into_iter().flatten().flatten();
        let mut paths: Vec<_> = files.map(|entry| entry.path()).collect();
        paths.sort();
        let is_mine = |path: &&std::path::PathBuf| {
            path.extension().is_some_and(|e| e == name)
                || path.file_name().is_some_and(|f| *f == *format!("{name}.json"))
        };
        seeds.extend(paths.iter().filter(is_mine).filter_map(|path| fs::read(path).ok()));
    }
    if seeds.is_empty() {
        seeds.push(Vec::new());
    }
    seeds
}

fn scene() -> Scene {
    let mut scene = Scene::default();
    let corners = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
    let uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    for (group, name) in ["wall", "lamp"].into_iter().enumerate() {
        let mesh = Mesh::flat(&corners, &uvs, &[[0, 1, 2], [0, 2, 3]]);
        let mut material = Material::isotropic(Rgb::splat(0.4), Rgb::splat(0.1), 0.2);
        if group == 0 {
            let image = Image::from_fn(2, 2, |x, y| Rgb::new(0.5 * x as f32, 0.5 * y as f32, 0.2));
            let (wrap_u, wrap_v) = (Wrap::Repeat, Wrap::MirroredRepeat);
            material.texture = Some(Arc::new(Texture { image, wrap_u, wrap_v }));
        }
        let emission = Rgb::splat(group as f32);
        scene.groups.push(Group { name: name.into(), material, emission });
        scene.objects.push(Object { name: name.into(), group, mesh });
    }
    scene.cameras.push(Camera::look_at("c", Vec3::Z * 3.0, Vec3::ZERO, Vec3::Y, 0.8));
    scene
}

fn exported(extension: &str) -> Vec<Vec<u8>> {
    let scene = scene();
    let program = match extension {
        "rad" | "vf" => Program::Radiance,
        "mtlx" => Program::Materialx,
        _ => Program::Mitsuba,
    };
    let materials = scene.materials();
    let camera = &scene.cameras[0];
    let light_units = LightUnits::default();
    let shot =
        SceneView { scene: &scene, materials: &materials, camera, size: (4, 3), light_units };
    let files = export(&shot, program, program.usual_name().as_ref())
        .map(|(files, _)| files)
        .unwrap_or_default();
    let is_mine = |name: &str| name.rsplit('.').next() == Some(extension);
    files.into_iter().filter(|(name, _)| is_mine(name)).map(|(_, bytes)| bytes).collect()
}

fn written(extension: &str) -> Vec<Vec<u8>> {
    let image = Image::from_fn(9, 7, |x, y| Rgb::new(x as f32 / 9.0, y as f32 / 7.0, 0.3));
    let Ok(folder) = tempfile::tempdir() else { return Vec::new() };
    let path = folder.path().join(format!("a.{extension}"));
    let written = picture::write(&path, &image).is_ok();
    fs::read(&path).ok().filter(|_| written).into_iter().collect()
}

fn part() -> Vec<u8> {
    let Ok(folder) = tempfile::tempdir() else { return Vec::new() };
    let path = folder.path().join("a.exr");
    let channels = vec![("count".to_owned(), vec![3; 12]), ("sum_r_0".to_owned(), vec![9; 12])];
    let sums = planes::Planes { width: 4, height: 3, text: "{}".into(), channels };
    let _ = planes::write(&path, sums, &Image::from_fn(4, 3, |_, _| Rgb::ONE));
    fs::read(&path).unwrap_or_default()
}

/// An fSpy project: the word `fspy`, the version, the lengths of state and picture, and both.
fn measured() -> Vec<u8> {
    let table = MeasuredBrdf::from_fn([5, 3, 4], |wo, wi| Rgb::splat((wo.z * wi.z).abs()));
    table.map(|table| merl::to_bytes(&table)).unwrap_or_default()
}

fn fspy() -> Vec<u8> {
    let state = r#"{"cameraParameters": {"imageWidth": 4, "imageHeight": 3,
        "horizontalFieldOfView": 0.8, "principalPoint": {"x": 0, "y": 0}, "cameraTransform":
        {"rows": [[1,0,0,0],[0,1,0,0],[0,0,1,5],[0,0,0,1]]}}}"#;
    let number = |n: usize| (n as u32).to_le_bytes();
    let head = [*b"fspy", number(1), number(state.len()), number(0)].concat();
    [head, state.as_bytes().to_vec()].concat()
}

/// A file with one image, as COLMAP writes it: pose, camera, name, and a point.
fn colmap_images() -> Vec<u8> {
    let mut bytes = 1u64.to_le_bytes().to_vec();
    bytes.extend(1i32.to_le_bytes());
    [1.0f64, 0.0, 0.0, 0.0, 0.5, 0.0, 2.0].iter().for_each(|n| bytes.extend(n.to_le_bytes()));
    bytes.extend(1i32.to_le_bytes());
    bytes.extend(b"a.jpg\0");
    bytes.extend(1u64.to_le_bytes());
    bytes.extend([7; 24]);
    bytes
}
