//! What an OBJ says, statement by statement: numbers, faces with the indices of each corner, and names.

use super::text::{self, Line};
use super::unread::{Unread, unknown};
use crate::entry::{Entry, Taken, find, passed, read as row, told};
use crate::input::Scope;
use glam::{DVec3, Vec2, Vec3};
use std::collections::HashMap;
use unrender_scene::Warnings;

const CURVES: &str = "curves and free-form surfaces were left out; make meshes of them";
const DISPLAY: &str = "statements about the display of objects were passed over";
const OTHER_FILES: &str = "other files that it calls were not read; join them into one";
const USEMAP: &str = "a usemap was passed over; only map_Kd of the material is read";

/// All words of OBJ, and how they are taken; for those warned of, the warning.
pub(super) const WORDS: [Entry; 45] = [
    row("v", "a position, in double precision; metres are assumed"),
    row("vt", "texture coordinates, u and v; v counts from the bottom of the picture"),
    row("vn", "a normal"),
    row("f", "a face of three corners or more, convex or not; indices from the end count, too"),
    row("fo", "as f"),
    row("o", "the name of the object that the next faces belong to"),
    row(
        "g",
        "as o, and before it; where no face names a material, each name of g or o is a group of its own",
    ),
    row("s", "the next faces are smooth where they have no normals; 0 and off: flat"),
    row("usemtl", "the group of the next faces; a name that no material file has is a group, too"),
    row(
        "mtllib",
        "one material file or several, UTF-8 or Latin-1, with blanks in their names or not",
    ),
    passed("mg", "how curves are blended"),
    told("p", "points (p) were left out; only faces are surfaces"),
    told("l", "lines (l) were left out; only faces are surfaces"),
    told("vp", CURVES),
    told("cstype", CURVES),
    told("deg", CURVES),
    told("bmat", CURVES),
    told("step", CURVES),
    told("curv", CURVES),
    told("curv2", CURVES),
    told("surf", CURVES),
    told("parm", CURVES),
    told("trim", CURVES),
    told("hole", CURVES),
    told("scrv", CURVES),
    told("sp", CURVES),
    told("end", CURVES),
    told("con", CURVES),
    told("ctech", CURVES),
    told("stech", CURVES),
    told("bsp", CURVES),
    told("bzp", CURVES),
    told("cdc", CURVES),
    told("cdp", CURVES),
    told("res", CURVES),
    told("call", OTHER_FILES),
    told("csh", OTHER_FILES),
    told("maplib", USEMAP),
    told("usemap", USEMAP),
    told("bevel", DISPLAY),
    told("c_interp", DISPLAY),
    told("d_interp", DISPLAY),
    told("lod", DISPLAY),
    told("shadow_obj", DISPLAY),
    told("trace_obj", DISPLAY),
];

const COLOURS: Entry =
    told("v x y z r g b", "colours of vertices were not read; only the material colours a surface");
const MRGB: Entry = told("#MRGB", COLOURS.done);
const WEIGHT: Entry = told("v x y z w", "the fourth number of a vertex was passed over");
const TWO_MORE: Entry =
    told("v x y z a b", "a fourth and a fifth number of a vertex were passed over");
const FEW: Entry = told("f 1 2", "faces of fewer than three corners were left out");

/// Warnings of words that are read.
pub(super) const CASES: [Entry; 5] = [COLOURS, MRGB, WEIGHT, TWO_MORE, FEW];

/// A corner of a face: position, texture coordinates and normal, counted from 1; 0 for none.
pub(crate) type Corner = [u32; 3];

/// The words of a corner's three indices.
const KINDS: [&str; 3] = ["v", "vt", "vn"];

/// A polygon.
pub(crate) struct Face {
    pub(crate) line: usize,
    /// The index of its first corner.
    pub(super) first: usize,
    pub(super) count: usize,
    /// Index into [`Document::objects`].
    pub(super) object: u32,
    /// Index into [`Document::materials`].
    pub(super) material: u32,
    /// Whether it is in a smoothing group.
    pub(super) is_smooth: bool,
}

/// What an OBJ says.
#[derive(Default)]
pub(crate) struct Document {
    /// Relative to the caller's origin. In double precision, so that vertices far from there keep their
    /// shape until the origin of each mesh is known.
    pub(crate) positions: Vec<DVec3>,
    /// v counts from the bottom here.
    pub(crate) uvs: Vec<Vec2>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) corners: Vec<Corner>,
    pub(crate) faces: Vec<Face>,
    /// The names of `g` and `o`, each once; `None` for faces without one.
    pub(super) objects: Names,
    /// The names of `usemtl`, each once; `None` for faces without one.
    pub(super) materials: Names,
    /// The words after each `mtllib`, each once.
    pub(super) libraries: Names,
    pub(super) unread: Unread,
}

