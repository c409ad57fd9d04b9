//! Commands that are carried out, and those that are refused.

use super::*;
use std::f32::consts::PI;

/// A triangle in the first quadrant, its front upwards, and round surfaces.
const PART: &str = "red polygon p 0 0 9 0 0 0  1 0 0  0 2 0
white cylinder c 0 0 7 0 0 0  0 0 1  .5
white sphere s 0 0 4 1 1 1 .5
white ring r 0 0 8 0 0 0  0 0 1  0 1
";

/// The scene that `command` makes with [`PART`] beside it.
fn made(command: &str) -> Scene {
    let read = read_beside(&[("part.rad", PART)], command);
    let (scene, warnings) = read.unwrap_or_else(|error| panic!("{command}: {error}"));
    assert!(warnings.0.is_empty(), "{command}: {warnings:?}");
    scene
}

#[test]
fn every_motion_moves_every_surface() {
    for (motion, low, high, up) in [
        ("-t 1 2 3", [1., 2., 3.], [2., 4., 3.], [0., 0., 1.]),
        ("-s 2", [0., 0., 0.], [2., 4., 0.], [0., 0., 4.]),
        ("-rx 90", [0., 0., 0.], [1., 0., 2.], [0., -1., 0.]),
        ("-ry 90", [0., 0., -1.], [0., 2., 0.], [1., 0., 0.]),
        ("-rz 90", [-2., 0., 0.], [0., 1., 0.], [0., 0., 1.]),
        // Mirroring does not exchange front and back: the front stays on the side that was above.
        ("-mx", [-1., 0., 0.], [0., 2., 0.], [0., 0., 1.]),
        ("-my", [0., -2., 0.], [1., 0., 0.], [0., 0., 1.]),
        ("-mz", [0., 0., 0.], [1., 2., 0.], [0., 0., -1.]),
        ("-s -1", [-1., -2., 0.], [0., 0., 0.], [0., 0., -1.]),
        ("-t 1 0 0 -s 2", [2., 0., 0.], [4., 4., 0.], [0., 0., 4.]),
        ("-t 1 0 0 -i 2 -t 0 0 1", [1., 0., 2.], [2., 2., 2.], [0., 0., 1.]),
        ("-I", [0., 0., 0.], [1., 2., 0.], [0., 0., -1.]),
        ("-I -mz", [0., 0., 0.], [1., 2., 0.], [0., 0., 1.]),
    ] {
        let scene = made(&format!("!xform {motion} part.rad"));
        let [found_low, found_high] = bounds(mesh(&scene, "p"));
        assert_near(found_low, low, motion);
        assert_near(found_high, high, motion);
        assert_near(area(mesh(&scene, "p")).1, up, motion);
        let ring = area(mesh(&scene, "r")).1.normalize();
        assert_near(ring, Vec3::from_array(up).normalize().to_array(), motion);
    }
    let scene = made("!xform -rx 90 -s 2 -t 5 0 0 part.rad");
    assert_near(bounds(mesh(&scene, "s"))[0], [6., -3., 1.], "sphere");
    assert_near(bounds(mesh(&scene, "c"))[1], [6., 0., 1.], "cylinder");
    let inside_out = made("!xform -I part.rad");
    let [a, b, c] = mesh(&inside_out, "s").corners(7);
    assert!((b - a).cross(c - a).dot(a - Vec3::ONE) < 0.0);
}

