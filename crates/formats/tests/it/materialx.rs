//! MaterialX: what our exporter writes is read back, and files of other programs by their shaders' definitions.

use crate::what_is_read::{assert_taken, rows};
use glam::{Vec2, Vec3};
use std::path::Path;
use std::sync::Arc;
use unrender_formats::export::{SceneView, Target, export};
use unrender_formats::what_is_read::Taken;
use unrender_formats::{FileError, LightUnits, material_file, picture};
use unrender_scene::{
    BrdfModel, Camera, Group, Image, Layering, Material, Mesh, Object, Reflectance, Rgb, Scene,
    Texture, WardModel, Warnings, Wrap,
};

const PRINCIPLED: BrdfModel = BrdfModel::Principled(Layering::AlbedoScaled);

/// A square for each of `materials`, in groups with these names.
fn scene(brdf: BrdfModel, materials: Vec<(&str, Material)>) -> Scene {
    let mut scene = Scene { brdf, ..Scene::default() };
    let corners = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
    let uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    for (group, (name, material)) in materials.into_iter().enumerate() {
        let mesh = Mesh::flat(&corners, &uvs, &[[0, 1, 2], [0, 2, 3]]);
        scene.objects.push(Object { name: format!("object {name}"), group, mesh });
        scene.groups.push(Group { name: name.into(), material, emission: Rgb::ZERO });
    }
    scene
}

fn exported(scene: &Scene, folder: &Path) {
    let camera = Camera::look_at("c", Vec3::Z, Vec3::ZERO, Vec3::Y, 0.6);
    let (size, light_units) = ((8, 8), LightUnits::default());
    let view =
        SceneView { scene, materials: &scene.materials(), camera: &camera, size, light_units };
    for (name, bytes) in export(&view, Target::Materialx, Path::new("export")).unwrap().0 {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
}

/// The scene of one group "a" after the file with these elements.
fn with(elements: &str) -> Result<(Scene, Warnings), FileError> {
    in_model(PRINCIPLED, elements)
}

fn in_model(model: BrdfModel, elements: &str) -> Result<(Scene, Warnings), FileError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mtlx");
    let codes = Image::from_fn(2, 1, |x, _| Rgb::new(x as f32, 0.5, 0.25));
    picture::write_png_codes(&folder.path().join("a.png"), &codes, unrender_scene::Depth::Eight)
        .unwrap();
    let text = format!(
        "<?xml version=\"1.0\"?><materialx version=\"1.39\" colorspace=\"lin_rec709\">{elements}</materialx>"
    );
    std::fs::write(&path, text).unwrap();
    let mut scene = scene(model, vec![("a", Material::diffuse(Rgb::splat(0.9)))]);
    let warnings = material_file::apply(&path, &mut scene)?;
    Ok((scene, warnings))
}

/// A material "a" of the shader `tag` with these inputs.
fn shader(tag: &str, inputs: &[(&str, &str)]) -> String {
    let inputs: String = inputs
        .iter()
        .map(|(name, value)| {
            format!(
                "<input name=\"{name}\" type=\"float\" {}/>",
                if value.contains('=') {
                    (*value).to_owned()
                } else {
                    format!("value=\"{value}\"")
                }
            )
        })
        .collect();
    format!(
        "<{tag} name=\"s\" type=\"surfaceshader\">{inputs}</{tag}><surfacematerial name=\"a\" type=\"material\">\
         <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"s\"/></surfacematerial>"
    )
}

fn material(tag: &str, inputs: &[(&str, &str)]) -> Material {
    let (scene, warnings) = with(&shader(tag, inputs)).unwrap();
    assert!(warnings.0.is_empty(), "{warnings:?}");
    scene.groups[0].material.clone()
}

#[track_caller]
fn is_near(found: Rgb, wanted: Rgb) {
    assert!((found - wanted).abs().max_element() < 1e-5, "{found} {wanted}");
}

