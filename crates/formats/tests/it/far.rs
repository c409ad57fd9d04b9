//! Scenes far from zero: the same as near it except for their place, and written back there.

use crate::mitsuba_meshes::serialized;
use crate::support::{Folder, changed, glb, triangle_bytes, triangle_json};
use glam::{DVec3, Vec3};
use serde_json::json;
use std::collections::BTreeSet;
use std::path::Path;
use unrender_formats::export::{self, SceneView, Target};
use unrender_formats::{LightUnits, assign_materials, gltf, load_model, load_scene, place};
use unrender_scene::{Camera, Group, Light, LightKind, Material, Mesh, Object, Rgb, Scene};

/// One, twenty and 500 kilometres away, and at coordinates of land registers.
const PLACES: [[i64; 3]; 5] =
    [[0, 0, 0], [1_000, 0, 0], [-12_000, 300, 16_000], [0, 0, -500_000], [500_000, 150, 5_400_000]];

/// `units` of a tenth of a millimetre, `metres` farther, as a decimal.
fn decimal(units: i64, metres: i64) -> String {
    let all = 10_000 * metres + units;
    let sign = if all < 0 { "-" } else { "" };
    let text = format!("{sign}{}.{:04}", all.abs() / 10_000, all.abs() % 10_000);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A point in these units, moved.
fn point(units: [i64; 3], moved: [i64; 3]) -> String {
    [0, 1, 2].map(|axis| decimal(units[axis], moved[axis])).join(" ")
}

/// The corners of a floor, a wall and a lamp.
const CORNERS: [[[i64; 3]; 4]; 3] = [
    [[-20_001, 0, 15_003], [20_007, 0, 15_003], [20_007, 0, -14_999], [-20_001, 0, -14_999]],
    [
        [-20_001, 0, -14_999],
        [20_007, 0, -14_999],
        [20_007, 25_013, -14_999],
        [-20_001, 25_013, -14_999],
    ],
    [
        [-5_000, 24_000, -5_000],
        [5_000, 24_000, -5_000],
        [5_000, 24_000, 5_000],
        [-5_000, 24_000, 5_000],
    ],
];
const NAMES: [&str; 3] = ["floor", "wall", "lamp"];

/// Reads the scene that `write` makes there, and the same at zero, both relative to the same point
/// of the room.
fn both(moved: [i64; 3], write: &dyn Fn(&Folder, [i64; 3]) -> std::path::PathBuf) -> [Scene; 2] {
    let read = |path: &Path| load_scene(path).unwrap_or_else(|error| panic!("{error}")).0;
    let (there, here) = (Folder::new(), Folder::new());
    let far = read(&write(&there, moved));
    let at = DVec3::from_array(moved.map(|v| v as f64));
    let origin = far.origin;
    assert!((origin - at).length() < 5.0, "{origin} for {at}");
    assert_eq!(origin, origin.round());
    let rest = [0, 1, 2].map(|axis| moved[axis] - origin[axis] as i64);
    let near = read(&write(&here, rest));
    assert_eq!(near.origin, DVec3::ZERO);
    [far, near]
}

/// All positions in a scene.
fn places(scene: &Scene) -> Vec<Vec3> {
    let meshes = scene.objects.iter().flat_map(|o| o.mesh.positions.iter().copied());
    let lights = scene.lights.iter().filter_map(|light| light.kind.reach()).map(|r| r.position);
    meshes.chain(lights).chain(scene.cameras.iter().map(Camera::origin)).collect()
}

/// Asserts that the scenes are the same; up to rounding.
fn assert_alike(far: &Scene, near: &Scene, moved: [i64; 3]) {
    let (a, b) = (places(far), places(near));
    assert_eq!(a.len(), b.len());
    let off = a.iter().zip(&b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(off < 1e-6, "{off} at {moved:?}");
    let normals = |scene: &Scene| -> Vec<Vec3> {
        let meshes = scene.objects.iter().flat_map(|o| o.mesh.normals.iter().copied());
        let axes = scene.cameras.iter().map(|c| Vec3::from(c.world_from_camera.matrix3.z_axis));
        meshes.chain(axes).collect()
    };
    let pairs = normals(far).into_iter().zip(normals(near));
    assert!(pairs.into_iter().all(|(a, b)| a.distance(b) < 1e-6), "{moved:?}");
    assert_eq!(far.groups, near.groups);
}

fn obj(folder: &Folder, moved: [i64; 3]) -> std::path::PathBuf {
    folder.file(
        "a.mtl",
        "newmtl floor\nKd 0.5 0.5 0.5\nnewmtl wall\nKd 0.2 0.5 0.5\nnewmtl lamp\nKe 9 9 9\n",
    );
    let mut text = String::from("mtllib a.mtl\n");
    for (index, corners) in CORNERS.iter().enumerate() {
        corners.iter().for_each(|c| text.push_str(&format!("v {} 1 1 1\n", point(*c, moved))));
        text.push_str(&format!("o {0}\nusemtl {0}\nf -4 -3 -2 -1\n", NAMES[index]));
    }
    folder.file("a.obj", text)
}

fn radiance(folder: &Folder, moved: [i64; 3]) -> std::path::PathBuf {
    let at = |units| point(units, moved);
    let mut text = String::from(
        "void plastic floor 0 0 5 .5 .5 .5 0 0\nvoid plastic wall 0 0 5 .2 .5 .5 0 0\n\
         void light lamp 0 0 3 9 9 9\n",
    );
    for (name, corners) in NAMES.iter().zip(&CORNERS) {
        let corners = corners.map(at).join(" ");
        text.push_str(&format!("{name} polygon {name}.1 0 0 12 {corners}\n"));
    }
    let [low, high] = [[1_000, 2_000, 3_000], [1_000, 9_000, 3_003]].map(at);
    text.push_str(&format!(
        "wall sphere s 0 0 4 {low} 0.25\nwall cylinder c 0 0 7 {low} {high} 0.1\n"
    ));
    text.push_str(&format!("wall ring r 0 0 8 {high} 0 1 0 0.1 0.3\n"));
    text.push_str(&format!("wall cone k 0 0 8 {low} {high} 0.1 0.3\n"));
    let view = format!(
        "rvu -vtv -vp {} -vd 0.1 -0.1 -1 -vu 0 1 0 -vh 50 -vv 40\n",
        at([3, 12_001, 38_000])
    );
    folder.file("view.vf", view);
    folder.file("a.rad", text)
}

fn mitsuba(folder: &Folder, moved: [i64; 3]) -> std::path::PathBuf {
    let at = |units| point(units, moved);
    // One mesh far from its own zero, one far by its transform.
    let lines = |corners: &[[i64; 3]; 4], moved| {
        corners.map(|corner| format!("v {}\n", point(corner, moved))).concat() + "f 1 2 3 4\n"
    };
    folder.file("floor.obj", lines(&CORNERS[0], moved));
    folder.file("wall.obj", lines(&CORNERS[1], [0; 3]));
    let vertices = CORNERS[2].map(|corner| format!("{}\n", at(corner))).concat();
    folder.file("lamp.ply", format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n{vertices}4 0 1 2 3\n"
    ));
    let [x, y, z] = moved;
    let [eye, target] = [at([3, 12_001, 38_000]), at([3_003, 9_001, 8_000])];
    folder.file("a.xml", format!(
        r#"<scene version="3.0.0">
        <sensor type="perspective"><float name="fov" value="60"/>
        <transform name="to_world"><lookat origin="{eye}" target="{target}" up="0 1 0"/></transform></sensor>
        <bsdf type="diffuse" id="grey"/>
        <shape type="obj"><string name="filename" value="floor.obj"/><ref id="grey"/></shape>
        <shape type="obj"><string name="filename" value="wall.obj"/><ref id="grey"/>
          <transform name="to_world"><rotate y="1" angle="10"/><translate x="{x}" y="{y}" z="{z}"/></transform></shape>
        <shape type="ply"><string name="filename" value="lamp.ply"/><ref id="grey"/>
          <emitter type="area"><rgb name="radiance" value="9"/></emitter></shape>
        <shape type="rectangle"><ref id="grey"/><transform name="to_world">
          <matrix value="0.3 0 0 {x} 0 0.3 0 {y} 0 0 0.3 {z} 0 0 0 1"/></transform></shape>
        <shape type="sphere"><ref id="grey"/><point name="center" value="{}"/><float name="radius" value="0.2"/></shape>
        <shape type="cylinder"><ref id="grey"/><point name="p0" value="{}"/><point name="p1" value="{}"/>
          <float name="radius" value="0.2"/></shape>
        <emitter type="point"><point name="position" value="{eye}"/><rgb name="intensity" value="1"/></emitter>
        <emitter type="spot"><transform name="to_world"><lookat origin="{eye}" target="{target}" up="0 1 0"/>
          </transform><rgb name="intensity" value="1"/></emitter>
        </scene>"#,
        at([1, 2, 3]), at([1, 2, 3]), at([1, 9_002, 3]),
    ))
}

/// The room by commands that move it, with meshes near their own zero and far from it, and a light of our own.
fn commands(folder: &Folder, moved: [i64; 3]) -> std::path::PathBuf {
    let room = std::fs::read_to_string(radiance(folder, [0; 3])).unwrap();
    folder.file(
        "room.rad",
        room + "wall mesh m 5 near.rtm -t 1 0.5 0.25 0 0\n\
                # light {\"kind\":\"point\",\"position\":[0.1,1.7001,0.3],\"name\":\"l\",\"strength\":[4,4,4]}\n\
                void light l 0 0 3 1 1 1\nl sphere l.s 0 0 4 0.1 1.7001 0.3 .001\n",
    );
    let lines = |moved| {
        let corners = CORNERS[1].map(|corner| format!("v {}\n", point(corner, moved)));
        corners.concat() + "f 1 2 3 4\n"
    };
    folder.file("near.obj", lines([0; 3]));
    folder.file("there.obj", lines(moved));
    // The view is where the room goes to.
    let path = radiance(folder, moved);
    let [x, y, z] = moved;
    folder.file("half.rad", format!("!xform -t 0 {y} 0 room.rad\n"));
    std::fs::write(
        &path,
        format!("!xform -t {x} 0 0 -t 0 0 {z} half.rad\nwall mesh w 1 there.rtm 0 0\n"),
    )
    .unwrap();
    path
}

/// Shapes in groups, and a compressed mesh that is far along one axis in its file, along the others by its motion.
fn instances(folder: &Folder, moved: [i64; 3]) -> std::path::PathBuf {
    let [x, y, z] = moved;
    let lines = CORNERS[1].map(|corner| format!("v {}\n", point(corner, [0; 3]))).concat();
    folder.file("wall.obj", lines + "f 1 2 3 4\n");
    folder.file("m.serialized", serialized(4, &[z as f64 + 0.3001], true));
    let eye = point([3, 12_001, 38_000], moved);
    folder.file("a.xml", format!(
        r#"<scene version="3.0.0">
        <bsdf type="diffuse" id="grey"/>
        <shape type="shapegroup" id="group">
          <shape type="obj"><string name="filename" value="wall.obj"/><ref id="grey"/></shape>
          <shape type="sphere"><point name="center" value="0.1 0.2 0.3"/><float name="radius" value="0.2"/>
            <ref id="grey"/></shape></shape>
        <shape type="instance"><ref id="group"/><transform name="to_world"><rotate y="1" angle="20"/>
          <translate x="{x}" y="{y}" z="{z}"/></transform></shape>
        <shape type="serialized"><string name="filename" value="m.serialized"/><ref id="grey"/>
          <transform name="to_world"><translate x="{x}" y="{y}"/></transform></shape>
        <shape type="disk"><ref id="grey"/><transform name="to_world"><scale value="0.3"/>
          <translate x="{x}" y="{y}" z="{z}"/></transform></shape>
        <sensor type="perspective"><transform name="to_world">
          <translate value="{eye}"/></transform></sensor>
        <emitter type="point"><transform name="to_world"><translate value="{eye}"/></transform></emitter>
        </scene>"#
    ))
}

/// The room as glTF, each vertex near its node's zero and the nodes where they are.
fn nodes(folder: &Folder, moved: [i64; 3]) -> std::path::PathBuf {
    let mut json = triangle_json();
    let translation: Vec<f64> =
        [0, 1, 2].map(|axis| decimal(2_001, moved[axis]).parse().unwrap()).into();
    json["nodes"] = json!([
        { "name": "tri", "mesh": 0, "translation": translation, "scale": [2.0, 2.0, 2.0] },
        { "name": "arm", "translation": [moved[0], moved[1], moved[2]], "children": [2, 3] },
        { "camera": 0, "translation": [0.1, 0.2, 4.3] },
        { "translation": [0.5, 1.5, 0.5], "extensions": { "KHR_lights_punctual": { "light": 0 } } }
    ]);
    json["scenes"][0]["nodes"] = json!([0, 1]);
    json["cameras"] =
        json!([{ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } }]);
    json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    folder.file("a.glb", glb(&json, &triangle_bytes()))
}

