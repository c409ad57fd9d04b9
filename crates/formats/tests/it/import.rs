//! Scenes of Mitsuba and Radiance that others wrote: common plugins and primitives, and faults.

use crate::support::Folder;
use glam::Vec3;
use std::f32::consts::{PI, TAU};
use std::path::Path;
use unrender_formats::load_scene;
use unrender_scene::{BrdfModel, Layering, LightKind, Material, Reflectance, Rgb, Scene, Warnings};

fn loaded(path: &Path) -> (Scene, Warnings) {
    load_scene(path).unwrap_or_else(|error| panic!("{error}"))
}

fn problem(path: &Path) -> String {
    load_scene(path).unwrap_err().to_string()
}

const MITSUBA: &str = r#"<scene version="3.0.0">
    <default name="spp" value="16"/>
    <default name="bright" value="12"/>
    <integrator type="path"/>
    <sensor type="perspective">
        <float name="fov" value="60"/>
        <transform name="to_world"><lookat origin="0, 1, 4" target="0, 1, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="200"/><integer name="height" value="100"/></film>
        <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
    </sensor>
    <bsdf type="twosided" id="white"><bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.6, 0.5"/></bsdf></bsdf>
    <bsdf type="roughconductor" id="steel"><string name="material" value="none"/>
        <float name="alpha_u" value="0.1"/><float name="alpha_v" value="0.3"/></bsdf>
    <bsdf type="roughplastic" id="plastic"><rgb name="diffuse_reflectance" value="0.1 0.2 0.3"/><float name="int_ior" value="1.5"/></bsdf>
    <shape type="rectangle"><ref id="white"/>
        <transform name="to_world"><scale value="2"/><rotate x="1" angle="-90"/></transform></shape>
    <shape type="cube" id="box"><ref id="steel"/><transform name="to_world"><scale x="0.5" y="0.25" z="0.5"/><translate y="0.25"/></transform></shape>
    <shape type="sphere"><point name="center" x="1" y="0.5" z="0"/><float name="radius" value="0.5"/><ref id="plastic"/></shape>
    <shape type="cylinder" id="pillar"><ref id="white"/><point name="p1" x="0" y="2" z="0"/><float name="radius" value="0.5"/></shape>
    <shape type="disk" id="plate"><ref id="white"/></shape>
    <shape type="rectangle">
        <bsdf type="diffuse"><float name="reflectance" value="0"/></bsdf>
        <transform name="to_world"><rotate x="1" angle="90"/><translate y="2"/></transform>
        <emitter type="area"><rgb name="radiance" value="$bright"/></emitter>
    </shape>
    <emitter type="point"><point name="position" x="1" y="2" z="3"/><rgb name="intensity" value="4 5 6"/></emitter>
    <emitter type="constant"/>
</scene>"#;

