//! Mitsuba's own meshes, `.serialized`: a header, then numbers compressed by zlib, for one mesh after another,
//! and at the end where each of them begins. [Mitsuba 3 documentation, plugin `serialized`]

use crate::input::Scope;
use flate2::bufread::ZlibDecoder;
use glam::{DVec3, Vec2, Vec3};
use std::io::{BufRead, BufReader, Read};
use unrender_scene::Mesh;

/// The first number of the file.
const MAGIC: u16 = 0x041c;
const HAS_NORMALS: u32 = 0x0001;
const HAS_UVS: u32 = 0x0002;
const HAS_COLORS: u32 = 0x0008;
const IS_FLAT: u32 = 0x0010;
const IS_DOUBLE: u32 = 0x2000;
/// zlib expands one byte to at most this many.
const MAX_UNPACKING: u64 = 1032;
/// The longest name of a mesh, bytes.
const MAX_NAME: u64 = 4096;

/// A mesh, and how the file states it.
pub(super) struct Stated {
    /// Without normals if the file has none.
    pub(super) mesh: Mesh,
    /// Whether its faces are to be flat, whatever its normals.
    pub(super) is_flat: bool,
    /// Whether its numbers are of single precision.
    pub(super) is_single: bool,
}

/// The mesh number `index` of `bytes`, counted from `zero`.
pub(super) fn mesh(scope: &Scope, bytes: &[u8], index: f32, zero: DVec3) -> Result<Stated, String> {
    let header = |at: usize| Some((u16_at(bytes, at)?, u16_at(bytes, at + 2)?));
    let version = match header(0) {
        Some((MAGIC, version @ (3 | 4))) => version,
        _ => return Err("is no serialized mesh of version 3 or 4".into()),
    };
    let start = start(bytes, version, index).ok_or_else(|| {
        format!("has no mesh with shape_index {index}, or its table of meshes is damaged")
    })?;
    if header(start) != Some((MAGIC, version)) {
        return Err(format!("has no mesh at the place of shape_index {index}; it is damaged"));
    }
    let packed = &bytes[start + 4..];
    let stream = BufReader::new(ZlibDecoder::new(packed));
    let most = MAX_UNPACKING.saturating_mul(packed.len() as u64);
    read(scope, stream, (version, most), zero)
}

/// Where the mesh number `index` begins.
fn start(bytes: &[u8], version: u16, index: f32) -> Option<usize> {
    if index == 0.0 {
        return Some(0);
    }
    if index < 0.0 || index.fract() != 0.0 {
        return None;
    }
    let table = bytes.len().checked_sub(4)?;
    let count = u32::from_le_bytes(bytes[table..].try_into().ok()?) as usize;
    let after = count.checked_sub(index as usize).filter(|after| *after > 0)?;
    let size = if version == 4 { 8 } else { 4 };
    let entry = table.checked_sub(after.checked_mul(size)?)?;
    let mut offset = [0; 8];
    offset[..size].copy_from_slice(&bytes[entry..entry + size]);
    usize::try_from(u64::from_le_bytes(offset)).ok()
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at.checked_add(2)?)?.try_into().ok()?))
}

fn read(
    scope: &Scope,
    mut stream: impl BufRead,
    (version, most): (u16, u64),
    zero: DVec3,
) -> Result<Stated, String> {
    let flags = u32::from_le_bytes(exact(&mut stream)?);
    if version == 4 {
        let mut name = Vec::new();
        let read = (&mut stream).take(MAX_NAME).read_until(0, &mut name).map_err(damaged)?;
        if read as u64 == MAX_NAME {
            return Err("has a mesh whose name does not end".into());
        }
    }
    let counts = [exact(&mut stream)?, exact(&mut stream)?].map(u64::from_le_bytes);
    let [vertices, faces] = counts;
    let size = if flags & IS_DOUBLE != 0 { 8 } else { 4 };
    let needed = vertices.saturating_mul(3 * size).saturating_add(faces.saturating_mul(12));
    if needed > most || vertices > u64::from(u32::MAX) {
        return Err(format!(
            "announces {vertices} vertices and {faces} faces, which it cannot hold"
        ));
    }
    // The numbers as they are read, and as the mesh stores them.
    scope.charge(needed.saturating_mul(3))?;
    let positions = places(&mut stream, vertices, size == 8, zero)?;
    let mut list = |width: u64| numbers(&mut stream, vertices * width, size == 8);
    let normals = if flags & HAS_NORMALS != 0 { triples(&list(3)?) } else { Vec::new() };
    let uvs = if flags & HAS_UVS != 0 { list(2)? } else { Vec::new() };
    if flags & HAS_COLORS != 0 {
        list(3)?;
    }
    let corners = words(&mut stream, faces * 3)?;
    if corners.iter().any(|&corner| u64::from(corner) >= vertices) {
        return Err("has a face with a vertex that is not there".into());
    }
    let mesh = Mesh {
        positions,
        normals: normals.into_iter().map(Vec3::normalize_or_zero).collect(),
        uvs: uvs.chunks_exact(2).map(Vec2::from_slice).collect(),
        triangles: corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
        ..Mesh::default()
    };
    Ok(Stated { mesh, is_flat: flags & IS_FLAT != 0, is_single: size == 4 })
}

fn triples(numbers: &[f32]) -> Vec<Vec3> {
    numbers.chunks_exact(3).map(Vec3::from_slice).collect()
}

fn damaged(error: std::io::Error) -> String {
    format!("is cut short or damaged: {error}")
}

fn exact<const N: usize>(stream: &mut impl Read) -> Result<[u8; N], String> {
    let mut bytes = [0; N];
    stream.read_exact(&mut bytes).map_err(damaged)?;
    Ok(bytes)
}

fn number(stream: &mut impl Read, is_double: bool) -> Result<f64, String> {
    Ok(if is_double {
        f64::from_le_bytes(exact(stream)?)
    } else {
        f32::from_le_bytes(exact(stream)?).into()
    })
}

fn numbers(stream: &mut impl Read, count: u64, is_double: bool) -> Result<Vec<f32>, String> {
    (0..count).map(|_| Ok(number(stream, is_double)? as f32)).collect()
}

/// Positions, counted from `zero`.
fn places(
    stream: &mut impl Read,
    count: u64,
    is_double: bool,
    zero: DVec3,
) -> Result<Vec<Vec3>, String> {
    let mut axis = || number(stream, is_double);
    let place = |_| Ok((DVec3::new(axis()?, axis()?, axis()?) - zero).as_vec3());
    (0..count).map(place).collect()
}

fn words(stream: &mut impl Read, count: u64) -> Result<Vec<u32>, String> {
    let mut all = Vec::new();
    for _ in 0..count {
        all.push(u32::from_le_bytes(exact(stream)?));
    }
    Ok(all)
}
