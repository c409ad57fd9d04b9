//! Mitsuba's compressed meshes, `.serialized`.

use crate::support::Folder;
use glam::{Vec2, Vec3};
use std::io::Write;
use unrender_formats::load_model;

/// A file of meshes: one square for each of `heights`, at this height.
pub(crate) fn serialized(version: u16, heights: &[f64], is_double: bool) -> Vec<u8> {
    let mut file = Vec::new();
    let mut starts = Vec::new();
    for height in heights {
        starts.push(file.len() as u64);
        file.extend(0x041cu16.to_le_bytes());
        file.extend(version.to_le_bytes());
        let mut plain = Vec::new();
        plain.extend((0x0002u32 | if is_double { 0x2000 } else { 0x1000 }).to_le_bytes());
        if version == 4 {
            plain.extend(b"quad\0");
        }
        plain.extend(4u64.to_le_bytes());
        plain.extend(2u64.to_le_bytes());
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let positions = corners.iter().flat_map(|[x, y]| [*x, *y, *height]);
        for number in positions.chain(corners.iter().flatten().copied()) {
            if is_double {
                plain.extend(f64::to_le_bytes(number));
            } else {
                plain.extend((number as f32).to_le_bytes());
            }
        }
        plain.extend([0u32, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
        let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        packer.write_all(&plain).unwrap();
        file.extend(packer.finish().unwrap());
    }
    for start in &starts {
        let bytes = start.to_le_bytes();
        file.extend(&bytes[..if version == 4 { 8 } else { 4 }]);
    }
    file.extend((heights.len() as u32).to_le_bytes());
    file
}

#[test]
fn compressed_meshes_are_read_by_their_number() {
    let folder = Folder::new();
    let shape = |index: f64| {
        format!(
            "<shape type=\"serialized\"><string name=\"filename\" value=\"m.serialized\"/>\
                 <integer name=\"shape_index\" value=\"{index}\"/></shape>"
        )
    };
    for (version, is_double) in [(4, false), (4, true), (3, false)] {
        folder.file("m.serialized", serialized(version, &[1.0, 2.0, 3.0], is_double));
        for index in 0..3 {
            let text = format!("<scene version=\"3.0.0\">{}</scene>", shape(index.into()));
            let (scene, _) = load_model(&folder.file("scene.xml", text)).unwrap();
            let mesh = &scene.objects[0].mesh;
            assert!(
                mesh.positions.iter().all(|p| p.z == index as f32 + 1.0),
                "{:?}",
                mesh.positions
            );
            assert_eq!(
                (mesh.triangles.len(), mesh.normals[0], mesh.uvs[2]),
                (2, Vec3::Z, Vec2::ONE)
            );
        }
    }
    let whole = serialized(4, &[1.0, 2.0], false);
    let mut liar = whole.clone();
    let end = liar.len();
    liar[end - 12..end - 4].copy_from_slice(&u64::MAX.to_le_bytes());
    let mut huge = vec![0x1c, 0x04, 4, 0];
    let mut packer = flate2::write::ZlibEncoder::new(&mut huge, flate2::Compression::fast());
    packer.write_all(&[0x00, 0x10, 0, 0, 0]).unwrap();
    packer.write_all(&[u64::MAX.to_le_bytes(), 1u64.to_le_bytes()].concat()).unwrap();
    packer.finish().unwrap();
    for (bytes, index, said) in [
        (whole[..30].to_vec(), 0.0, "cut short or damaged"),
        (whole.clone(), 2.0, "shape_index 2"),
        (liar, 1.0, "shape_index 1"),
        (huge, 0.0, "cannot hold"),
        (b"solid".to_vec(), 0.0, "is no serialized mesh"),
        (Vec::new(), 0.0, "is no serialized mesh"),
    ] {
        folder.file("m.serialized", bytes);
        let text = format!("<scene version=\"3.0.0\">{}</scene>", shape(index));
        let told = load_model(&folder.file("scene.xml", text)).unwrap_err().to_string();
        assert!(told.contains("line 1: \"m.serialized\" ") && told.contains(said), "{told}");
    }
}
