//! Meshes from PLY files: positions, and normals and texture coordinates if there are any.

use crate::entry::{Entry, Table, find, passed, read};
use crate::input::Scope;
use crate::polygon;
use glam::{DVec3, Vec2, Vec3};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};
use unrender_scene::Mesh;

const PLACE: &str =
    "the position, in double precision; a warning if floats are coarse far from the file's zero";
const NORMAL: &str = "the normal, if all three are there";
const UV: &str = "texture coordinates, if both are there";

/// The properties of vertices and faces, in the order of the numbers of a vertex.
const PROPERTIES: [Entry; 13] = [
    read("x", PLACE),
    read("y", PLACE),
    read("z", PLACE),
    read("nx", NORMAL),
    read("ny", NORMAL),
    read("nz", NORMAL),
    read("u", UV),
    read("v", UV),
    read("s", "as u"),
    read("t", "as v"),
    read("vertex_indices", "the corners of a face, three or more, convex or not"),
    read("vertex_index", "the corners of a face, three or more, convex or not"),
    passed(
        "others",
        "such as colours of vertices: only Mitsuba's mesh attributes use them, and these are refused",
    ),
];

/// What is read of PLY.
pub(super) fn table() -> Table {
    Table::new("PLY", "property", &PROPERTIES)
}

/// Memory of a corner of a face, bytes: it becomes a triangle with three vertices of 32 bytes and
/// indices.
const BYTES_A_CORNER: u64 = 128;

/// The mesh in `bytes`, counted from `origin`, and whether the file has its positions in single precision; polygons
/// become triangles. If the file has no normals, the mesh has none.
///
/// # Errors
/// If it is not PLY, if a face names a vertex that is not there, or if it takes too much memory.
pub(super) fn mesh(scope: &Scope, bytes: &[u8], origin: DVec3) -> Result<(Mesh, bool), String> {
    let invalid = |error| format!("is no valid PLY: {error}");
    let mut reader = Reader::new(bytes);
    let parser = Parser::<Element>::new();
    let header = parser.read_header(&mut reader).map_err(invalid)?;
    check_counts(scope, &header, bytes.len())?;
    let payload = parser.read_payload(&mut reader, &header).map_err(invalid)?;
    let vertices = payload.get("vertex").ok_or("has no vertices")?;
    let column =
        |index: usize| -> Option<Vec<f32>> { vertices.iter().map(|v| v.numbers[index]).collect() };
    let vectors = |first: usize| -> Option<Vec<Vec3>> {
        let [x, y, z] = [column(first)?, column(first + 1)?, column(first + 2)?];
        Some(x.into_iter().zip(y).zip(z).map(|((x, y), z)| Vec3::new(x, y, z)).collect())
    };
    if !vertices.iter().all(|vertex| vertex.numbers[..3].iter().all(Option::is_some)) {
        return Err("has vertices without x, y and z".into());
    }
    let here = |vertex: &Element| (DVec3::from_array(vertex.place) - origin).as_vec3();
    let positions: Vec<Vec3> = vertices.iter().map(here).collect();
    let normals = vectors(3);
    let uvs = column(6).zip(column(7));
    let uvs: Vec<Vec2> =
        uvs.map_or(Vec::new(), |(u, v)| u.into_iter().zip(v).map(Vec2::from).collect());
    let mut triangles = Vec::new();
    for face in payload.get("face").into_iter().flatten() {
        let corners = face.corners.as_ref().ok_or("has faces without vertex_indices")?;
        if corners.iter().any(|&i| i as usize >= positions.len()) {
            return Err("has a face with a vertex that is not there".into());
        }
        scope.charge(BYTES_A_CORNER * corners.len() as u64)?;
        polygon::split(corners, |&i| positions[i as usize], &mut triangles)?;
    }
    let normals = normals.unwrap_or_default().into_iter().map(Vec3::normalize_or_zero).collect();
    let mesh = Mesh { positions, normals, uvs, triangles, ..Mesh::default() };
    Ok((mesh, is_single(&header)))
}

/// Whether positions are stated in single precision.
fn is_single(header: &Header) -> bool {
    let single = PropertyType::Scalar(ScalarType::Float);
    let vertex = header.elements.get("vertex");
    let axes = vertex.map(|vertex| ["x", "y", "z"].map(|axis| vertex.properties.get(axis)));
    axes.is_some_and(|axes| axes.into_iter().flatten().any(|axis| axis.data_type == single))
}

/// Refuses counts that the `length` bytes of the file cannot hold, or that take too much memory.
fn check_counts(scope: &Scope, header: &Header, length: usize) -> Result<(), String> {
    let mut least = 0u64;
    for element in header.elements.values() {
        let (name, count) = (&element.name, element.count as u64);
        let each = least_size(element, header.encoding == Encoding::Ascii);
        least = least.saturating_add(count.saturating_mul(each));
        // The last number of a text needs no end of line.
        if (each == 0 && count > 0) || least > length as u64 + 1 {
            return Err(format!(
                "announces {count} elements \"{name}\", which its {length} bytes cannot hold"
            ));
        }
        scope.charge(count * size_of::<Element>() as u64)?;
    }
    Ok(())
}

/// The least number of bytes of an element.
fn least_size(element: &ElementDef, is_text: bool) -> u64 {
    let least = |kind: &PropertyType| match kind {
        _ if is_text => 2,
        PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => size(scalar),
    };
    element.properties.values().map(|property| least(&property.data_type)).sum()
}

fn size(scalar: &ScalarType) -> u64 {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// The data of a vertex or a face that is used.
#[derive(Default)]
struct Element {
    /// Position, normal and texture coordinates of a vertex.
    numbers: [Option<f32>; 8],
    /// The position in double precision.
    place: [f64; 3],
    /// The vertices of a face.
    corners: Option<Vec<u32>>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let known = find(&PROPERTIES, name).map_or("", |row| row.name);
        let slot = match known {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            "nx" => 3,
            "ny" => 4,
            "nz" => 5,
            "u" | "s" => 6,
            "v" | "t" => 7,
            "vertex_indices" | "vertex_index" => {
                self.corners = self.corners.take().or_else(|| indices(property));
                return PropertyAccessResult::Set;
            }
            _ => return PropertyAccessResult::Ignored,
        };
        if let (None, Some(number)) = (self.numbers[slot], number(&property)) {
            self.numbers[slot] = Some(number as f32);
            if let Some(axis) = self.place.get_mut(slot) {
                *axis = number;
            }
        }
        PropertyAccessResult::Set
    }
}

fn number(property: &Property) -> Option<f64> {
    match *property {
        Property::Float(v) => Some(v.into()),
        Property::Double(v) => Some(v),
        Property::Char(v) => Some(v.into()),
        Property::UChar(v) => Some(v.into()),
        Property::Short(v) => Some(v.into()),
        Property::UShort(v) => Some(v.into()),
        Property::Int(v) => Some(v.into()),
        Property::UInt(v) => Some(v.into()),
        _ => None,
    }
}

fn indices(property: Property) -> Option<Vec<u32>> {
    fn signed<T: TryInto<u32>>(list: Vec<T>) -> Option<Vec<u32>> {
        list.into_iter().map(|i| i.try_into().ok()).collect()
    }
    match property {
        Property::ListInt(list) => signed(list),
        Property::ListUInt(list) => Some(list),
        Property::ListShort(list) => signed(list),
        Property::ListUShort(list) => signed(list),
        Property::ListChar(list) => signed(list),
        Property::ListUChar(list) => signed(list),
        _ => None,
    }
}
