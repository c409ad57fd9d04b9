//! Materials, mixtures, patterns, and the direction of highlights.

use super::*;
use unrender_scene::Rgb;

/// The material of a sphere of `m`, defined by `text`, and the warnings.
fn material(text: &str) -> (unrender_scene::Material, Warnings) {
    let (scene, warnings) = read(&format!("{text}\nm sphere s 0 0 4 1 0 1 1"));
    (group(&scene, "s").material.clone(), warnings)
}

#[test]
fn mixtures_of_constant_shares_are_exact() {
    let gloss = "void plastic gloss 0 0 5 .5 .5 .5 .1 .2\n";
    for (text, rho_d, rho_s, alpha) in [
        ("void mixfunc m 4 red white .5 . 0 0", [0.7, 0.4, 0.4], [0.0; 3], 0.0),
        ("void mixfunc m 4 red white .25 . 0 0", [0.7, 0.55, 0.55], [0.0; 3], 0.0),
        ("void mixfunc m 4 red white A1 . 0 1 1", [0.7, 0.1, 0.1], [0.0; 3], 0.0),
        ("void mixfunc m 4 red void 1 . 0 0", [0.7, 0.1, 0.1], [0.0; 3], 0.0),
        ("void mixfunc m 4 gloss white .5 . 0 0", [0.575, 0.575, 0.575], [0.05; 3], 0.2),
        (
            "void mixfunc n 4 red white .5 . 0 0\nvoid mixfunc m 4 n white .5 . 0 0",
            [0.7, 0.55, 0.55],
            [0.0; 3],
            0.0,
        ),
    ] {
        let (found, warnings) = material(&format!("{gloss}{text}"));
        assert!(warnings.0.is_empty(), "{text}: {warnings:?}");
        assert_near(found.rho_d, rho_d, text);
        assert_near(found.rho_s, rho_s, text);
        assert_eq!((found.alpha_x, found.alpha_y), (alpha, alpha), "{text}");
    }
}

#[test]
fn other_mixtures_are_approximated_and_told() {
    let gloss = "void plastic a 0 0 5 .5 .5 .5 .1 .2\nvoid plastic b 0 0 5 .5 .5 .5 .3 .1\n";
    for (text, said, red) in [
        ("void mixfunc m 4 red white stripes stripes.cal 0 0", "half of each was taken", 0.7),
        ("void mixdata m 6 red white noop some.dat . Px 0 0", "half of each was taken", 0.7),
        (
            "void mixpict m 7 red white grey mask.hdr picture.cal pic_u pic_v 0 0",
            "half of each",
            0.7,
        ),
        (
            "void mixtext m 4 red white helvet.fnt words.txt 0 9 0 0 0 1 0 0 0 -1 0",
            "half of each",
            0.7,
        ),
        ("void mixfunc m 4 a b .5 . 0 0", "one material of the mean reflectance", 0.4),
        (
            "void mixfunc m 4 red void .5 . 0 0",
            "line 7: the mixfunc \"m\" is transparent in part",
            0.7,
        ),
    ] {
        let (found, warnings) = material(&format!("{gloss}{text}"));
        assert_told(&warnings, said);
        assert_near(Vec3::splat(found.rho_d.x), [red; 3], text);
    }
    for (text, said) in [
        (
            "void mixfunc m 4 red nobody .5 . 0 0",
            "the mixfunc \"m\" names \"nobody\", which is not there",
        ),
        ("void mixfunc m 4 red lamp .5 . 0 0", "the mixfunc \"m\" has a lamp in it"),
    ] {
        let told = refusal(&format!("{text}\nm sphere s 0 0 4 1 0 1 1"));
        assert!(told.contains(said), "{told}");
    }
}

