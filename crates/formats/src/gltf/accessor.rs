//! Typed numbers out of buffers, each access checked against what is there.

use super::Problem;
use super::document::Accessor;
use super::source::{Source, get};
use glam::{Vec2, Vec3, Vec4};

const BYTE: u32 = 5120;
const UNSIGNED_BYTE: u32 = 5121;
const SHORT: u32 = 5122;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

/// The memory of an index: itself, its part of a triangle, and, where normals are missing, a vertex
/// of 32 bytes of its own.
pub(super) const BYTES_A_INDEX: u64 = 48;
/// The memory of a number: itself, and as part of a vector.
const BYTES_A_NUMBER: u64 = 8;

/// The elements of accessor `index`, pairs.
pub(super) fn vec2s(source: &Source, index: usize) -> Result<Vec<Vec2>, Problem> {
    Ok(floats(source, index, "VEC2")?.chunks_exact(2).map(Vec2::from_slice).collect())
}

/// The elements of accessor `index`, triples.
pub(super) fn vec3s(source: &Source, index: usize) -> Result<Vec<Vec3>, Problem> {
    Ok(floats(source, index, "VEC3")?.chunks_exact(3).map(Vec3::from_slice).collect())
}

/// The elements of accessor `index`, quadruples.
pub(super) fn vec4s(source: &Source, index: usize) -> Result<Vec<Vec4>, Problem> {
    Ok(floats(source, index, "VEC4")?.chunks_exact(4).map(Vec4::from_slice).collect())
}

/// The elements of accessor `index`, vertex indices.
pub(super) fn indices(source: &Source, index: usize) -> Result<Vec<u32>, Problem> {
    let accessor = get(&source.document.accessors, index, "accessor")?;
    let decode = |bytes: &[u8]| {
        let value = unsigned(bytes, accessor.component_type);
        value.ok_or_else(|| "holds indices that are not unsigned".to_owned())
    };
    values(source, accessor, ("SCALAR", BYTES_A_INDEX), decode).map_err(|p| named(index, &p))
}

/// All components of accessor `index`, element by element.
fn floats(source: &Source, index: usize, kind: &str) -> Result<Vec<f32>, Problem> {
    let accessor = get(&source.document.accessors, index, "accessor")?;
    let decode = |bytes: &[u8]| Ok(float(bytes, accessor.component_type, accessor.normalized));
    values(source, accessor, (kind, BYTES_A_NUMBER), decode).map_err(|p| named(index, &p))
}

/// All components of an accessor of a kind, each of which costs so many bytes. Without a bufferView they are
/// zero, as in glTF, except where a sparse list replaces them.
fn values<T: Clone + Default>(
    source: &Source,
    accessor: &Accessor,
    (kind, bytes_each): (&str, u64),
    decode: impl Fn(&[u8]) -> Result<T, Problem>,
) -> Result<Vec<T>, Problem> {
    let elements = open(source, accessor, kind)?;
    let width = component_size(accessor.component_type).unwrap_or(1);
    let each = components(kind);
    let total = (accessor.count as u64).saturating_mul(each as u64);
    source.scope().charge(total.saturating_mul(bytes_each))?;
    let mut values = match elements {
        Some(elements) => {
            let mut values = Vec::with_capacity(elements.count * each);
            for component in elements.iter().flat_map(|element| element.chunks_exact(width)) {
                values.push(decode(component)?);
            }
            values
        }
        None => vec![T::default(); accessor.count * each],
    };
    for (target, element) in sparse(source, accessor, kind)? {
        let start = target as usize * each;
        let slots = values
            .get_mut(start..start + each)
            .ok_or_else(|| format!("replaces element {target}, which it does not have"))?;
        for (slot, component) in slots.iter_mut().zip(element.chunks_exact(width)) {
            *slot = decode(component)?;
        }
    }
    Ok(values)
}

