//! Glass of Mitsuba and of OBJ with MTL; Radiance's is beside its other tests.

use crate::support::Folder;
use unrender_formats::load_model;
use unrender_scene::{Glass, Rgb, Scene, Warnings};

/// The model of a Mitsuba scene of `inside`.
fn mitsuba(inside: &str) -> Result<(Scene, Warnings), String> {
    let text = format!("<scene version=\"3.0.0\">{inside}</scene>");
    load_model(&Folder::new().file("scene.xml", text)).map_err(|error| error.to_string())
}

/// The glass of a shape of this kind and BSDF, and all warnings but that of glass.
fn shape(kind: &str, bsdf: &str) -> (Glass, Vec<String>) {
    let wall = "<shape type=\"cube\"><bsdf type=\"diffuse\"/></shape>";
    let shape = format!("{wall}<shape type=\"{kind}\">{bsdf}</shape>");
    let (scene, mut warnings) = mitsuba(&shape).unwrap();
    let glass = scene.ungrouped[0].glass.unwrap();
    assert!(glass.is_valid() && scene.groups.len() == 1, "{bsdf}");
    assert!(warnings.0.iter().any(|told| told.contains("is glass: ")), "{warnings:?}");
    warnings.0.retain(|told| !told.contains("is glass: "));
    (glass, warnings.0)
}

fn assert_near(found: f32, wanted: f32) {
    assert!((found - wanted).abs() < 1e-5, "{found} instead of {wanted}");
}

#[test]
fn dielectrics_of_mitsuba_have_their_own_index_and_colour() {
    let colour = "<rgb name=\"specular_transmittance\" value=\"0.9 0.8 0.5\"/>";
    let (glass, told) = shape(
        "sphere",
        &format!(
            "<bsdf type=\"dielectric\"><string name=\"int_ior\" value=\"water\"/>
             <float name=\"ext_ior\" value=\"1\"/>{colour}</bsdf>"
        ),
    );
    assert_near(glass.ior, 1.333);
    assert_eq!((glass.tint, glass.is_thin), (Rgb::new(0.9, 0.8, 0.5), false));
    assert_eq!((glass.absorption, told), (Rgb::ZERO, vec![]));
    // A bubble of air in water, and a denser glass than a plastic can have.
    let inside_out =
        "<string name=\"int_ior\" value=\"air\"/><string name=\"ext_ior\" value=\"water\"/>";
    let (glass, _) = shape("cube", &format!("<bsdf type=\"dielectric\">{inside_out}</bsdf>"));
    assert_near(glass.ior, 1.000_277 / 1.333);
    let (glass, _) =
        shape("cube", "<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"4\"/></bsdf>");
    assert_near(glass.ior, 4.0 / 1.000_277);
    let (glass, told) = shape("cube", &format!("<bsdf type=\"thindielectric\">{colour}</bsdf>"));
    assert_near(glass.ior, 1.5046 / 1.000_277);
    assert_eq!((glass.tint, glass.is_thin, told), (Rgb::new(0.9, 0.8, 0.5), true, vec![]));
    let grey = "<rgb name=\"specular_reflectance\" value=\"0.5\"/>";
    let (_, told) = shape("cube", &format!("<bsdf type=\"roughdielectric\">{grey}</bsdf>"));
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(
        told[0].contains("it is rough") && told[1].contains("specular reflectance"),
        "{told:?}"
    );
    assert!(mitsuba("<shape type=\"cube\"><bsdf type=\"dielectric\"><string name=\"int_ior\" value=\"x\"/></bsdf></shape>").is_err());
}

#[test]
fn open_shapes_of_glass_are_panes() {
    for (kind, is_thin) in [
        ("sphere", false),
        ("cube", false),
        ("rectangle", true),
        ("disk", true),
        ("cylinder", true),
    ] {
        let (glass, _) = shape(kind, "<bsdf type=\"dielectric\"/>");
        assert_eq!(glass.is_thin, is_thin, "{kind}");
    }
}