#[test]
fn common_plugins_of_mitsuba_are_read() {
    let folder = Folder::new();
    let (scene, warnings) = loaded(&folder.file("scene.xml", MITSUBA));
    let group = |name: &str| &scene.groups[scene.group_index(name).unwrap()];
    assert_eq!(group("white").material.rho_d, Rgb::new(0.7, 0.6, 0.5));
    let steel = &group("steel").material;
    assert_eq!((steel.rho_s, steel.alpha_x, steel.alpha_y), (Rgb::ONE, 0.1, 0.3));
    let plastic = &group("plastic").material;
    assert!((plastic.rho_s.x - 0.04).abs() < 1e-3 && plastic.alpha_x == 0.1, "{plastic:?}");
    let lamp = scene.groups.iter().find(|group| group.is_emitter()).unwrap();
    assert_eq!(lamp.emission, Rgb::splat(12.0));
    // The floor looks upwards, the lamp downwards.
    let front = |object: usize| {
        let [a, b, c] = scene.objects[object].mesh.corners(0);
        (b - a).cross(c - a).normalize()
    };
    assert!((front(0) - Vec3::Y).length() < 1e-5);
    let of_lamp = scene.objects.iter().position(|o| scene.groups[o.group].is_emitter()).unwrap();
    assert!((front(of_lamp) - Vec3::NEG_Y).length() < 1e-5);
    let boxed = scene.objects.iter().find(|object| object.name == "box").unwrap();
    assert!(boxed.mesh.positions.iter().all(|p| p.x.abs() < 0.51 && (-0.01..0.51).contains(&p.y)));
    let camera = &scene.cameras[0];
    // By default the field of view is that of the width.
    let half = (0.5 * camera.fov_y_rad).tan();
    assert!((half - 0.5 * 30f32.to_radians().tan()).abs() < 1e-5);
    let (x, y) = camera.project(Vec3::new(1.0, 1.5, 0.0), 200, 100).unwrap();
    assert!(x > 100.0 && y < 50.0, "{x} {y}");
    let LightKind::Point { position, intensity } = scene.lights[0].kind else { panic!() };
    assert_eq!((position, intensity), (Vec3::new(1.0, 2.0, 3.0), Rgb::new(4.0, 5.0, 6.0)));
    assert_round(&scene, "pillar", TAU * 0.5 * 2.0, |p| {
        p.y.abs() < 1e-5 || (p.y - 2.0).abs() < 1e-5
    });
    assert_round(&scene, "plate", PI, |p| p.z.abs() < 1e-5);
    assert_eq!(scene.brdf, BrdfModel::Principled(Layering::Coupled));
    assert_eq!(scene.environment.as_ref().unwrap().mean(), Rgb::ONE);
    assert!(warnings.0.iter().any(|w| w.contains("microfacets")), "{warnings:?}");
}

#[test]
fn plastics_of_mitsuba_are_dielectrics_and_its_metals_metals() {
    let folder = Folder::new();
    let bsdf = |bsdf: &str| {
        let light = "<emitter type=\"area\"><rgb name=\"radiance\" value=\"1\"/></emitter>";
        let text = format!(
            "<scene version=\"3.0.0\"><shape type=\"sphere\">{bsdf}{light}</shape></scene>"
        );
        loaded(&folder.file("scene.xml", text)).0.groups[0].material.clone()
    };
    let indices = "<float name=\"int_ior\" value=\"1.5\"/><float name=\"ext_ior\" value=\"1\"/>";
    let color = "<rgb name=\"diffuse_reflectance\" value=\"0.5\"/>";
    let smooth = bsdf(&format!("<bsdf type=\"plastic\">{indices}{color}</bsdf>"));
    let wanted = Material::plastic(Rgb::splat(0.5), 1.5, Layering::Coupled, 0.0);
    assert_eq!(smooth.reflectance, wanted.reflectance);
    assert!((smooth.rho_d - wanted.rho_d).length() < 1e-5, "{smooth:?}");
    // What is reflected back inside darkens colours: d (1 - Fi)/(1 - d Fi).
    let nonlinear = "<boolean name=\"nonlinear\" value=\"true\"/>";
    let dark = bsdf(&format!("<bsdf type=\"plastic\">{indices}{color}{nonlinear}</bsdf>"));
    let expected = 0.5 * (1.0 - 0.5966) / (1.0 - 0.5 * 0.5966);
    assert!((dark.rho_d.x - expected).abs() < 1e-3, "{} {expected}", dark.rho_d);
    let rough = bsdf(&format!(
        "<bsdf type=\"roughplastic\">{indices}{color}<string name=\"distribution\" value=\"ggx\"/>\
         <float name=\"alpha\" value=\"0.2\"/></bsdf>"
    ));
    assert_eq!((rough.alpha_x, rough.alpha_y, rough.rho_s.x), (0.2, 0.2, wanted.rho_s.x));
    let gold = bsdf("<bsdf type=\"conductor\"><string name=\"material\" value=\"Au\"/></bsdf>");
    assert_eq!(gold.reflectance, Reflectance::Metal { multiscatter: false });
    let perfect =
        bsdf("<bsdf type=\"conductor\"><string name=\"material\" value=\"none\"/></bsdf>");
    assert_eq!(perfect, Material::mirror(Rgb::ONE));
}