#[test]
fn what_is_exported_comes_back_exactly() {
    let image = Image::from_fn(3, 2, |x, y| Rgb::new(0.1 * x as f32, 0.2 * y as f32, 0.4));
    let texture = Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::ClampToEdge };
    let brushed = Material {
        alpha_y: 0.3,
        theta_rad: 0.4,
        ..Material::isotropic(Rgb::splat(0.2), Rgb::new(0.3, 0.2, 0.1), 0.1)
    };
    let mean = Rgb::new(0.1, 0.1, 0.4);
    let plastic = Material::plastic(mean, 1.46, Layering::Coupled, 0.04);
    let textured = Material { texture: Some(Arc::new(texture)), ..plastic.clone() };
    for (model, materials) in [
        (
            PRINCIPLED,
            vec![
                ("wall -- left", plastic),
                ("große \"Tür\"", Material::metal(Rgb::new(0.9, 0.7, 0.3), false, 0.2)),
                ("rug", textured),
                ("tray", brushed.clone()),
            ],
        ),
        (
            BrdfModel::Ward(WardModel::Ward1992),
            vec![("mirror", Material::mirror(Rgb::splat(0.8))), ("tray", brushed)],
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let original = scene(model, materials);
        exported(&original, folder.path());
        let mut back = original.clone();
        back.groups.iter_mut().for_each(|group| group.material = Material::diffuse(Rgb::ONE));
        let warnings =
            material_file::apply(&folder.path().join("materials.mtlx"), &mut back).unwrap();
        assert!(warnings.0.is_empty(), "{warnings:?}");
        assert_eq!(back.brdf.name(), original.brdf.name());
        for (a, b) in original.groups.iter().zip(&back.groups) {
            let off = (a.material.theta_rad - b.material.theta_rad).abs();
            assert!(off < 1e-6, "{off}");
            let theta_rad = a.material.theta_rad;
            assert_eq!(a.material, Material { theta_rad, ..b.material.clone() }, "{}", a.name);
        }
    }
}

#[test]
fn without_our_comments_the_numbers_of_the_shader_remain() {
    let folder = tempfile::tempdir().unwrap();
    let brushed = Material {
        alpha_y: 0.3,
        theta_rad: 0.4,
        ..Material::plastic(Rgb::splat(0.2), 1.7, Layering::AlbedoScaled, 0.1)
    };
    let metal = Material::metal(Rgb::new(0.9, 0.7, 0.3), true, 0.2);
    let original = scene(PRINCIPLED, vec![("tray", brushed), ("spoon", metal)]);
    exported(&original, folder.path());
    let path = folder.path().join("materials.mtlx");
    let text = std::fs::read_to_string(&path).unwrap();
    let plain: Vec<&str> = text.lines().filter(|line| !line.contains("<!--")).collect();
    std::fs::write(&path, plain.join("\n")).unwrap();
    let mut back = original.clone();
    back.groups.iter_mut().for_each(|group| group.material = Material::diffuse(Rgb::ONE));
    material_file::apply(&path, &mut back).unwrap();
    for (a, b) in original.groups.iter().zip(&back.groups) {
        is_near(b.material.rho_d, a.material.rho_d);
        is_near(b.material.rho_s, a.material.rho_s);
        let [x, y] =
            [(a.material.alpha_x, b.material.alpha_x), (a.material.alpha_y, b.material.alpha_y)];
        assert!((x.0 - x.1).abs() < 1e-5 && (y.0 - y.1).abs() < 1e-5, "{:?}", b.material);
        assert!((a.material.theta_rad - b.material.theta_rad).abs() < 1e-5);
        assert_eq!(a.material.reflectance.name(), b.material.reflectance.name());
    }
}

#[test]
fn defaults_are_those_of_the_shaders_definitions() {
    for (tag, rho_d, alpha) in [("standard_surface", 0.8, 0.04), ("open_pbr_surface", 0.8, 0.09)] {
        let found = material(tag, &[]);
        is_near(found.rho_d, Rgb::splat(rho_d));
        assert!((found.alpha_x - alpha).abs() < 1e-6 && found.alpha_x == found.alpha_y);
        assert_eq!(
            found.reflectance,
            Reflectance::Dielectric { ior: 1.5, layering: Layering::AlbedoScaled }
        );
    }
    let found = material("gltf_pbr", &[]);
    assert_eq!(
        (found.rho_s, found.reflectance),
        (Rgb::ONE, Reflectance::Metal { multiscatter: true })
    );
}