#[test]
fn scenes_far_from_zero_are_read_as_near_it() {
    for moved in PLACES {
        for write in [&obj as &dyn Fn(&Folder, [i64; 3]) -> _, &radiance, &nodes] {
            let [far, near] = both(moved, write);
            assert_eq!(places(&far), places(&near), "{moved:?}");
            assert_alike(&far, &near, moved);
        }
        for write in [&mitsuba as &dyn Fn(&Folder, [i64; 3]) -> _, &commands, &instances] {
            let [far, near] = both(moved, write);
            assert_alike(&far, &near, moved);
        }
    }
}

/// A room about `origin`, as it is in memory.
fn room(origin: DVec3) -> Scene {
    let mut scene = Scene { origin, ..Scene::default() };
    for (index, corners) in CORNERS.iter().enumerate() {
        let corners = corners.map(|units| Vec3::from_array(units.map(|v| v as f32 / 10_000.0)));
        let mesh = Mesh::flat(&corners, &[], &[[0, 1, 2], [0, 2, 3]]);
        let emission = if index == 2 { Rgb::splat(9.0) } else { Rgb::ZERO };
        let material = Material::diffuse(Rgb::splat(0.5));
        scene.groups.push(Group { name: NAMES[index].into(), material, emission });
        scene.objects.push(Object { name: NAMES[index].into(), group: index, mesh });
    }
    let material = Material::isotropic(Rgb::splat(0.1), Rgb::splat(0.2), 0.2);
    scene.groups.push(Group { name: "ball".into(), material, emission: Rgb::ZERO });
    let mesh = Mesh::sphere(Vec3::new(0.3, 0.4, 0.1), 0.4);
    scene.objects.push(Object { name: "ball".into(), group: 3, mesh });
    let (position, direction) = (Vec3::new(0.1, 1.7, 0.3), Vec3::new(0.6, -0.8, 0.0));
    for kind in [
        LightKind::Point { position, intensity: Rgb::ONE },
        LightKind::Spot {
            position,
            direction,
            intensity: Rgb::ONE,
            inner_rad: 0.1,
            outer_rad: 0.7,
        },
    ] {
        scene.lights.push(Light { name: format!("light {}", scene.lights.len()), kind });
    }
    let eye = Vec3::new(0.1, 1.3, 3.6);
    scene.cameras.push(Camera::look_at("camera", eye, Vec3::new(0.0, 0.85, 0.0), Vec3::Y, 0.75));
    scene
}

