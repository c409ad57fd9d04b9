//! The tables of what is read of Radiance, row by row.

use super::*;
use crate::what_is_read::{assert_taken, rows};
use unrender_scene::Rgb;

/// A square picture, the OBJ of a mesh, and a part of a scene.
fn files() -> [(&'static str, &'static str); 3] {
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    let part = "white polygon p 0 0 9 0 0 0 1 0 0 0 1 0\n";
    [("m.obj", mesh), ("part.rad", part), ("corners.txt", "0 0 1 0 0 1")]
}

fn told(text: &str) -> Result<Warnings, String> {
    let folder = Folder::new();
    for (name, text) in files() {
        folder.file(name, text);
    }
    let picture = unrender_scene::RgbImage::new(2, 2, vec![Rgb::splat(0.5); 4]);
    unrender_formats::picture::write(&folder.path("p.hdr"), &picture).unwrap();
    let path = folder.file("scene.rad", format!("{BASE}{text}\n"));
    load_scene(&path).map(|(_, warnings)| warnings).map_err(|error| error.to_string())
}

/// A sphere of the material `m`, of this `kind` with its arguments.
fn of_material(kind: &str, arguments: &str) -> String {
    format!("void {kind} m {arguments}\nm sphere s 0 0 4 0 0 1 1")
}

/// A sphere of a plastic behind a pattern or texture of this `kind` with its arguments.
fn behind(kind: &str, arguments: &str) -> String {
    format!("void {kind} p {arguments}\np plastic m 0 0 5 .5 .5 .5 0 0\nm sphere s 0 0 4 0 0 1 1")
}

/// A scene with the kind, or the case, of this name.
fn example(name: &str) -> String {
    let surface = |arguments: &str| format!("white {name} s {arguments}");
    match name {
        "polygon" => surface("0 0 9 0 0 0 1 0 0 0 1 0"),
        "sphere" | "bubble" => surface("0 0 4 0 0 1 1"),
        "cylinder" | "tube" => surface("0 0 7 0 0 0 0 0 1 .5"),
        "cone" | "cup" => surface("0 0 8 0 0 0 0 0 1 .5 .2"),
        "ring" => surface("0 0 8 0 0 0 0 0 1 0 1"),
        "source" => "lamp source s 0 0 4 0 0 1 .5".into(),
        "mesh" => surface("1 m.rtm 0 0"),
        "instance" => surface("1 a.oct 0 0"),
        "alias" => "void alias m white\nm sphere s 0 0 4 0 0 1 1".into(),
        "light" | "illum" | "mirror" | "glass" => of_material(name, "0 0 3 1 1 1"),
        "glow" => of_material(name, "0 0 4 1 1 1 10"),
        "spotlight" => of_material(name, "0 0 7 1 1 1 90 0 0 -1"),
        "plastic" | "metal" => of_material(name, "0 0 5 .5 .5 .5 .1 .1"),
        "trans" => of_material(name, "0 0 7 .5 .5 .5 .1 .1 .2 .2"),
        "plastic2" | "metal2" => of_material(name, "4 1 0 0 . 0 6 .5 .5 .5 .1 .1 .2"),
        "trans2" => of_material(name, "4 1 0 0 . 0 8 .5 .5 .5 .1 .1 .2 .2 .2"),
        "ashik2" => of_material(name, "4 1 0 0 . 0 8 .5 .5 .5 .1 .1 .1 100 50"),
        "WGMDfunc" => {
            let words = "void .1 .1 .2 void 0 .1 .1 void 1 0 0 .";
            of_material(name, &format!("13 {words} 0 9 .5 .5 .5 .5 .5 .5 0 0 0"))
        }
        "dielectric" => of_material(name, "0 0 5 1 1 1 1.5 0"),
        "interface" => of_material(name, "0 0 8 1 1 1 1.5 1 1 1 1.3"),
        "mist" => of_material(name, "0 0 0"),
        "antimatter" => of_material(name, "1 void 0 0"),
        "plasfunc" | "metfunc" | "transfunc" | "plasdata" | "metdata" | "transdata" => {
            of_material(name, "2 f f.cal 0 6 .5 .5 .5 .1 .1 .1")
        }
        "BRTDfunc" => of_material(name, "10 0 0 0 0 0 0 0 0 0 . 0 9 .5 .5 .5 .5 .5 .5 0 0 0"),
        "BSDF" | "aBSDF" | "sBSDF" => of_material(name, "6 0 a.xml 0 0 1 . 0 0"),
        "prism1" | "prism2" => of_material(name, "5 c x y z a.cal 0 0"),
        "colorfunc" => behind(name, "4 .5 .5 .5 . 0 0"),
        "brightfunc" => behind(name, "2 .5 . 0 0"),
        "colorpict" => {
            let pattern = "void colorpict p 7 red green blue p.hdr . Lu Lv 0 0";
            format!("{pattern}\np plastic m 0 0 5 .5 .5 .5 0 0\nm mesh s 1 m.rtm 0 0")
        }
        "spectrum" => behind(name, "0 0 5 380 780 .5 .5 .5"),
        "mixfunc" => of_material(name, "4 red white .5 . 0 0"),
        mixture if mixture.starts_with("mix") && !mixture.contains(' ') => {
            of_material(name, "5 red white f a.cal x 0 0")
        }
        "void on a surface" => "void sphere s 0 0 4 0 0 1 1".into(),
        "mesh without its OBJ" => "white mesh s 1 none.rtm 0 0".into(),
        "colorfunc of an expression" => behind("colorfunc", "4 a b c a.cal 0 0"),
        "brightfunc of an expression" => behind("brightfunc", "2 a a.cal 0 0"),
        "mixfunc of an expression" => of_material("mixfunc", "4 red white f a.cal 0 0"),
        "glow of a radius below zero" => of_material("glow", "0 0 4 1 1 1 -1"),
        "lamp behind a pattern" => {
            let pattern = "void brightfunc p 2 a a.cal 0 0";
            format!("{pattern}\np light m 0 0 3 1 1 1\nm sphere s 0 0 4 0 0 1 1")
        }
        "mixfunc of a lamp" => of_material("mixfunc", "4 red lamp .5 . 0 0"),
        _ => behind(name, "9 r g b a b c a.cal u v 0 0"),
    }
}