/// Asserts that the object `name` has about this area, corners where they should be, and its front
/// where its normals point.
fn assert_round(scene: &Scene, name: &str, area: f32, is_right: impl Fn(&Vec3) -> bool) {
    let mesh = &scene.objects.iter().find(|object| object.name == name).unwrap().mesh;
    assert!(mesh.positions.iter().all(is_right), "{name}: {:?}", mesh.positions);
    let mut found = 0.0;
    for (index, corners) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(index);
        let across = (b - a).cross(c - a);
        let normal: Vec3 = corners.iter().map(|&i| mesh.normals[i as usize]).sum();
        assert!(across.dot(normal) > 0.99 * across.length() * normal.length(), "{name} {index}");
        found += 0.5 * across.length();
    }
    assert!((found / area - 1.0).abs() < 0.01, "{name}: {found} is not {area}");
}

#[test]
fn microfacets_are_those_of_ggx() {
    let folder = Folder::new();
    let rough = |id: &str, kind: &str| {
        format!(
            "<bsdf type=\"roughconductor\" id=\"{id}\"><string name=\"material\" value=\"none\"/>\
             <string name=\"distribution\" value=\"{kind}\"/></bsdf>\
             <shape type=\"sphere\"><ref id=\"{id}\"/>\
             <emitter type=\"area\"><rgb name=\"radiance\" value=\"1\"/></emitter></shape>"
        )
    };
    let scene = |kinds: [&str; 2]| {
        let (one, other) = (rough("one", kinds[0]), rough("other", kinds[1]));
        loaded(&folder.file("scene.xml", format!("<scene version=\"3.0.0\">{one}{other}</scene>")))
    };
    let (all, warnings) = scene(["ggx", "ggx"]);
    assert_eq!((all.brdf.is_principled(), warnings.0.len()), (true, 0), "{warnings:?}");
    let (mixed, warnings) = scene(["ggx", "beckmann"]);
    assert!(mixed.brdf.is_principled());
    let doubt = |w: &String| w.contains("other") && w.contains("Beckmann");
    assert!(warnings.0.iter().any(doubt), "{warnings:?}");
}

#[test]
fn faults_in_mitsuba_scenes_are_named() {
    let folder = Folder::new();
    let cases = [
        ("<scene version=\"3.0.0\"><shape type=\"rectangle\">", "is no XML"),
        ("<scene version=\"3.0.0\"/>", "no triangles"),
        (
            "<scene version=\"3.0.0\"><shape type=\"cube\"><ref id=\"x\"/></shape></scene>",
            "\"x\", which is not there",
        ),
        (
            "<scene version=\"3.0.0\"><shape type=\"ply\"><string name=\"filename\" value=\"no.ply\"/></shape></scene>",
            "no.ply",
        ),
        (
            "<scene version=\"3.0.0\"><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"red\"/></bsdf></scene>",
            "in reflectance, \"red\" is no",
        ),
        (
            "<scene version=\"3.0.0\"><shape type=\"cube\"><transform name=\"to_world\"><scale value=\"2\"/>\
             <matrix value=\"1 2\"/></transform></shape></scene>",
            "line 1: a matrix has 16 numbers",
        ),
    ];
    for (text, said) in cases {
        let told = problem(&folder.file("scene.xml", text));
        assert!(told.contains("scene.xml: ") && told.contains(said), "{told}");
    }
    folder
        .file("bad.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n");
    let text = "<scene version=\"3.0.0\"><shape type=\"ply\"><string name=\"filename\" value=\"bad.ply\"/></shape></scene>";
    assert!(problem(&folder.file("scene.xml", text)).contains("bad.ply"));
}