#[test]
fn weights_colours_and_anisotropy_are_those_of_each_shader() {
    let found = material(
        "open_pbr_surface",
        &[
            ("base_weight", "0.5"),
            ("base_color", "0.2, 0.4, 0.6"),
            ("specular_weight", "0.5"),
            ("specular_ior", "2"),
            ("specular_roughness", "0.5"),
            ("specular_roughness_anisotropy", "0.5"),
        ],
    );
    is_near(found.rho_d, Rgb::new(0.1, 0.2, 0.3));
    is_near(found.rho_s, Rgb::splat(0.5 / 9.0));
    let along = 0.25 * (2.0_f32 / 1.25).sqrt();
    assert!(
        (found.alpha_y - along).abs() < 1e-6 && (found.alpha_x - 0.5 * along).abs() < 1e-6,
        "{found:?}"
    );
    // The lesser roughness lies across the tangent.
    assert!((found.theta_rad - std::f32::consts::FRAC_PI_2).abs() < 1e-6);

    let found = material(
        "gltf_pbr",
        &[
            ("roughness", "0.5"),
            ("base_color", "0.5"),
            ("anisotropy_strength", "0.6"),
            ("anisotropy_rotation", "0.3"),
        ],
    );
    assert!(
        (found.alpha_x - 0.25).abs() < 1e-6 && (found.alpha_y - (0.25 + 0.75 * 0.36)).abs() < 1e-6
    );
    assert!((found.theta_rad - 0.3 - std::f32::consts::FRAC_PI_2).abs() < 1e-6);

    // In a scene of free lobes the reflectance is that at normal incidence.
    let elements = shader("standard_surface", &[("base_color", "0.5"), ("specular_IOR", "1.5")]);
    let (scene, _) = in_model(BrdfModel::Ggx, &elements).unwrap();
    let free = &scene.groups[0].material;
    assert!(free.reflectance.is_free());
    is_near(free.rho_s, Rgb::splat(0.04));
}

const GRAPH: &str = "<nodegraph name=\"g\"><input name=\"tint\" type=\"color3\" value=\"0.5, 1, 1\"/>\
    <image name=\"i\" type=\"color3\"><input name=\"file\" type=\"filename\" value=\"a.png\" colorspace=\"srgb_texture\"/>\
    <input name=\"uaddressmode\" type=\"string\" value=\"mirror\"/></image>\
    <image name=\"n\" type=\"vector3\"><input name=\"file\" type=\"filename\" value=\"a.png\"/></image>\
    <multiply name=\"m\" type=\"color3\"><input name=\"in1\" type=\"color3\" nodename=\"i\"/>\
    <input name=\"in2\" type=\"color3\" interfacename=\"tint\"/></multiply>\
    <separate3 name=\"s\" type=\"multioutput\"><input name=\"in\" type=\"vector3\" nodename=\"n\"/></separate3>\
    <normalmap name=\"b\" type=\"vector3\"><input name=\"in\" type=\"vector3\" nodename=\"n\"/></normalmap>\
    <noise3d name=\"x\" type=\"float\"/>\
    <output name=\"c\" type=\"color3\" nodename=\"m\"/><output name=\"r\" type=\"float\" nodename=\"s\" output=\"outy\"/>\
    <output name=\"bumps\" type=\"vector3\" nodename=\"b\"/><output name=\"other\" type=\"float\" nodename=\"x\"/></nodegraph>";

#[test]
fn graphs_are_followed_to_their_pictures() {
    let elements = shader(
        "standard_surface",
        &[
            ("base_color", "nodegraph=\"g\" output=\"c\""),
            ("specular_roughness", "nodegraph=\"g\" output=\"r\""),
            ("normal", "nodegraph=\"g\" output=\"bumps\""),
        ],
    );
    let (scene, warnings) = with(&format!("{GRAPH}{elements}")).unwrap();
    let found = &scene.groups[0].material;
    let texture = found.texture.as_ref().unwrap();
    let linear =
        |code: f32| if code > 0.04045 { ((code + 0.055) / 1.055).powf(2.4) } else { code / 12.92 };
    let texel = *texture.image.at(1, 0);
    assert!(
        (texel - Rgb::new(0.5, linear(128.0 / 255.0), linear(64.0 / 255.0))).abs().max_element()
            < 1e-4,
        "{texel}"
    );
    assert_eq!((texture.wrap_u, texture.wrap_v), (Wrap::MirroredRepeat, Wrap::Repeat));
    // The green of numbers, not decoded: 128/255.
    assert!((found.alpha_x - (128.0_f32 / 255.0).powi(2)).abs() < 1e-4);
    assert!(
        warnings.0.len() == 1 && warnings.0[0].contains("its specular_roughness is a picture"),
        "{warnings:?}"
    );
    let mesh = &scene.objects[0].mesh;
    assert!(mesh.detail.normals.is_some() && !mesh.tangents.is_empty());
}