/// The parts of the room whose coordinates have few digits.
fn room_without_ball(origin: DVec3) -> Scene {
    let mut scene = room(origin);
    scene.objects.pop();
    scene
}

/// Writes an export of `scene`, reads it back, and returns that with the text of the export.
fn exported(scene: &Scene, target: Target) -> (Scene, String, Vec<String>) {
    let folder = Folder::new();
    let materials = scene.materials();
    let (camera, light_units) = (&scene.cameras[0], LightUnits::Radiometric);
    let shot = SceneView { scene, materials: &materials, camera, size: (80, 60), light_units };
    let path = folder.path(&target.usual_name());
    let (files, warnings) = export::export(&shot, target, &path).unwrap();
    export::write(&path, target, &files).unwrap();
    let (path, text) = match target {
        Target::Gltf => (path, String::new()),
        Target::Mitsuba => {
            (path.join("scene.xml"), std::fs::read_to_string(path.join("scene.xml")).unwrap())
        }
        _ => (path.join("scene.rad"), std::fs::read_to_string(path.join("scene.rad")).unwrap()),
    };
    (load_scene(&path).unwrap().0, text, warnings.0)
}

#[test]
fn scenes_are_written_back_where_they_were() {
    for moved in PLACES {
        let origin = DVec3::from_array(moved.map(|v| v as f64));
        let (scene, ..) = exported(&room(origin), Target::Radiance);
        for target in [Target::Gltf, Target::Mitsuba, Target::Radiance] {
            let (back, text, warnings) = exported(&scene, target);
            // A reader may choose any origin, but not the places in the world.
            let shown = |scene: &Scene| -> BTreeSet<String> {
                places(scene).into_iter().map(|here| scene.shown(here)).collect()
            };
            assert_eq!(back.lights.len(), 2);
            let wanted = shown(&room_without_ball(origin));
            assert_eq!(wanted.len(), 12);
            assert!(wanted.is_subset(&shown(&back)), "{target} {moved:?}: {wanted:?}");
            // A second round trip moves nothing.
            let again = exported(&back, target).0;
            assert_eq!(shown(&again), shown(&back), "{target} {moved:?}");
            if target == Target::Radiance {
                let corner = point(CORNERS[0][0], moved);
                assert!(text.contains(&corner), "{corner} in {text}");
            }
            let told = warnings.iter().any(|w| w.contains("single precision"));
            assert_eq!(told, target == Target::Mitsuba && moved != [0; 3], "{warnings:?}");
        }
    }
}