#[test]
fn constant_patterns_change_the_colour_and_others_are_told() {
    let pattern = |text: &str| material(&format!("{text}\np plastic m 0 0 5 .8 .4 .2 0 0"));
    for (text, rho_d) in [
        ("void colorfunc p 4 .5 1 A1 . 0 1 .25", [0.4, 0.4, 0.05]),
        ("void brightfunc p 2 .5 . 0 0", [0.4, 0.2, 0.1]),
        ("void brightfunc q 2 .5 . 0 0\nq brightfunc p 2 .5 . 0 0", [0.2, 0.1, 0.05]),
    ] {
        let (found, warnings) = pattern(text);
        assert!(warnings.0.is_empty(), "{text}: {warnings:?}");
        assert_near(found.rho_d, rho_d, text);
    }
    for (text, said) in [
        ("void brightfunc p 2 dirt dirt.cal 0 1 .5", "line 5: the brightfunc \"p\" is not read"),
        ("void colordata p 9 r g b a b c . u v 0 0", "line 5: the colordata \"p\" is not read"),
        (
            "void brighttext p 2 helvet.fnt words 0 11 0 0 0 1 0 0 0 -1 0 1 0",
            "the brighttext \"p\" is not read",
        ),
        ("void mixfunc p 4 void void stripes . 0 0", "the mixfunc \"p\" is not read"),
        (
            "void texfunc p 4 nx ny nz wood.cal 0 0",
            "the texfunc \"p\" is not read; its surfaces are smooth",
        ),
        ("void texdata p 9 a b c d e f . u v 0 0", "the texdata \"p\" is not read"),
    ] {
        let (found, warnings) = pattern(text);
        assert_told(&warnings, said);
        assert_near(found.rho_d, [0.8, 0.4, 0.2], text);
    }
    // Between the surface and its material a pattern counts as well.
    let (found, _) = material("red colorfunc m 4 .5 .5 .5 . 0 0");
    assert_near(found.rho_d, [0.35, 0.05, 0.05], "pattern over a material");
}

#[test]
fn pictures_are_laid_over_texture_coordinates_or_their_mean_is_taken() {
    let folder = Folder::new();
    let image =
        unrender_scene::Image::from_fn(4, 4, |x, _| Rgb::splat(if x < 2 { 0.25 } else { 0.75 }));
    unrender_formats::picture::write(&folder.path("p.hdr"), &image).unwrap();
    for (place, is_laid) in
        [("picture.cal pic_u pic_v", false), (". Lu Lv", true), (". frac(Lu) frac(Lv)", true)]
    {
        let text = format!(
            "{BASE}void colorpict p 7 red green blue p.hdr {place} 0 0\np plastic m 0 0 5 .8 .8 .8 0 0\n\
             m sphere s 0 0 4 0 0 0 1\n"
        );
        let (scene, warnings) = load_scene(&folder.file("scene.rad", text)).unwrap();
        let found = &group(&scene, "s").material;
        assert!((found.rho_d.x / 0.4 - 1.0).abs() < 0.01, "{place}: {}", found.rho_d);
        assert_eq!(found.texture.is_some(), is_laid, "{place}");
        assert_eq!(warnings.0.is_empty(), is_laid, "{place}: {warnings:?}");
        if let Some(texture) = &found.texture {
            assert!((texture.image.at(0, 0).x / 0.2 - 1.0).abs() < 0.01);
        }
    }
}

/// A picture of one grey as `p.hdr`, with a further line in its header, on a ball; its reflectance and the warnings.
fn with_picture(line: &str) -> (f32, Warnings) {
    let folder = Folder::new();
    let image = unrender_scene::Image::from_fn(4, 4, |_, _| Rgb::splat(0.25));
    unrender_formats::picture::write(&folder.path("p.hdr"), &image).unwrap();
    let bytes = std::fs::read(folder.path("p.hdr")).unwrap();
    let end = bytes.windows(2).position(|pair| pair == b"\n\n").unwrap();
    folder.file("p.hdr", [&bytes[..end], line.as_bytes(), &bytes[end..]].concat());
    let text = format!(
        "{BASE}void colorpict p 7 red green blue p.hdr . Lu Lv 0 0\np plastic m 0 0 5 .8 .8 .8 0 0\n\
         m sphere s 0 0 4 0 0 0 1\nm sphere t 0 0 4 3 0 0 1\n"
    );
    let (scene, warnings) = load_scene(&folder.file("scene.rad", text)).unwrap();
    (group(&scene, "s").material.rho_d.x, warnings)
}

#[test]
fn what_is_told_of_a_picture_is_told_of_the_scene() {
    let warnings = with_picture("\nPIXASPECT=2").1;
    assert!(warnings.0.len() == 1 && warnings.0[0].contains("PIXASPECT"), "{warnings:?}");
}

#[test]
fn pictures_are_laid_by_their_numbers_whatever_their_exposure() {
    for line in ["", "\nEXPOSURE=2.5", "\nCOLORCORR=.5 .5 .5"] {
        let (found, warnings) = with_picture(line);
        assert!((found / 0.2 - 1.0).abs() < 0.01, "{line}: {found}");
        assert!(warnings.0.is_empty(), "{line}: {warnings:?}");
    }
}