#[test]
fn arrays_lists_names_and_modifiers_are_carried_out() {
    let scene = made("!xform -n row -a 3 -t 2 0 0 part.rad");
    for (name, x) in [("row.0.p", 0.0), ("row.1.p", 2.0), ("row.2.p", 4.0)] {
        assert_near(bounds(mesh(&scene, name))[0], [x, 0., 0.], name);
    }
    assert_eq!(scene.objects.len(), 1 + 3 * 4);
    // A lattice that is moved as a whole.
    let scene = made("!xform -a 2 -t 3 0 0 -a 3 -t 0 4 0 -i 1 -t 0 0 5 part.rad");
    assert_near(bounds(mesh(&scene, "a1.2.p"))[0], [3., 8., 5.], "lattice");
    assert_eq!(scene.objects.len(), 1 + 6 * 4);
    let scene = made("!xform -m red -n a -n b part.rad");
    assert_eq!(group(&scene, "a.b.s").name, "red");
    let list = "# places\n-t 1 0 0 part.rad\n!xform -n two -t 2 0 0 -s \\\n 2 part.rad\n\n";
    let (scene, _) = read_beside(&[("part.rad", PART), ("list", list)], "!xform -f list").unwrap();
    assert_near(bounds(mesh(&scene, "i0.p"))[0], [1., 0., 0.], "list");
    assert_near(bounds(mesh(&scene, "two.1.p"))[1], [6., 4., 0.], "list");
}

#[test]
fn several_files_and_programs_and_pipes_are_carried_out() {
    for (command, count) in [
        ("!xform part.rad part.rad", 8),
        ("!xform part.rad | xform -t 0 0 9 | xform -e -s 2", 4),
        ("!cat part.rad part.rad | xform -a 2 -t 1 0 0", 16),
        ("!xform < part.rad", 4),
        ("!cat part.rad | cat", 4),
        ("!xform part.rad; cat part.rad && xform -s 2 part.rad # all", 12),
        (" \t !xform \\\n   -t 1 0 0 \\\n part.rad", 4),
        ("!/usr/local/bin/xform 'part.rad'", 4),
        ("red sphere a 0 0 4 0 0 0 1 !xform part.rad", 5),
    ] {
        assert_eq!(made(command).objects.len(), 1 + count, "{command}");
    }
    let scene = made("!genbox red box 1 1 1 \\\n| xform -t -2 0 0");
    let found: Vec<_> = scene.objects[1..].iter().map(|object| bounds(&object.mesh)).collect();
    let low = found.iter().map(|b| b[0]).reduce(Vec3::min).unwrap();
    let high = found.iter().map(|b| b[1]).reduce(Vec3::max).unwrap();
    assert_near(low, [-2., 0., 0.], "box");
    assert_near(high, [-1., 1., 1.], "box");
}

#[test]
fn xform_enters_the_folder_of_a_file_and_cat_does_not() {
    let files = [
        ("a/part.rad", "!xform leaf.rad"),
        ("a/leaf.rad", "red sphere inner 0 0 4 0 0 0 1"),
        ("leaf.rad", "red sphere outer 0 0 4 0 0 0 1"),
    ];
    for (command, expected) in [("!xform a/part.rad", "inner"), ("!cat a/part.rad", "outer")] {
        let (scene, _) = read_beside(&files, command).unwrap();
        assert_eq!(names(&scene), ["bulb", expected], "{command}");
    }
}

#[test]
fn boxes_are_closed_and_face_outwards() {
    let corner = 0.1f32;
    let flat = 2.0 * (0.8 * 1.8 + 1.8 * 2.8 + 0.8 * 2.8);
    let bevel =
        4.0 * (0.8 + 1.8 + 2.8) * 2f32.sqrt() * corner + 8.0 * 3f32.sqrt() / 2.0 * corner * corner;
    for (options, expected, out) in [
        ("", 22.0, 1.0),
        ("-i", 22.0, -1.0),
        ("-b .1", flat + bevel, 1.0),
        ("-i -b .1", flat + bevel, -1.0),
        // With whole balls and cylinders, as in Radiance.
        ("-r .1", flat + 2.0 * PI * corner * 4.0 * 5.4 + 8.0 * 4.0 * PI * corner * corner, 1.0),
    ] {
        let scene = exactly(&format!("!genbox red box 1 2 3 {options}"));
        let middle = Vec3::new(0.5, 1.0, 1.5);
        let mut total = 0.0;
        for object in &scene.objects[1..] {
            let (size, way) = area(&object.mesh);
            total += size;
            let from = bounds(&object.mesh).iter().sum::<Vec3>() / 2.0 - middle;
            assert!(way.length() < 1e-3 || out * way.dot(from) > 0.0, "{options}: {}", object.name);
        }
        assert!((total / expected - 1.0).abs() < 3e-3, "{options}: {total} instead of {expected}");
        assert!(scene.objects[1].name.starts_with("box."));
    }
}