const RADIANCE: &str = "# a room
void plastic white 0 0 5 .7 .6 .5 0 0
void metal2 steel 4 1 0 0 . 0 6 .8 .7 .6 .9 .1 .3
void plastic shiny
0
0
5 .5 .5 .5 .04 .1
void glass pane 0 0 3 .9 .9 .9
void light lamp 0 0 3 12 12 12
white polygon floor 0 0 12  -2 0 2  2 0 2  2 0 -2  -2 0 -2
steel sphere ball 0 0 4 1 .5 0 .5
shiny polygon wall 0 0 9 0 0 0 1 0 0 0 1 0
pane polygon window 0 0 9 0 0 1 1 0 1 0 1 1
white cylinder pillar 0 0 7 0 0 0 0 1 0 .1
white cone hat 0 0 8 0 1 0 0 2 0 1 0
white ring plate 0 0 8 0 1 0 0 2 0 1 2
white bubble hollow 0 0 4 0 1 0 1
lamp polygon panel 0 0 12 -1 2 -1  1 2 -1  1 2 1  -1 2 1
void light sun 0 0 3 1e6 1e6 1e6
sun source disk 0 0 4 0 1 0 .5
";

#[test]
fn common_primitives_of_radiance_are_read() {
    let folder = Folder::new();
    folder.file("part.rad", RADIANCE);
    let main = folder.file("scene.rad", "!xform part.rad\n");
    folder.file("scene.vf", "rvu -vtv -vp 0 1 4 -vd 0 0 -1 -vu 0 1 0 -vh 60 -vv 30 -vs 0 -vl 0\n");
    let (scene, warnings) = loaded(&main);
    let group = |name: &str| &scene.groups[scene.group_index(name).unwrap()];
    assert_eq!(group("white").material.rho_d, Rgb::new(0.7, 0.6, 0.5));
    let steel = &group("steel").material;
    assert!((steel.rho_s - Rgb::new(0.72, 0.63, 0.54)).length() < 1e-6, "{steel:?}");
    assert!((steel.rho_d - Rgb::new(0.08, 0.07, 0.06)).length() < 1e-6, "{steel:?}");
    assert_eq!((steel.alpha_x, steel.alpha_y), (0.1, 0.3));
    let shiny = &group("shiny").material;
    assert_eq!((shiny.rho_s, shiny.alpha_x), (Rgb::splat(0.04), 0.1));
    assert_eq!(group("lamp").emission, Rgb::splat(12.0));
    let LightKind::Directional { direction, irradiance } = scene.lights[0].kind else { panic!() };
    let sin = 0.25f32.to_radians().sin();
    let expected = 1e6 * std::f32::consts::PI * sin * sin;
    assert_eq!(direction, Vec3::NEG_Y);
    assert!((irradiance.x / expected - 1.0).abs() < 1e-5, "{irradiance}");
    assert!((scene.cameras[0].fov_y_rad.to_degrees() - 30.0).abs() < 1e-4);
    assert_round(&scene, "pillar", TAU * 0.1, |p| (0.0..=1.0).contains(&p.y));
    assert_round(&scene, "hat", PI * 2f32.sqrt(), |p| (1.0..=2.0).contains(&p.y));
    assert_round(&scene, "plate", PI * 3.0, |p| (p.y - 1.0).abs() < 1e-5);
    assert_round(&scene, "hollow", 4.0 * PI, |p| (p.distance(Vec3::Y) - 1.0).abs() < 1e-5);
    assert_eq!(warnings.0.len(), 1, "{warnings:?}");
    assert!(warnings.0[0].starts_with("\"pane\" is glass"), "{warnings:?}");
    assert_eq!((scene.ungrouped.len(), scene.ungrouped[0].mesh.triangles.len()), (1, 1));
}

#[test]
fn faults_in_radiance_scenes_are_named() {
    let folder = Folder::new();
    let cases = [
        ("void plastic", "line 1: ends in the middle"),
        ("void plastic a 0 0 5 1 1", "how many arguments"),
        ("\nvoid plastic a 0 0 3 1 1 1", "line 2: the plastic \"a\" has 3 numbers instead of 5"),
        ("void plastic a 0 0 5 1 1 x 0 0", "no number"),
        ("a polygon p 0 0 9 0 0 0 1 0 0 0 1 0", "\"a\", which is not there"),
        ("void light a 0 0 3 1 1 1\na polygon p 0 0 6 0 0 0 1 0 0", "three corners"),
        ("!xform missing.rad", "includes \"missing.rad\", which cannot be read: it does not exist"),
        ("!xform scene.rad", "including itself"),
    ];
    for (text, said) in cases {
        let told = problem(&folder.file("scene.rad", text));
        assert!(told.contains("scene.rad: ") && told.contains(said), "{told}");
    }
}