/// Names, each once, in the order in which they come.
#[derive(Default)]
pub(super) struct Names {
    all: Vec<Option<String>>,
    indices: HashMap<Option<String>, u32>,
}

impl Names {
    /// The name with this index.
    pub(super) fn get(&self, index: u32) -> Option<&str> {
        self.all.get(index as usize)?.as_deref()
    }

    /// All names, without the `None`.
    pub(super) fn given(&self) -> impl Iterator<Item = &str> {
        self.all.iter().filter_map(|name| name.as_deref())
    }

    fn index(&mut self, scope: &Scope, name: Option<&str>) -> Result<u32, String> {
        let name = name.map(str::to_owned);
        if let Some(index) = self.indices.get(&name) {
            return Ok(*index);
        }
        // Two copies of the name, and its entries in the list and in the map.
        scope.charge(256 + 2 * name.as_ref().map_or(0, String::len) as u64)?;
        let index = u32::try_from(self.all.len()).map_err(|_| "has too many names")?;
        self.all.push(name.clone());
        self.indices.insert(name, index);
        Ok(index)
    }
}

/// Adds `item` to `list`, whose memory is counted.
pub(super) fn push<T>(scope: &Scope, list: &mut Vec<T>, item: T) -> Result<(), String> {
    if list.len() == list.capacity() {
        let more = list.len().max(16);
        scope.charge((more * size_of::<T>()) as u64)?;
        list.reserve_exact(more);
    }
    list.push(item);
    Ok(())
}

/// Reads the statements of the text `bytes`; positions count from `origin`.
///
/// # Errors
/// If it is no OBJ, or takes too much memory; with the line.
pub(crate) fn read(scope: &Scope, bytes: &[u8], origin: DVec3) -> Result<Document, String> {
    if !text::is_text(bytes) {
        return Err(
            "is not an OBJ: it is not text (UTF-8 or Latin-1); export the scene again".into()
        );
    }
    // A line of Latin-1, or one that is continued, is copied.
    scope.charge(2 * bytes.len() as u64)?;
    let mut reader = Reader { scope, origin, found: Document::default(), now: Now::default() };
    reader.rename()?;
    reader.now.material = reader.found.materials.index(scope, None)?;
    for line in text::lines(bytes) {
        reader.statement(&line)?;
    }
    reader.found.check_indices()?;
    Ok(reader.found)
}

/// The state that applies to the next faces.
#[derive(Default)]
struct Now {
    o: Option<String>,
    g: Option<String>,
    object: u32,
    material: u32,
    is_smooth: bool,
}

struct Reader<'a> {
    scope: &'a Scope,
    origin: DVec3,
    found: Document,
    now: Now,
}