#[test]
fn prisms_have_their_sides_and_ends() {
    let square = "genprism red pr 4 0 0 0 2 2 2 2 0";
    for (command, expected, count) in [
        (format!("!{square}"), 16.0, 6),
        (format!("!{square} -l 0 0 3"), 32.0, 6),
        (format!("!{square} -l 0 0 3 -e"), 24.0, 4),
        (format!("!{square} -e -c"), 6.0, 3),
        ("!genprism red pr corners -l 0 0 -1".to_owned(), 16.0, 6),
    ] {
        let (scene, _) = read_beside(&[("corners", "0 0\n0 2\n2 2 2 0\n")], &command).unwrap();
        let total: f32 = scene.objects[1..].iter().map(|object| area(&object.mesh).0).sum();
        assert!((total - expected).abs() < 1e-4, "{command}: {total}");
        assert_eq!(scene.objects.len(), 1 + count);
    }
    // Clockwise seen from above, and upwards: the fronts are outside.
    let scene = exactly(&format!("!{square}"));
    assert_near(area(mesh(&scene, "pr.t")).1, [0., 0., 4.], "top");
    assert_near(area(mesh(&scene, "pr.1")).1, [-2., 0., 0.], "side");
    let (_, warnings) = read(&format!("!{square} -r .1"));
    assert_told(&warnings, "line 5: the edges of the prism \"pr\" are not rounded");
}

#[test]
fn meshes_are_moved_by_their_arguments() {
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let files = [("box.obj", cube), ("part.rad", "red mesh m 5 box.rtm -t 1 0 0 0 0")];
    let turned = |x: f32, y: f32| {
        0.7 * Vec3::new(x * 0.75f32.sqrt() - y * 0.5, x * 0.5 + y * 0.75f32.sqrt(), 0.0)
    };
    let corners = [turned(0., 0.), turned(1., 0.), turned(1., 1.), turned(0., 1.)];
    let low = corners.into_iter().reduce(Vec3::min).unwrap() + Vec3::new(-2.0, 0.0, 0.5);
    for (text, name, low) in [
        ("red mesh m 1 box.rtm 0 0", "m", [0., 0., 0.]),
        ("red mesh m 9 box.rtm -s 0.7 -rz 30 -t -2 0 0.5 0 0", "m", low.to_array()),
        ("red mesh m 7 box.rtm -i 3 -t 1 0 0 0 0", "m", [3., 0., 0.]),
        ("!xform part.rad", "m", [1., 0., 0.]),
        ("!xform -s 2 -t 0 0 1 part.rad", "m", [2., 0., 1.]),
        ("!xform -a 3 -t 0 5 0 part.rad", "a2.m", [1., 10., 0.]),
    ] {
        let read = read_beside(&files, text);
        let (scene, warnings) = read.unwrap_or_else(|error| panic!("{text}: {error}"));
        assert!(warnings.0.is_empty(), "{warnings:?}");
        assert_near(bounds(mesh(&scene, name))[0], low, text);
        assert_eq!(group(&scene, name).name, "red");
    }
    // A mirrored one still has its front outside.
    let (scene, _) = read_beside(&files, "red mesh m 2 box.rtm -mx 0 0").unwrap();
    let m = mesh(&scene, "m");
    assert!((0..m.triangles.len()).all(|index| {
        let [a, b, c] = m.corners(index);
        (b - a).cross(c - a).dot(a - Vec3::new(-0.5, 0.5, 0.5)) > 0.0
    }));
    let told = read_beside(&files, "red mesh m 3 box.rtm -rz box 0 0").unwrap_err();
    assert!(told.contains("line 5: the mesh \"m\": a motion has \"-rz\""), "{told}");
}