/// The elements that a sparse accessor replaces, with their bytes.
fn sparse<'a>(
    source: &'a Source,
    accessor: &Accessor,
    kind: &str,
) -> Result<Vec<(u32, &'a [u8])>, Problem> {
    let Some(sparse) = &accessor.sparse else { return Ok(Vec::new()) };
    let index_size = component_size(sparse.indices.component_type).unwrap_or(0);
    let size = components(kind) * component_size(accessor.component_type).unwrap_or(0);
    let view = source.view(sparse.indices.buffer_view)?;
    let targets =
        Elements::new(view, sparse.indices.byte_offset, index_size, index_size, sparse.count)?;
    let view = source.view(sparse.values.buffer_view)?;
    let values = Elements::new(view, sparse.values.byte_offset, size, size, sparse.count)?;
    let numbered = targets.iter().zip(values.iter()).map(|(target, value)| {
        let target = unsigned(target, sparse.indices.component_type);
        target.map(|t| (t, value)).ok_or_else(|| "has sparse indices that are not unsigned".into())
    });
    numbered.collect()
}

/// The bytes of each element of an accessor, once they are known to be there.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Elements<'a> {
    fn new(
        view: &'a [u8],
        offset: usize,
        stride: usize,
        size: usize,
        count: usize,
    ) -> Result<Self, Problem> {
        if size == 0 || stride < size {
            return Err("has a byteStride or component type that is not valid glTF".into());
        }
        let bytes = view.get(offset..).unwrap_or(&[]);
        let needed = match count.checked_sub(1) {
            None => Some(0),
            Some(last) => last.checked_mul(stride).and_then(|start| start.checked_add(size)),
        };
        if needed.is_none_or(|needed| needed > bytes.len()) {
            return Err(format!(
                "announces {count} elements, which reach beyond its bufferView of {} bytes",
                view.len()
            ));
        }
        Ok(Self { bytes, stride, size, count })
    }

    fn iter(&self) -> impl Iterator<Item = &'a [u8]> {
        let (bytes, stride, size) = (self.bytes, self.stride, self.size);
        (0..self.count).map(move |i| &bytes[i * stride..i * stride + size])
    }
}

/// The bytes of an accessor's elements, if they have any.
fn open<'a>(
    source: &'a Source,
    accessor: &Accessor,
    kind: &str,
) -> Result<Option<Elements<'a>>, Problem> {
    if accessor.kind != kind {
        return Err(format!("is of type {} where {kind} is needed", accessor.kind));
    }
    let Some(component) = component_size(accessor.component_type) else {
        return Err(format!("has the unknown component type {}", accessor.component_type));
    };
    let Some(view) = accessor.buffer_view else { return Ok(None) };
    let size = component * components(kind);
    let stride = get(&source.document.buffer_views, view, "bufferView")?.byte_stride;
    let bytes = source.view(view)?;
    let stride = stride.unwrap_or(size);
    Elements::new(bytes, accessor.byte_offset, stride, size, accessor.count).map(Some)
}

fn named(index: usize, problem: &str) -> Problem {
    format!("accessor {index} {problem}; export the scene again")
}

fn components(kind: &str) -> usize {
    match kind {
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => 1,
    }
}

fn component_size(component_type: u32) -> Option<usize> {
    match component_type {
        BYTE | UNSIGNED_BYTE => Some(1),
        SHORT | UNSIGNED_SHORT => Some(2),
        UNSIGNED_INT | FLOAT => Some(4),
        _ => None,
    }
}

/// One component as a number; `normalized` integers by the formulas of glTF.
fn float(bytes: &[u8], component_type: u32, normalized: bool) -> f32 {
    let (value, full) = match (component_type, bytes) {
        (FLOAT, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]),
        (BYTE, &[a]) => (f32::from(a as i8), 127.0),
        (UNSIGNED_BYTE, &[a]) => (f32::from(a), 255.0),
        (SHORT, &[a, b]) => (f32::from(i16::from_le_bytes([a, b])), 32767.0),
        (UNSIGNED_SHORT, &[a, b]) => (f32::from(u16::from_le_bytes([a, b])), 65535.0),
        (_, &[a, b, c, d]) => (u32::from_le_bytes([a, b, c, d]) as f32, 4_294_967_295.0),
        _ => (f32::NAN, 1.0),
    };
    if normalized { (value / full).max(-1.0) } else { value }
}

fn unsigned(bytes: &[u8], component_type: u32) -> Option<u32> {
    match (component_type, bytes) {
        (UNSIGNED_BYTE, &[a]) => Some(u32::from(a)),
        (UNSIGNED_SHORT, &[a, b]) => Some(u32::from(u16::from_le_bytes([a, b]))),
        (UNSIGNED_INT, &[a, b, c, d]) => Some(u32::from_le_bytes([a, b, c, d])),
        _ => None,
    }
}