#[test]
fn principled_glass_of_mitsuba_has_its_base_colour() {
    let clear =
        "<rgb name=\"base_color\" value=\"0.81 0.64 0.25\"/><float name=\"roughness\" value=\"0\"/>
                 <float name=\"spec_trans\" value=\"1\"/><float name=\"eta\" value=\"1.4\"/>";
    let (glass, told) = shape("cube", &format!("<bsdf type=\"principled\">{clear}</bsdf>"));
    assert!((glass.tint - Rgb::new(0.9, 0.8, 0.5)).abs().max_element() < 1e-6, "{glass:?}");
    assert_eq!((glass.ior, glass.is_thin, told), (1.4, false, vec![]));
    let (glass, told) = shape("cube", &format!("<bsdf type=\"principledthin\">{clear}</bsdf>"));
    assert_eq!((glass.tint, glass.ior), (Rgb::new(0.81, 0.64, 0.25), 1.4));
    assert_eq!((glass.is_thin, told), (true, vec![]));
    // A sheet of paper is none.
    let paper =
        "<rgb name=\"base_color\" value=\"0.8\"/><float name=\"diff_trans\" value=\"0.5\"/>";
    let sheet =
        format!("<shape type=\"cube\"><bsdf type=\"principledthin\">{paper}</bsdf></shape>");
    let (scene, warnings) = mitsuba(&sheet).unwrap();
    assert_near(scene.groups[0].material.rho_d.x, 0.6);
    assert!(warnings.0.len() == 1 && warnings.0[0].contains("scatters through"), "{warnings:?}");
}

/// A triangle, a tetrahedron, and a wall.
const OBJ: &str = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl wall\nf 1 2 3\no pane\nusemtl glass\nf 1 2 3\n\
                   o body\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\nusemtl last\nf 1 2 3\n";

/// The glasses of [`OBJ`], whose material has `words`, with all warnings but that of glass.
fn obj(words: &str) -> (Scene, Vec<Glass>, Vec<String>) {
    let folder = Folder::new();
    let others = ["wall", "last"].map(|name| format!("newmtl {name}\nKd 0.5 0.5 0.5\n"));
    folder.file("a.mtl", format!("{}newmtl glass\nKd 0.1 0.1 0.1\n{words}\n", others.concat()));
    let (scene, mut warnings) = load_model(&folder.file("a.obj", OBJ)).unwrap();
    let glasses = scene.ungrouped.iter().map(|shape| shape.glass.unwrap()).collect();
    warnings.0.retain(|told| !told.contains("is glass: "));
    (scene, glasses, warnings.0)
}

#[test]
fn obj_has_glass_where_illum_and_transparency_say_so() {
    for (words, ior) in [
        ("illum 7\nd 0.1\nNi 1.7", 1.7),
        ("illum 4\nTr 0.9", 1.5),
        ("illum 6\nTf 1 1 1\nNi 1.000", 1.5),
        ("Tf 1 1 1\nd 0\nillum 9\nNi 2.4", 2.4),
    ] {
        let (scene, glasses, told) = obj(words);
        assert_eq!(told, [""; 0], "{words}");
        assert_eq!(scene.ungrouped_materials(), ["glass"], "{words}");
        assert_eq!(glasses, [Glass::pane(ior), Glass::solid(ior)], "{words}");
        let groups: Vec<&str> =
            scene.objects.iter().map(|o| scene.groups[o.group].name.as_str()).collect();
        assert_eq!(groups, ["wall", "last"]);
    }
    let (_, glasses, _) = obj("illum 7\nTf 0.81 0.64 0.25");
    assert_eq!(glasses[0].tint, Rgb::new(0.81, 0.64, 0.25));
    assert!((glasses[1].tint - Rgb::new(0.9, 0.8, 0.5)).abs().max_element() < 1e-6);
    // Neither of them alone, no lamps, and nothing that lets no light through.
    for (words, said) in [
        ("d 0.1\nillum 2", "transparency"),
        ("illum 7\nNi 1.5", "illum 4, 6, 7 and 9"),
        ("illum 7\nTf 0 0 0", "illum 4, 6, 7 and 9"),
        ("illum 7\nTf 1 1 1\nKe 1 1 1", "illum 4, 6, 7 and 9"),
    ] {
        let (scene, glasses, told) = obj(words);
        assert!(glasses.is_empty() && scene.groups.len() == 3, "{words}");
        assert!(told.len() == 1 && told[0].contains(said), "{words}: {told:?}");
    }
}