#[test]
fn the_outermost_texels_of_a_picture_are_at_its_edges() {
    let folder = Folder::new();
    let image = unrender_scene::Image::from_fn(3, 3, |x, _| Rgb::splat([0.125, 0.5, 0.875][x]));
    unrender_formats::picture::write(&folder.path("p.hdr"), &image).unwrap();
    let text = format!(
        "{BASE}void colorpict p 7 red green blue p.hdr . Lu Lv 0 0\np plastic m 0 0 5 1 1 1 0 0\n\
         m sphere s 0 0 4 0 0 0 1\n"
    );
    let (scene, _) = load_scene(&folder.file("scene.rad", text)).unwrap();
    let texture = group(&scene, "s").material.texture.clone().unwrap();
    // Linear from the first over the second to the third.
    for u in [0.1f32, 0.25, 0.5, 0.8] {
        let at = (u * texture.image.width() as f32) as usize;
        let (found, wanted) = (texture.image.at(at, 0).x, 0.125 + 0.75 * u);
        assert!((found - wanted).abs() < 0.02, "{u}: {found} for {wanted}");
    }
}

#[test]
fn highlights_keep_their_direction() {
    for (motion, expected) in
        [("", [0.0, 0.0, 1.0]), ("-rx 90", [0.0, -1.0, 0.0]), ("-s 2", [0.0, 0.0, 1.0])]
    {
        let part = "void metal2 brushed 4 0 0 1 . 0 6 .8 .8 .8 .9 .05 .2\n\
                    brushed polygon p 0 0 9 0 0 0 1 0 0 0 0 1\n\
                    brushed polygon q 0 0 9 0 0 0 1 0 0 0 1 0";
        let (scene, warnings) =
            read_beside(&[("part.rad", part)], &format!("!xform {motion} part.rad")).unwrap();
        assert!(warnings.0.is_empty(), "{warnings:?}");
        let p = mesh(&scene, "p");
        assert_eq!(p.tangents.len(), p.positions.len());
        let along = p.tangents[0].truncate();
        assert!(along.dot(Vec3::from_array(expected)).abs() > 0.9999, "{motion}: {along}");
        // Where it points out of the surface, any direction will do.
        let q = mesh(&scene, "q");
        assert!(q.tangents[0].truncate().dot(q.normals[0]).abs() < 1e-5);
        assert_eq!(group(&scene, "p").material.theta_rad, 0.0);
        assert_eq!(scene.groups.len(), 2, "a direction makes no other group");
    }
    let (_, warnings) = material("void plastic2 m 4 -Ny Nx 0 . 0 6 .5 .5 .5 .1 .05 .2");
    assert_told(&warnings, "line 5: the plastic2 \"m\" has a direction of its highlights");
}

#[test]
fn of_other_materials_what_they_reflect_is_taken_and_told() {
    for (text, rho_d, rho_s, said) in [
        ("void trans m 0 0 7 .5 .5 .5 .1 .2 .4 .5", 0.27, 0.1, "lets light through"),
        ("void trans2 m 4 0 0 1 . 0 8 .5 .5 .5 .1 .2 .1 .4 .5", 0.27, 0.1, "lets light through"),
        ("void ashik2 m 4 0 0 1 . 0 8 .5 .5 .5 .1 .1 .1 100 10", 0.5, 0.1, "Ashikhmin"),
        ("void plasfunc m 2 f f.cal 0 4 .5 .5 .5 .2", 0.4, 0.0, "highlights that are not read"),
        ("void metdata m 4 f d . u 0 4 .5 .5 .5 .2", 0.4, 0.0, "highlights that are not read"),
        (
            "void transfunc m 2 f f.cal 0 6 .5 .5 .5 .2 .5 0",
            0.2,
            0.0,
            "highlights that are not read",
        ),
        (
            "void BRTDfunc m 10 0 0 0 0 0 0 0 0 0 . 0 9 .3 .3 .3 .1 .1 .1 0 0 0",
            0.3,
            0.0,
            "highlights",
        ),
        ("void interface m 0 0 8 1 1 1 1.5 1 1 1 1.3", 0.5, 0.0, "is not known"),
        ("void BSDF m 6 0 a.xml 0 0 1 . 0 0", 0.5, 0.0, "is not known"),
        (
            "void mirror m 1 red 0 3 .9 .9 .9",
            0.7,
            0.0,
            "was taken as the material that is seen in its place",
        ),
        (
            "void plastic m 1 word 0 5 .5 .5 .5 0 0",
            0.5,
            0.0,
            "line 5: the words of the plastic \"m\" are not read",
        ),
    ] {
        let (found, warnings) = material(text);
        assert_told(&warnings, said);
        assert_near(Vec3::new(found.rho_d.x, found.rho_s.x, 0.0), [rho_d, rho_s, 0.0], text);
    }
    for (text, said) in [
        ("void mist m 0 0 3 .1 .1 .1", "line 5: the mist \"m\" is a volume"),
        ("void antimatter m 1 red 0 0", "what it cuts away is still there"),
        ("void mirror m 1 void 0 3 .9 .9 .9", "seen in its place"),
    ] {
        let (scene, warnings) = read(&format!("{text}\nm sphere s 0 0 4 1 0 1 1"));
        assert_eq!(names(&scene), ["bulb"], "{text}");
        assert_told(&warnings, said);
    }
    let told =
        refusal("void WGMDfunc m 3 red 1 .1 0 9 1 1 1 1 1 1 0 0 0\nm sphere s 0 0 4 0 0 0 1");
    assert!(told.contains("names \"red\" as the colour of its highlights"), "{told}");
}

