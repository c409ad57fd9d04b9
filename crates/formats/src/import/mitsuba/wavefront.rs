//! The geometry of OBJ files: corners, texture coordinates and normals, without materials and groups,
//! which Mitsuba passes over.

use crate::input::Scope;
use crate::polygon;
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;
use unrender_scene::Mesh;

/// A face takes at most so many times the memory of its text: two bytes a corner become an entry of the
/// table of vertices, a vertex and a share of a triangle.
const TEXT_TO_MESH: u64 = 64;

/// Position, texture coordinates and normal of a corner, counted from one; zero where there are none.
type Corner = [u32; 3];

#[derive(Default)]
struct Lists {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    vertices: BTreeMap<Corner, u32>,
    mesh: Mesh,
    has_uvs: bool,
    has_normals: bool,
}

/// All faces of `bytes` as one mesh; v as the file has it. Vertices without normals have zeros, and there are
/// no normals at all if no vertex has one.
pub(super) fn mesh(scope: &Scope, bytes: &[u8]) -> Result<Mesh, String> {
    scope.charge(TEXT_TO_MESH * bytes.len() as u64)?;
    // What is not ASCII is in names and comments.
    let text = String::from_utf8_lossy(bytes);
    let mut lists = Lists::default();
    for (index, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        lists.line(line).map_err(|problem| format!("has in line {} {problem}", index + 1))?;
    }
    let Lists { mut mesh, has_uvs, has_normals, .. } = lists;
    if !has_uvs {
        mesh.uvs.clear();
    }
    if !has_normals {
        mesh.normals.clear();
    }
    Ok(mesh)
}

impl Lists {
    fn line(&mut self, line: &str) -> Result<(), String> {
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => self.positions.push(Vec3::from_array(numbers(words)?)),
            Some("vt") => self.uvs.push(Vec2::from_array(numbers(words)?)),
            Some("vn") => {
                self.normals.push(Vec3::from_array(numbers(words)?).normalize_or_zero());
            }
            Some("f") => self.face(words)?,
            _ => {}
        }
        Ok(())
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<(), String> {
        let corners = words.map(|word| self.vertex(word)).collect::<Result<Vec<u32>, String>>()?;
        let positions = &self.mesh.positions;
        polygon::split(&corners, |&i| positions[i as usize], &mut self.mesh.triangles)
    }

    /// The vertex of a corner such as `3`, `3/1`, `3//2` or `3/1/2`.
    fn vertex(&mut self, word: &str) -> Result<u32, String> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let mut corner = Corner::default();
        for (kind, index) in word.split('/').enumerate() {
            let fault = || format!("a face with \"{word}\", which is not there");
            let count = *counts.get(kind).ok_or_else(fault)?;
            if index.is_empty() && kind > 0 {
                continue;
            }
            let index: i64 = index.parse().map_err(|_| fault())?;
            // Below zero it counts from the last one so far.
            let index = if index < 0 { index + count as i64 + 1 } else { index };
            if !(1..=count as i64).contains(&index) {
                return Err(fault());
            }
            corner[kind] = u32::try_from(index).map_err(|_| fault())?;
        }
        if let Some(known) = self.vertices.get(&corner) {
            return Ok(*known);
        }
        let [position, uv, normal] = corner.map(|index| index as usize);
        let new = self.mesh.positions.len() as u32;
        self.vertices.insert(corner, new);
        self.mesh.positions.push(self.positions[position - 1]);
        self.has_uvs |= uv > 0;
        self.has_normals |= normal > 0;
        self.mesh.uvs.push(if uv > 0 { self.uvs[uv - 1] } else { Vec2::ZERO });
        self.mesh.normals.push(if normal > 0 { self.normals[normal - 1] } else { Vec3::ZERO });
        Ok(new)
    }
}

/// The first numbers of a line; more may follow.
fn numbers<'a, const N: usize>(
    mut words: impl Iterator<Item = &'a str>,
) -> Result<[f32; N], String> {
    let mut all = [0.0; N];
    for number in &mut all {
        let word = words.next().unwrap_or_default();
        let parsed = word.parse().ok().filter(|value: &f32| value.is_finite());
        *number = parsed.ok_or_else(|| format!("\"{word}\" instead of a number"))?;
    }
    Ok(all)
}