#[test]
fn programs_of_single_precision_get_the_scene_at_zero_and_a_word() {
    let scene = room(DVec3::new(5e5, 0.0, 5.4e6));
    let materials = scene.materials();
    for target in [Target::Blender, Target::Pbrt] {
        let of = |scene: &Scene| {
            let (camera, light_units) = (&scene.cameras[0], LightUnits::Radiometric);
            let shot =
                SceneView { scene, materials: &materials, camera, size: (80, 60), light_units };
            export::export(&shot, target, "scene".as_ref()).unwrap()
        };
        let (files, warnings) = of(&scene);
        assert!(files == of(&room(DVec3::ZERO)).0, "{target}");
        let said = "about (500000, 0, 5400000) m";
        assert!(warnings.0.iter().any(|w| w.contains(said) && w.contains("0.5 m")), "{warnings:?}");
    }
}

#[test]
fn files_that_get_materials_or_a_camera_keep_their_places() {
    let folder = Folder::new();
    let path = nodes(&folder, [500_000, 150, 5_400_000]);
    let (scene, _) = load_scene(&path).unwrap();
    let (back, _) =
        load_scene(&folder.file("b.glb", assign_materials(&path, &scene, &[]).unwrap())).unwrap();
    assert_eq!((back.origin, places(&back)), (scene.origin, places(&scene)));
    let camera = Camera::look_at("new", Vec3::new(1.1, 2.2, 3.3), Vec3::ZERO, Vec3::Y, 0.5);
    for path in [path, radiance(&folder, [500_000, 150, 5_400_000])] {
        let (scene, _) = load_scene(&path).unwrap();
        let placed = place(&path, &camera, scene.origin).unwrap();
        let (back, _) = load_scene(&folder.file("c.glb", placed)).unwrap();
        let seen = back.cameras.iter().find(|c| c.name == "new").unwrap();
        assert_eq!(back.shown(seen.origin()), scene.shown(camera.origin()));
    }
}