/// Light at normal incidence that passes a pane as Radiance has it: what is reflected to and fro inside, added up.
fn through_pane(transmissivity: f64, index: f64) -> f64 {
    let face = ((index - 1.0) / (index + 1.0)).powi(2);
    let once = |k: i32| (1.0 - face).powi(2) * transmissivity.powi(2 * k + 1) * face.powi(2 * k);
    (0..50).map(once).sum()
}

#[test]
fn glass_lets_as_much_through_as_in_radiance() {
    for (text, index) in
        [("void glass m 0 0 3 .96 .5 0", 1.52), ("void glass m 0 0 4 .96 .5 0 2.1", 2.1)]
    {
        let (scene, warnings) = read(&format!("{text}\nm sphere s 0 0 4 1 0 1 1"));
        assert_eq!(names(&scene), ["bulb"], "{text}");
        assert_eq!(warnings.0.len(), 1, "{warnings:?}");
        assert_told(&warnings, "\"m\" is glass");
        assert_eq!(scene.ungrouped_materials(), ["m"]);
        let glass = scene.ungrouped[0].glass.unwrap();
        assert!(glass.is_thin && glass.absorption == Rgb::ZERO && glass.is_valid());
        let passed = glass.tint * (1.0 - glass.reflected(1.0));
        let expected = [0.96, 0.5, 0.0].map(|t| through_pane(t, index) as f32);
        assert_near(passed, expected, text);
    }
}

#[test]
fn a_dielectric_absorbs_by_length() {
    let dimmed = "void brightfunc half 2 .5 . 0 0\nhalf dielectric m 0 0 5 1 .5 .1 1.4 20";
    let (scene, warnings) = read(&format!("{dimmed}\nm sphere s 0 0 4 1 0 1 1"));
    assert_told(&warnings, "\"m\" is glass");
    let glass = scene.ungrouped[0].glass.unwrap();
    assert!(!glass.is_thin && glass.tint == Rgb::ONE && glass.ior == 1.4);
    assert_near((-glass.absorption).exp(), [0.5, 0.25, 0.05], "after a metre");
    // Where nothing is left, it is black.
    let (scene, _) = read("void dielectric m 0 0 5 0 0 0 1.5 0\nm sphere s 0 0 4 1 0 1 1");
    assert!(scene.ungrouped[0].glass.unwrap().is_valid());
}

#[test]
fn a_mixture_with_glass_is_opaque() {
    let text = "void glass clear 0 0 3 .9 .9 .9\nvoid mixfunc m 4 red clear .5 . 0 0\nm sphere s 0 0 4 1 0 1 1";
    let (scene, warnings) = read(text);
    assert!(scene.ungrouped.is_empty());
    assert_eq!(names(&scene), ["bulb", "s"]);
    assert_told(&warnings, "is transparent in part");
}

#[test]
fn backs_and_pictures_of_others_are_not_taken_for_ours() {
    let scene = exactly("red polygon chair.back 0 0 9 0 0 0 1 0 0 0 1 0");
    assert_eq!(names(&scene), ["bulb", "chair.back"]);
    assert!(model("void plastic a 0 0 5 1 1 1 0 0\na sphere s 0 0 4 0 0 0 1").lights.is_empty());
}