#[test]
fn what_is_not_read_is_told_with_what_was_taken() {
    let elements = shader(
        "standard_surface",
        &[
            ("specular_roughness", "nodegraph=\"g\" output=\"other\""),
            ("metalness", "nodename=\"nowhere\""),
            ("transmission", "0.5"),
            ("sheen", "0"),
            ("opacity", "1, 1, 1"),
            ("shininess", "3"),
            ("base", "abc"),
        ],
    );
    let (scene, warnings) = with(&format!("{GRAPH}{elements}")).unwrap();
    assert!((scene.groups[0].material.alpha_x - 0.04).abs() < 1e-6);
    let said = warnings.0.join("\n");
    for part in [
        "material \"a\": its specular_roughness comes from <noise3d> \"x\", which is not read; 0.2 was taken",
        "its metalness is connected to nothing; 0 was taken",
        "transmission: left out",
        "has no input shininess",
        "its base is \"abc\"; 1 was taken",
        "a.mtlx: ",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert_eq!(warnings.0.len(), 5, "{said}");
}

#[test]
fn looks_and_plain_names_find_their_groups() {
    let other = shader("gltf_pbr", &[]).replace("name=\"a\"", "name=\"gold\"");
    let look = |geom: &str| {
        format!(
            "{other}<look name=\"l\"><materialassign name=\"m\" material=\"gold\" geom=\"{geom}\"/></look>"
        )
    };
    for geom in ["/room/a", "/x, /object a"] {
        let (scene, _) = with(&look(geom)).unwrap();
        assert_eq!(scene.groups[0].material.reflectance.name(), "metal", "{geom}");
    }
    let problem = with(&look("/room/b")).unwrap_err().to_string();
    assert!(problem.contains("its materials are \"gold\", the groups \"a\""), "{problem}");
}

#[test]
fn circles_includes_and_foreign_files_end_in_words() {
    let circle = "<nodegraph name=\"g\"><convert name=\"x\" type=\"float\"><input name=\"in\" type=\"float\" nodename=\"x\"/>\
        </convert><output name=\"o\" type=\"float\" nodename=\"x\"/></nodegraph>";
    let elements = format!(
        "{circle}{}",
        shader("standard_surface", &[("base", "nodegraph=\"g\" output=\"o\"")])
    );
    assert!(with(&elements).unwrap().1.0[0].contains("is connected to nothing"));
    for (elements, problem) in [
        (
            "<xi:include xmlns:xi=\"http://www.w3.org/2001/XInclude\" href=\"b.mtlx\"/>",
            "XInclude is not read",
        ),
        ("<surfacematerial", "is no XML"),
        ("", "its materials are none"),
        (&format!("{}{}", "<a>".repeat(100), "</a>".repeat(100)), "64 deep"),
        (&shader("disney_principled", &[]), "has the shader <disney_principled>"),
    ] {
        let said = with(elements).unwrap_err().to_string();
        assert!(said.contains(problem), "{problem}: {said}");
    }
}

#[test]
fn every_input_is_taken_as_its_row_says() {
    for tag in ["standard_surface", "open_pbr_surface", "gltf_pbr"] {
        for row in rows(&format!("MaterialX: {tag}")) {
            // A coat without a base to be the lobe of, and a normal that is no map, have tests of their own.
            let is_apart = row.taken == Taken::Approximated || row.element.ends_with("normal");
            if is_apart && row.taken != Taken::PassedOver {
                continue;
            }
            let value = if row.taken == Taken::WarnedOf { "0.5" } else { "1" };
            let read = with(&shader(tag, &[(row.element, value)]));
            let read = read.map(|(_, warnings)| warnings).map_err(|error| error.to_string());
            assert_taken(&row, row.element, read);
        }
    }
}

#[test]
fn a_coat_is_the_lobe_of_a_base_without_one() {
    let coat = [("specular", "0"), ("coat", "1"), ("coat_roughness", "0.5"), ("coat_IOR", "1.7")];
    let found = material("standard_surface", &coat);
    is_near(found.rho_s, Rgb::splat((0.7_f32 / 2.7).powi(2)));
    assert!((found.alpha_x - 0.25).abs() < 1e-6);
    let (_, warnings) = with(&shader("standard_surface", &coat[1..])).unwrap();
    assert!(warnings.0[0].contains("its coat was left out"), "{warnings:?}");
}
