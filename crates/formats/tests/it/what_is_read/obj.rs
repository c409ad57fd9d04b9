//! OBJ and MTL: a triangle, its material, and one more statement.

use super::{assert_taken, rows};
use crate::support::Folder;
use unrender_formats::{obj, picture};
use unrender_scene::{Rgb, RgbImage, Warnings};

/// The warnings of the triangle with the statement `in_obj` and its material with the statement
/// `in_mtl`.
fn read(in_obj: &str, in_mtl: &str) -> Result<Warnings, String> {
    let folder = Folder::new();
    folder.file("a.mtl", format!("newmtl m\nKd 0.5 0.5 0.5\n{in_mtl}\n"));
    picture::write_png_srgb(&folder.path("p.png"), &RgbImage::new(1, 1, vec![Rgb::ONE])).unwrap();
    let blue = RgbImage::new(1, 1, vec![Rgb::new(0.2, 0.2, 1.0)]);
    picture::write_png_srgb(&folder.path("blue.png"), &blue).unwrap();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nusemtl m\nf 1/1/1 2/1/1 3/1/1";
    let path = folder.file("a.obj", format!("mtllib a.mtl\n{triangle}\n{in_obj}\n"));
    obj::read(&path).map(|(_, warnings)| warnings).map_err(|error| error.to_string())
}

#[test]
fn every_word_of_obj_is_taken_as_its_row_says() {
    for row in rows("OBJ") {
        let statement = match row.element {
            "f" | "fo" => format!("{} 1/1/1 2/1/1 3/1/1", row.element),
            "mtllib" => "mtllib a.mtl".into(),
            "usemtl" => "usemtl m".into(),
            "f 1 2" => "f 1 2".into(),
            many if many.starts_with("v x") => {
                many.replace(char::is_alphabetic, "0.5").replacen("0.5", "v", 1)
            }
            word => format!("{word} 1 1 1"),
        };
        assert_taken(&row, row.done, read(&statement, ""));
    }
    let told = read("v_color 1 1 1", "").unwrap();
    assert!(told.0[0].contains("the word \"v_color\" is not known"), "{told:?}");
}

#[test]
fn every_word_of_mtl_is_taken_as_its_row_says() {
    for row in rows("MTL") {
        let statement = match row.element {
            "newmtl" => "newmtl other\nKd 1 1 1".into(),
            "illum" => "illum 2".into(),
            "bump of a normal map" => "bump blue.png".into(),
            "map_Kd" | "map_d" | "map_opacity" | "map_Kn" | "map_norm" | "norm" => {
                format!("{} p.png", row.element)
            }
            "map_Kd -s 2 2" => "map_Kd -s 2 2 1 p.png".into(),
            words if words.contains(' ') => format!("{words} 1"),
            word => format!("{word} 0.5 0.5 0.5"),
        };
        let small = statement.replacen(row.element, &row.element.to_lowercase(), 1);
        assert_taken(&row, row.done, read("", &statement));
        assert_taken(&row, row.done, read("", &small));
    }
}