/// The area of all triangles.
fn area(scene: &Scene) -> f32 {
    let mesh = &scene.objects[0].mesh;
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
        0.5 * (b - a).cross(c - a).length()
    };
    mesh.triangles.iter().map(area).sum()
}

/// An L of area 3, whose first corner is the one across from the notch.
const L: [[f32; 2]; 6] = [[2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.], [0., 0.]];

#[test]
fn polygons_that_are_not_convex_keep_their_shape() {
    let folder = Folder::new();
    let corners: String = L.map(|[x, y]| format!("{x} {y} 0 ")).concat();
    let rad = format!("void light l 0 0 3 1 1 1\nl polygon p 0 0 18 {corners}\n");
    let corners: String = L.map(|[x, y]| format!("v {x} {y} 0\n")).concat();
    let obj = format!("{corners}f 1 2 3 4 5 6\n");
    let corners: String = L.map(|[x, y]| format!("{x} {y} 0\n")).concat();
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n\
         property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
         {corners}6 0 1 2 3 4 5\n"
    );
    folder.file("l.ply", &ply);
    let shape = "<shape type=\"ply\"><string name=\"filename\" value=\"l.ply\"/></shape>";
    let xml = format!("<scene version=\"3.0.0\">{shape}</scene>");
    for (name, text) in [("l.rad", rad), ("l.obj", obj), ("l.xml", xml)] {
        let scene = unrender_formats::load_model(&folder.file(name, &text)).unwrap().0;
        assert!((area(&scene) - 3.0).abs() < 1e-5, "{name}: {} instead of 3", area(&scene));
    }
}

/// In Mitsuba v grows downwards from the top of a picture: PLY says it so, OBJ the other way round
/// (rendered with Mitsuba 3.9.1 to see: a red-over-blue picture on a PLY quad with v = 0 at the top).
#[test]
fn mitsuba_counts_v_from_the_top() {
    let folder = Folder::new();
    let vertices = "0 1 0 0 0\n1 1 0 1 0\n0 0 0 0 1\n";
    folder.file(
        "t.ply",
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
             property float z\nproperty float u\nproperty float v\nelement face 1\n\
             property list uchar int vertex_indices\nend_header\n{vertices}3 0 2 1\n"
        ),
    );
    folder.file("t.obj", "v 0 1 0\nv 1 1 0\nv 0 0 0\nvt 0 1\nvt 1 1\nvt 0 0\nf 1/1 3/3 2/2\n");
    let at_top = |kind: &str, more: &str| {
        let file = format!("<string name=\"filename\" value=\"t.{kind}\"/>");
        let shape = format!("<shape type=\"{kind}\">{file}{more}</shape>");
        let xml = format!("<scene version=\"3.0.0\">{shape}</scene>");
        let path = folder.file("scene.xml", &xml);
        let mesh = unrender_formats::load_model(&path).unwrap().0.objects[0].mesh.clone();
        let top = mesh.positions.iter().position(|p| p.y > 0.5).unwrap();
        mesh.uvs[top].y
    };
    let flip = |flip: bool| format!("<boolean name=\"flip_tex_coords\" value=\"{flip}\"/>");
    assert_eq!((at_top("ply", ""), at_top("ply", &flip(true))), (0.0, 1.0));
    assert_eq!((at_top("obj", ""), at_top("obj", &flip(false))), (0.0, 1.0));
}

#[test]
fn pictures_of_materials_lie_beside_the_material_file() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("mats")).unwrap();
    let tex = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hostile/tex a.png");
    std::fs::copy(&tex, folder.path("mats/wood.png")).unwrap();
    folder.file("mats/a.mtl", "newmtl wood\nmap_Kd wood.png\n");
    let text = "mtllib mats/a.mtl\nusemtl wood\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let (scene, _) = unrender_formats::load_model(&folder.file("a.obj", text)).unwrap();
    assert!(scene.groups[0].material.texture.is_some());
}
