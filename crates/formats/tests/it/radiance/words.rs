//! How a scene file is cut into words, and what names mean.

use super::*;
use unrender_scene::Rgb;

#[test]
fn words_may_be_quoted_and_comments_stand_anywhere_between_primitives() {
    let scene = exactly(
        "void plastic 'dark blue' 0 0 5 # the colour\n .1 .1 .7 # and\n 0 0\n\
         \"dark blue\" sphere \"the ball\" 0 0 4 1 0 1 1 # told\n\
         white sphere no#comment 0 0 4 0 0 0 1",
    );
    assert_eq!(names(&scene), ["bulb", "the ball", "no#comment"]);
    assert_eq!(group(&scene, "the ball").name, "dark blue");
    assert_eq!(group(&scene, "the ball").material.rho_d, Rgb::new(0.1, 0.1, 0.7));
}

#[test]
fn files_with_a_mark_or_in_latin_1_are_read() {
    let folder = Folder::new();
    let text = format!("\u{feff}{BASE}white sphere ball 0 0 4 0 0 0 1\r\n").replace('\n', "\r\n");
    assert_eq!(load_scene(&folder.file("mark.rad", text)).unwrap().0.objects.len(), 2);
    let mut bytes = format!("{BASE}# M").into_bytes();
    bytes.extend([0xfc, b'\n']);
    bytes.extend(b"red sphere ball");
    bytes.push(0xe4);
    bytes.extend(b" 0 0 4 0 0 0 1");
    let scene = load_scene(&folder.file("latin.rad", bytes)).unwrap().0;
    assert_eq!(names(&scene), ["bulb", "ball\u{e4}"]);
    let told = load_scene(&folder.file("binary.rad", b"void\0light")).unwrap_err().to_string();
    assert!(told.contains("is no text"), "{told}");
}

#[test]
fn aliases_are_their_originals_under_another_name() {
    for (text, rho_d) in [
        ("void alias crimson red", [0.7, 0.1, 0.1]),
        ("inherit alias crimson red", [0.7, 0.1, 0.1]),
        ("void alias dark red\nvoid alias crimson dark", [0.7, 0.1, 0.1]),
        // With another pattern, and with the pattern of the original.
        ("void colorfunc half 4 .5 .5 .5 . 0 0\nhalf alias crimson red", [0.35, 0.05, 0.05]),
        (
            "void brightfunc half 2 .5 . 0 0\nhalf plastic dim 0 0 5 .8 .4 .2 0 0\n\
             inherit alias crimson dim",
            [0.4, 0.2, 0.1],
        ),
        (
            "void brightfunc half 2 .5 . 0 0\nhalf plastic dim 0 0 5 .8 .4 .2 0 0\n\
             void alias crimson dim",
            [0.8, 0.4, 0.2],
        ),
    ] {
        let scene = exactly(&format!("{text}\ncrimson sphere s 0 0 4 1 0 1 1"));
        assert_eq!(group(&scene, "s").name, "crimson");
        assert_near(group(&scene, "s").material.rho_d, rho_d, text);
    }
    let shining = exactly("void alias tube lamp\ntube sphere s 0 0 4 1 0 1 1");
    assert_eq!(group(&shining, "s").emission, Rgb::splat(10.0));
}

#[test]
fn names_mean_what_was_defined_last_before_them() {
    let (scene, _) = read(
        "red sphere before 0 0 4 1 0 1 1\nvoid alias same red\nvoid plastic red 0 0 5 .2 0 0 0 0\n\
         red sphere after 0 0 4 1 0 1 1\nsame sphere third 0 0 4 1 0 1 1",
    );
    for (name, rho_d) in [("before", 0.7), ("after", 0.2), ("third", 0.7)] {
        assert_eq!(group(&scene, name).material.rho_d.x, rho_d, "{name}");
    }
    // Defined again in the same way, it is still one group.
    let scene = exactly(
        "red sphere one 0 0 4 1 0 1 1\nvoid plastic red 0 0 5 .7 .1 .1 0 0\nred sphere two 0 0 4 1 0 1 1",
    );
    assert_eq!(scene.groups.len(), 2);
}

#[test]
fn what_has_no_material_is_invisible_and_told() {
    let (scene, warnings) =
        read("void polygon vp 0 0 9 0 0 0 1 0 0 1 1 0\nred sphere s 0 0 4 0 0 0 1");
    assert_eq!(names(&scene), ["bulb", "s"]);
    assert_told(&warnings, "line 5: the polygon \"vp\" has no material (void) and is invisible");
    let (scene, warnings) = read(
        "void texfunc bumps 4 Dx Dy Dz . 0 0\nbumps sphere b 0 0 4 0 0 0 1\nred sphere s 0 0 4 0 0 0 1",
    );
    assert_eq!(names(&scene), ["bulb", "s"]);
    assert_told(&warnings, "line 5: the texfunc \"bumps\" has no material behind it");
}