#[test]
fn what_a_file_has_lost_in_single_precision_is_told() {
    let far = |steps: f32| {
        changed(|json, bin| {
            json["nodes"][0]["translation"] = json!([0.0, 0.0, 0.0]);
            for vertex in 0..3 {
                let at = 12 * vertex;
                let x = f32::from_le_bytes(bin[at..at + 4].try_into().unwrap());
                bin[at..at + 4].copy_from_slice(&(3.0 * x + steps).to_le_bytes());
            }
        })
    };
    let folder = Folder::new();
    let warnings = |distance| {
        let path = folder.file("a.glb", far(distance));
        let (scene, warnings) = load_scene(&path).unwrap();
        assert!((scene.origin.x - f64::from(distance)).abs() < 3.0);
        assert!(scene.objects[0].mesh.positions.iter().all(|p| p.length() < 6.0));
        warnings.0
    };
    let said = warnings(5_400_000.0);
    assert!(said.iter().any(|w| w.contains("steps of 0.5 m")), "{said:?}");
    assert_eq!(warnings(1_000.0), [""; 0]);
}

/// A triangle of three metres, `distance` away in a PLY of this type of numbers.
fn ply(kind: &str, distance: f64) -> Vec<u8> {
    let header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty {kind} x\nproperty {kind} y\n\
         property {kind} z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    );
    let mut bytes = header.into_bytes();
    for number in [0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 3.0, 0.0].map(|x: f64| x + distance) {
        match kind {
            "float" => bytes.extend((number as f32).to_le_bytes()),
            _ => bytes.extend(number.to_le_bytes()),
        }
    }
    bytes.push(3);
    bytes.extend([0i32, 1, 2].iter().flat_map(|corner| corner.to_le_bytes()));
    bytes
}