impl Reader<'_> {
    fn statement(&mut self, line: &Line<'_>) -> Result<(), String> {
        let word = line.word();
        if word.is_empty() {
            if line.is_comment(MRGB.name) {
                self.note(MRGB.done, line);
            }
            return Ok(());
        }
        match find(&WORDS, word) {
            Some(Entry { taken: Taken::Read, .. }) => self.read(word, line)?,
            Some(Entry { taken: Taken::PassedOver, .. }) => {}
            Some(entry) => self.note(entry.done, line),
            None => self.note(&unknown(word), line),
        }
        Ok(())
    }

    /// Reads the statement `line`, which begins with `word`.
    fn read(&mut self, word: &str, line: &Line<'_>) -> Result<(), String> {
        let name = || Some(line.rest()).filter(|rest| !rest.is_empty()).map(str::to_owned);
        match word {
            "v" => self.position(line)?,
            "vt" => {
                let [u, v] = numbers(line, 1)?;
                push(self.scope, &mut self.found.uvs, Vec2::new(u as f32, v as f32))?;
            }
            "vn" => {
                let normal = DVec3::from_array(numbers(line, 3)?).as_vec3();
                push(self.scope, &mut self.found.normals, normal)?;
            }
            "f" | "fo" => self.face(line)?,
            "o" => {
                (self.now.o, self.now.g) = (name(), None);
                self.rename()?;
            }
            "g" => {
                self.now.g = name();
                self.rename()?;
            }
            "s" => self.now.is_smooth = !matches!(line.words().next(), None | Some("off" | "0")),
            "usemtl" => {
                self.now.material = self.found.materials.index(self.scope, name().as_deref())?;
            }
            "mtllib" => {
                self.found.libraries.index(self.scope, name().as_deref())?;
            }
            _ => self.note(&unknown(word), line),
        }
        Ok(())
    }

    fn note(&mut self, what: &str, line: &Line<'_>) {
        self.found.unread.note(what, line.number, None);
    }

    /// The next faces belong to the last name of `g`, else of `o`.
    fn rename(&mut self) -> Result<(), String> {
        let name = self.now.g.as_deref().or(self.now.o.as_deref());
        self.now.object = self.found.objects.index(self.scope, name)?;
        Ok(())
    }

    fn position(&mut self, line: &Line<'_>) -> Result<(), String> {
        match line.words().count() {
            0..=3 => {}
            4 => {
                let [_, _, _, weight]: [f64; 4] = numbers(line, 4)?;
                if weight != 1.0 {
                    self.note(WEIGHT.done, line);
                }
            }
            5 => self.note(TWO_MORE.done, line),
            _ => self.note(COLOURS.done, line),
        }
        let position = DVec3::from_array(numbers(line, 3)?) - self.origin;
        push(self.scope, &mut self.found.positions, position)
    }

    fn face(&mut self, line: &Line<'_>) -> Result<(), String> {
        let first = self.found.corners.len();
        for word in line.words() {
            let corner = self.corner(word).ok_or_else(|| {
                let number = line.number;
                let shown = line.shown();
                format!(
                    "line {number} has a face with an index that is not a number or out of range \
                     (\"{shown}\"); export the scene again"
                )
            })?;
            push(self.scope, &mut self.found.corners, corner)?;
        }
        let count = self.found.corners.len() - first;
        if count < 3 {
            self.found.corners.truncate(first);
            self.note(FEW.done, line);
            return Ok(());
        }
        let Now { object, material, is_smooth, .. } = self.now;
        let face = Face { line: line.number, first, count, object, material, is_smooth };
        push(self.scope, &mut self.found.faces, face)
    }

    /// The corner `word`: `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&self, word: &str) -> Option<Corner> {
        let so_far = [self.found.positions.len(), self.found.uvs.len(), self.found.normals.len()];
        let mut corner = [0; 3];
        for (kind, word) in word.split('/').enumerate() {
            let so_far = *so_far.get(kind)?;
            if word.is_empty() && kind > 0 {
                continue;
            }
            let index: i64 = word.parse().ok()?;
            // Negative indices count from the end of what was read; others may refer to later
            // lines.
            let index = if index < 0 { (so_far as i64).checked_add(index)? + 1 } else { index };
            corner[kind] = u32::try_from(index).ok().filter(|&index| index > 0)?;
        }
        Some(corner)
    }
}

impl Document {
    fn check_indices(&self) -> Result<(), String> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        for face in &self.faces {
            for corner in self.corners(face) {
                for (kind, (&index, count)) in corner.iter().zip(counts).enumerate() {
                    if index as usize > count {
                        let (line, word) = (face.line, KINDS[kind]);
                        return Err(format!(
                            "line {line} has a face with an index that is out of range: {word} \
                             {index} of {count}; export the scene again"
                        ));
                    }
                }
            }
        }
        Ok(())
    }

    /// The corners of `face`.
    pub(crate) fn corners(&self, face: &Face) -> &[Corner] {
        &self.corners[face.first..face.first + face.count]
    }

    /// Warns of what was not read of `file`, for callers that use the shapes only: without
    /// materials.
    pub(crate) fn tell_of_shapes(mut self, file: &str, warnings: &mut Warnings) {
        self.unread.forget(USEMAP);
        self.unread.tell(file, warnings);
    }
}

/// The first `N` numbers of a statement, of which there are at least `least`; others are zero.
fn numbers<const N: usize>(line: &Line<'_>, least: usize) -> Result<[f64; N], String> {
    let fault = |what: String| {
        let (number, shown) = (line.number, line.shown());
        format!("is not a valid OBJ: line {number} (\"{shown}\") {what}; export the scene again")
    };
    let mut numbers = [0.0; N];
    let mut count = 0;
    for (number, word) in numbers.iter_mut().zip(line.words()) {
        *number = text::number(word).ok_or_else(|| {
            fault(format!("has a \"{}\" that is no number", text::shown(word, 40)))
        })?;
        count += 1;
    }
    if count < least {
        return Err(fault(format!("has {count} numbers where {least} are wanted")));
    }
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::Input;

    fn document(text: &str) -> Document {
        read(&Scope::new(Input::from("a.obj")), text.as_bytes(), DVec3::ZERO).unwrap()
    }

    #[test]
    fn indices_count_from_both_ends() {
        let found = document("v 0 0 0\nv 1 0 0\nvt 0\nf -1/-1 -2//1 3/1/\nv 0 1 0\nvn 0 0 1\n");
        assert_eq!(found.corners, [[2, 1, 0], [1, 0, 1], [3, 1, 0]]);
    }
}