#[test]
fn every_kind_is_taken_as_its_row_says() {
    for row in rows("Radiance: primitives") {
        let kind = row.element.split(' ').next().unwrap();
        let kind = if kind == "dielectric" { "is glass" } else { kind };
        assert_taken(&row, kind, told(&example(row.element)));
    }
}

#[test]
fn every_command_is_taken_as_its_row_says() {
    for row in rows("Radiance: commands") {
        let command = match row.element {
            "xform" => "!xform -n a -t 0 0 1 part.rad",
            "cat" => "!cat part.rad",
            "genbox" => "!genbox white b 1 1 1 -i -r .1",
            "genprism" => "!genprism white b corners.txt -l 0 0 2 -c",
            "gensky" => {
                "!gensky 6 21 12 +s -t 2.45\nskyfunc glow g 0 0 4 1 1 1 0\ng source s 0 0 4 0 0 1 180"
            }
            "others" => "!genrev white b f g 8",
            other => panic!("no example of {other}"),
        };
        assert_taken(&row, row.element, told(command));
    }
}

#[test]
fn every_option_of_a_view_is_taken_as_its_row_says() {
    for row in rows("Radiance: view files") {
        let whole = "rvu -vtv -vp 0 -5 1 -vd 0 1 0 -vu 0 0 1 -vh 45 -vv 45 -vs 0 -vl 0";
        let view = match row.element {
            option if whole.contains(option) => whole.to_owned(),
            "-vtl" => whole.replace("-vtv", "-vtl"),
            option => format!("{whole} {option} 1"),
        };
        let folder = Folder::new();
        folder.file("view.vf", view);
        let scene = format!("{BASE}white sphere s 0 0 4 0 0 1 1\n");
        let read = load_scene(&folder.file("scene.rad", scene));
        let read = read.map(|(_, warnings)| warnings).map_err(|error| error.to_string());
        assert_taken(&row, row.element, read);
    }
}