#[test]
fn what_a_mesh_has_lost_in_single_precision_is_told() {
    let folder = Folder::new();
    let warnings = |kind: &str, distance: f64, moved: f64, beside: &str| {
        folder.file("m.ply", ply(kind, distance));
        let text = format!(
            "<scene version=\"3.0.0\"><shape type=\"ply\"><string name=\"filename\" value=\"m.ply\"/>\
             <transform name=\"to_world\"><translate x=\"{moved}\" y=\"{moved}\" z=\"{moved}\"/></transform>\
             </shape>{beside}</scene>"
        );
        let (scene, warnings) = load_model(&folder.file("a.xml", text)).unwrap();
        assert_eq!(scene.objects[0].mesh.positions.len(), 3);
        warnings.0
    };
    // At coordinates of a land register, and the same moved to zero.
    for moved in [0.0, -5.4e6] {
        let said = warnings("float", 5.4e6, moved, "");
        assert!(
            said.iter().any(|w| w.contains("m.ply") && w.contains("steps of 0.5 ")),
            "{said:?}"
        );
        assert_eq!(warnings("double", 5.4e6, moved, ""), [""; 0]);
    }
    assert_eq!(warnings("float", 1000.0, 0.0, ""), [""; 0]);
    // Far away by its transform alone, and small in a large scene.
    assert_eq!(warnings("float", 0.0, 5.4e6, ""), [""; 0]);
    let hall = "<shape type=\"cube\"><transform name=\"to_world\"><scale value=\"9000\"/></transform></shape>";
    assert_eq!(warnings("float", 5000.0, 0.0, hall), [""; 0]);
}

#[test]
fn a_far_scene_has_the_vertices_of_a_near_one_in_its_glb() {
    // A far scene is written near zero, with the rest in the node's translation.
    let scene = room(DVec3::new(5e5, 0.0, 5.4e6));
    let bytes = gltf::to_glb(&scene).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    assert_eq!(json["nodes"][0]["translation"], json!([5e5, 0.0, 5.4e6]));
    let near = gltf::to_glb(&room(DVec3::ZERO)).unwrap();
    let length = u32::from_le_bytes(near[12..16].try_into().unwrap()) as usize;
    let json: serde_json::Value = serde_json::from_slice(&near[20..20 + length]).unwrap();
    assert!(json["nodes"][0].get("translation").is_none());
    assert!(near[20 + length..] == bytes[bytes.len() - (near.len() - 20 - length)..]);
}