#[test]
fn no_program_is_run() {
    let folder = Folder::new();
    for (command, said) in [
        ("!touch made", "the program \"touch\" is not built in; no program is run for a scene"),
        ("!gensurf red s 'x' 'y' 'z' 9 9", "\"gensurf\" is not built in"),
        ("!gendaylit 6 21 12 -W 800 100", "xform -e SCENE.rad > FLAT.rad"),
        ("!genbox red b 1 1 1 | sed s/red/white/", "\"sed\" is not built in"),
        ("!genbox red b 1 1 1 > made", "has a > that only a shell understands"),
        ("!xform $PART", "has a $ that only"),
        ("!cat `touch made`", "has a ` that only"),
        ("!sh -c 'touch made'", "\"sh\" is not built in"),
        ("!genbox red b 1 1", "line 5: genbox is used as"),
        ("!genbox red b 1 1 1 -x", "genbox has \"-x\""),
        ("!genprism red p - -l 0 0 1", "genprism reads corners from its input"),
        ("!genprism red p 4 0 0 1 0", "genprism is used as"),
        ("!genprism red p 3 0 0 1 0 1 1 -l 1 0 0", "does not leave the xy plane"),
        ("!xform -t 1 2 part.rad", "xform has \"-t\", which is no motion"),
        ("!xform -k part.rad", "xform has \"-k\""),
        ("!xform -t 1 0 0", "xform names no file, and nothing is piped into it"),
        ("!cat -n part.rad", "cat has \"-n\""),
        ("!xform -a 0 part.rad", "no count behind -a"),
        ("!", "has no program"),
    ] {
        let path = folder.file("scene.rad", format!("{BASE}{command}\n"));
        let told = load_scene(&path).unwrap_err().to_string();
        assert!(
            told.contains(said) && told.contains(&format!("line {}", BASE_LINES + 1)),
            "{told}"
        );
    }
    assert!(!folder.path("made").exists());
}

#[test]
fn repetitions_are_bounded() {
    let files =
        [("part.rad", PART), ("empty.rad", "# nothing"), ("self.rad", "!xform -a 2 self.rad")];
    for (command, said) in [
        ("!xform -a 2000000000 empty.rad", "--input-memory"),
        ("!xform -a 100000 -a 100000 part.rad", "--input-memory"),
        (
            "!xform -a 9 -a 9 -a 9 -a 9 -a 9 -a 9 -a 9 -a 9 -a 9 part.rad",
            "lists and arrays in one another",
        ),
        ("!xform self.rad", "including itself"),
        ("!cat self.rad", "including itself"),
        ("!xform -f part.rad part.rad", "includes \"red\""),
    ] {
        let told = read_beside(&files, command);
        let told = told.err().unwrap_or_else(|| panic!("{command} was read"));
        assert!(told.contains(said), "{command}: {told}");
    }
    let words = "-t 0 0 0 ".repeat(5000);
    assert!(
        read_beside(&files, &format!("!xform {words} part.rad")).unwrap_err().contains("256 words")
    );
}

#[test]
fn lights_of_our_own_exports_move_with_their_comments() {
    let light = "# light {\"kind\":\"point\",\"position\":[1.0,0.0,0.0],\"name\":\"l\",\"strength\":[4.0,4.0,4.0]}\n\
                 void light l_l 0 0 3 1 1 1\nl_l sphere l_l.sphere 0 0 4 1 0 0 .001\n";
    let (scene, _) = read_beside(&[("l.rad", light)], "!xform -n n -s 2 -t 0 0 1 l.rad").unwrap();
    let light = &scene.lights[0];
    assert_eq!(light.name, "n.l");
    let unrender_scene::LightKind::Point { position, intensity } = light.kind else { panic!() };
    assert_near(scene.in_world(position).as_vec3(), [2., 0., 1.], "position");
    assert_near(intensity, [16.; 3], "a ball of the same radiance, four times the size");
}