#[test]
fn faults_are_named_with_their_lines() {
    for (text, said) in [
        ("void alias a b", "line 5: the alias \"a\" stands for \"b\", which is not there"),
        ("nobody alias a red", "line 5: the alias \"a\" is made of \"nobody\", which is not there"),
        ("inherit plastic a 0 0 5 1 1 1 0 0", "only an alias inherits"),
        ("red plastik a 0 0 5 1 1 1 0 0", "\"plastik\" is no kind of primitive"),
        ("nobody plastic a 0 0 5 1 1 1 0 0", "line 5: the plastic \"a\" is made of \"nobody\""),
        ("void plastic a 0 1 7 5 1 1 1 0 0", "has whole numbers"),
        ("red sphere \"a 0 0 4 0 0 0 1", "ends in the middle of \"red sphere\""),
        ("red sphere s 0 0 4 0 0 1e60 1", "no number (\"1e60\")"),
        ("red sphere s 0 0 3 0 0 1", "has 3 numbers instead of 4"),
        ("void glass g 0 0 2 1 1", "has 2 numbers instead of 3 or 4"),
        ("red cone c 0 0 8 0 0 0 0 0 1 1 -1", "one radius below zero"),
        ("red instance i 1 room.oct 0 0", "line 5: the instance \"i\" is an octree"),
    ] {
        let told = refusal(text);
        assert!(told.contains(said), "{text}: {told}");
    }
}

#[test]
fn an_error_is_shown_with_the_warnings_that_came_before_it() {
    let folder = Folder::new();
    let text =
        "void mist pane 0 0 3 .9 .9 .9\npane sphere s 0 0 4 0 0 0 1\nred sphere t 0 0 4 0 0 0 1";
    let error = load_scene(&folder.file("scene.rad", text)).unwrap_err().to_string();
    let (problem, before) = error.split_once('\n').unwrap();
    assert!(
        problem.ends_with("line 3: the sphere \"t\" is made of \"red\", which is not there"),
        "{error}"
    );
    assert!(before.contains("before that: line 1: the mist \"pane\" is a volume"), "{error}");
    // Also for an error of the whole scene.
    let text =
        "void plastic w 0 0 5 1 1 1 0 0\nw sphere t 0 0 4 0 0 0 1\nvoid sphere u 0 0 4 0 0 0 1";
    let error = load_scene(&folder.file("scene.rad", text)).unwrap_err().to_string();
    assert!(error.contains("no light") && error.contains("before that: line 3"), "{error}");
}

#[test]
fn radii_below_zero_turn_inside_out() {
    for (text, inside_out) in [
        ("red sphere s 0 0 4 0 0 0 2", false),
        ("red sphere s 0 0 4 0 0 0 -2", true),
        ("red bubble s 0 0 4 0 0 0 -2", false),
        ("red cylinder s 0 0 7 0 0 0 0 0 1 -2", true),
        ("red cup s 0 0 8 0 0 0 0 0 1 -2 -1", false),
    ] {
        let scene = exactly(text);
        let mesh = mesh(&scene, "s");
        let [a, b, c] = mesh.corners(0);
        let outwards = (b - a).cross(c - a).dot((a + b + c).with_z(0.0)) > 0.0;
        assert_eq!(outwards, !inside_out, "{text}");
    }
}

#[test]
fn long_chains_and_nests_are_refused() {
    let mut chain = String::from("void colorfunc c0 4 1 1 1 . 0 0\n");
    (1..100_000).for_each(|k| chain += &format!("c{} colorfunc c{k} 4 1 1 1 . 0 0\n", k - 1));
    let told =
        refusal(&format!("{chain}c99999 plastic p 0 0 5 1 1 1 0 0\np sphere s 0 0 4 0 0 0 1"));
    assert!(told.contains("modifiers behind one another"), "{told}");
    let mut nest = String::from("void mixfunc m0 4 red white .5 . 0 0\n");
    (1..100_000).for_each(|k| nest += &format!("void mixfunc m{k} 4 m{0} m{0} .5 . 0 0\n", k - 1));
    let told = refusal(&format!("{nest}m99999 sphere s 0 0 4 0 0 0 1"));
    assert!(told.contains("mixtures are in one another"), "{told}");
}
