//! What an MTL file says of materials.

use super::text::{self, Line};
use super::unread::{Unread, unknown};
use crate::entry::{Entry as Word, Taken, near, passed, read, refused, told};
use crate::input::Scope;
use std::collections::HashMap;
use std::path::Path;
use unrender_scene::{Rgb, Warnings};

/// The `illum` of glass and of other refraction.
const CLEAR: [i32; 4] = [4, 6, 7, 9];
/// The sentence about maps of heights.
pub(super) const HEIGHTS: &str = "a map of heights (bump, disp) is not read, as it has no unit: the surface is taken as \
                                  smooth as its mesh";

const OPAQUE: &str =
    "transparency (d, Tr or a map of it) is not read; the surface is taken as opaque";
const NORMALS: &str = "a normal map in tangent space, y upwards in the picture";
const HOLES: &str = "holes where the picture's alpha, or else its luminance, is below a half";
const MIRRORED: &str = "a reflected picture (refl) is not read";
const PBR: &str =
    "the roughness, metal, sheen and coat of Pr, Pm, Ps and Pc are not read; Kd, Ks and Ns count";

/// All words of MTL, in small letters or large ones, and how they are taken; for those warned of, the warning.
/// Words that are read may still cause a warning, if their numbers mean something that is not read.
pub(super) const WORDS: [Word; 43] = [
    read("newmtl", "the name of the next material; the last one of a name counts, with a warning"),
    read("Kd", "the diffuse reflectance: three numbers, or one for all"),
    read("Ks", "the specular reflectance, unless illum is 0 or 1"),
    read("Ke", "the emitted radiance"),
    near("Ns", "the width of the lobe: alpha = sqrt(2 / (Ns + 2)), as wide as Blinn and Phong's"),
    read(
        "illum",
        "0 and 1: nothing specular; 2, 3, 5, 8 and 10: as without it; 4, 6, 7 and 9 with d below 1, Tr above 0 or a Tf: smooth \
         glass",
    ),
    read("map_Kd", "a picture that Kd multiplies, repeated over the texture coordinates"),
    passed("Ka", "light all around in a picture without shadows; no part of the reflectance"),
    passed("map_Ka", "light all around in a picture without shadows; no part of the reflectance"),
    read("Ni", "the refractive index of glass; 1.5 without one, or where it is 1"),
    passed("sharpness", "how sharp reflected pictures are"),
    read("Tf", "what glass leaves of light that passes it"),
    passed("map_aat", "how a program smooths the picture's edges"),
    told("d", OPAQUE),
    told("Tr", OPAQUE),
    read("map_d", HOLES),
    told("map_Tr", OPAQUE),
    read("map_opacity", HOLES),
    told("map_Ke", "map_Ke is not read; the surface emits Ke all over"),
    told("map_Ks", "map_Ks is not read; the specular part is Ks all over"),
    told("map_Ns", "map_Ns is not read; the roughness is that of Ns all over"),
    told("bump", HEIGHTS),
    told("map_bump", HEIGHTS),
    told("map_disp", HEIGHTS),
    read("map_Kn", NORMALS),
    read("map_norm", NORMALS),
    told("disp", HEIGHTS),
    read("norm", NORMALS),
    told("refl", MIRRORED),
    told("map_refl", MIRRORED),
    told("decal", "a decal is not read"),
    told("Pr", PBR),
    told("Pm", PBR),
    told("Ps", PBR),
    told("Pc", PBR),
    told("Pcr", PBR),
    told("map_Pr", PBR),
    told("map_Pm", PBR),
    told("map_Ps", PBR),
    told("map_Pc", PBR),
    told("map_Pcr", PBR),
    told("aniso", "aniso is not read; the highlight is taken as round"),
    told("anisor", "anisor is not read; the highlight is taken as round"),
];

const GLASS_TOLD: Word = told(
    "illum 4",
    "illum 4, 6, 7 and 9 (glass, refraction) are not read without d, Tr or Tf; the surface is taken as opaque, of Kd and Ks",
);
const NORMALS_TOLD: Word =
    read("bump of a normal map", "as norm: its mean is that of the colour of flat normals");
const EXTRA: Word = told("Kd 1 1 1 1", "numbers after the third one of a colour were passed over");
const SPECTRAL: Word =
    refused("Kd spectral", "spectral colours are not read: give it red, green and blue");
const XYZ: Word = refused("Kd xyz", "xyz colours are not read: give it red, green and blue");

const OPTION: Word = refused(
    "map_Kd -s 2 2",
    "an option that changes the picture or its place; apply it to the picture or the texture coordinates and \
     remove it",
);

/// Cases that are warned of or refused, of words that are read.
pub(super) const CASES: [Word; 6] = [GLASS_TOLD, NORMALS_TOLD, EXTRA, SPECTRAL, XYZ, OPTION];

const TWICE: &str = "the material is defined several times; the last one counts";

/// More material files are refused: an OBJ of a megabyte could name 100 000. Half as many are still ten times
/// what programs write; double would do no harm.
const MAX_FILES: usize = 1000;
/// The most kinds of unread statements that are kept per material: enough for all words of the table.
const MAX_UNREAD: usize = 64;
/// Memory per byte: a word of two bytes becomes a sentence of a hundred.
const BYTES_A_BYTE: u64 = 64;

/// What a material file says of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Material {
    pub(super) kd: Option<Rgb>,
    pub(super) ks: Option<Rgb>,
    pub(super) ke: Option<Rgb>,
    pub(super) ns: Option<f32>,
    pub(super) illum: Option<i32>,
    /// The words after `map_Kd`: options and the name of a file.
    pub(super) map_kd: Option<String>,
    pub(super) ni: Option<f32>,
    pub(super) tf: Option<Rgb>,
    /// Whether `d` or `Tr` says so.
    pub(super) is_transparent: bool,
    /// Of normals.
    pub(super) normals: Option<Map>,
    /// Of heights, or of normals after all.
    pub(super) bump: Option<Map>,
    pub(super) map_d: Option<Map>,
}

impl Material {
    /// Whether surfaces of the material are glass. Lamps are not.
    pub(super) fn is_glass(&self) -> bool {
        let is_dark = self.ke.is_none_or(|ke| ke.max_element() <= 0.0);
        let filter = self.tf.unwrap_or(Rgb::ONE);
        let is_clear = (self.is_transparent || self.tf.is_some()) && filter.max_element() > 0.0;
        is_dark && is_clear && self.illum.is_some_and(|illum| CLEAR.contains(&illum))
    }
}

/// A picture. Two are the same wherever they stand.
#[derive(Clone, Debug)]
pub(super) struct Map {
    /// The words after the statement: options and the name of a file.
    pub(super) words: String,
    pub(super) line: usize,
}

impl PartialEq for Map {
    fn eq(&self, other: &Self) -> bool {
        self.words == other.words
    }
}

/// A material, its place, and what was not read of it.
struct Entry {
    file: usize,
    line: usize,
    material: Material,
    unread: Vec<(String, usize)>,
}

/// The materials of all files that an OBJ names.
#[derive(Default)]
pub(super) struct Materials {
    /// As the OBJ names them.
    files: Vec<String>,
    /// What was not read of each file: before the first material, and of the materials that are used.
    unread: Vec<Unread>,
    entries: HashMap<String, Entry>,
    /// The files that are not there.
    missing: Vec<String>,
}

impl Materials {
    /// The materials of the files that the `mtllib` of the OBJ at `obj` name.
    ///
    /// # Errors
    /// If a file is missing or not valid.
    pub(super) fn read<'a>(
        scope: &Scope,
        obj: &Path,
        libraries: impl Iterator<Item = &'a str>,
    ) -> Result<Self, String> {
        let folder = obj.parent().unwrap_or(Path::new(""));
        let too_many = || format!("names more than {MAX_FILES} material files; join them");
        let mut materials = Self::default();
        for (number, names) in libraries.enumerate() {
            if number >= MAX_FILES || names.split_ascii_whitespace().count() > MAX_FILES {
                return Err(too_many());
            }
            for name in file_names(folder, names) {
                if materials.files.contains(&name) {
                    continue;
                }
                if materials.files.len() >= MAX_FILES {
                    return Err(too_many());
                }
                materials.open(scope, folder, &name)?;
            }
        }
        Ok(materials)
    }

    /// The name of the material that the OBJ calls `name`, perhaps followed by a comment; else
    /// `name`.
    pub(super) fn resolve<'a>(&self, name: &'a str) -> &'a str {
        let short = text::without_comment(name);
        if !self.entries.contains_key(name) && self.entries.contains_key(short) {
            short
        } else {
            name
        }
    }

    /// The material called `name`, and its file.
    pub(super) fn get(&self, name: &str) -> Option<(&Material, &str)> {
        let entry = self.entries.get(name)?;
        Some((&entry.material, &self.files[entry.file]))
    }

    /// Warns of what was not read of the materials called `used`: beyond what is known here, of `more`.
    pub(super) fn tell<'a>(
        self,
        used: impl Iterator<Item = &'a str>,
        more: &[(String, &'static str, usize)],
        warnings: &mut Warnings,
    ) {
        let Self { files, mut unread, entries, missing } = self;
        for file in missing {
            warnings.push(format!("the material file \"{file}\" is missing and was left out"));
        }
        for (name, entry) in used.filter_map(|name| Some((name, entries.get(name)?))) {
            let is_glass = entry.material.is_glass();
            let is_covered = |what: &str| is_glass && [OPAQUE, GLASS_TOLD.done].contains(&what);
            for (what, line) in entry.unread.iter().filter(|(what, _)| !is_covered(what)) {
                unread[entry.file].note(what, *line, Some(name));
            }
            for (_, what, line) in more.iter().filter(|(whose, ..)| whose == name) {
                unread[entry.file].note(what, *line, Some(name));
            }
        }
        for (file, unread) in files.iter().zip(unread) {
            unread.tell(file, warnings);
        }
    }

    fn open(&mut self, scope: &Scope, folder: &Path, name: &str) -> Result<(), String> {
        let path = scope.find(folder, name);
        let read = path.and_then(|path| path.map(|path| scope.read(&path)).transpose());
        let bytes = read.map_err(|problem| {
            format!("needs the material file \"{name}\", which {problem}; put it beside the scene")
        })?;
        let Some(bytes) = bytes else {
            self.missing.push(name.to_owned());
            return Ok(());
        };
        scope.charge(BYTES_A_BYTE * bytes.len() as u64)?;
        self.file(name, &bytes)
            .map_err(|problem| format!("has the material file \"{name}\", which {problem}"))
    }

    fn file(&mut self, name: &str, bytes: &[u8]) -> Result<(), String> {
        if !text::is_text(bytes) {
            return Err("is not text (UTF-8 or Latin-1); export the scene again".into());
        }
        let file = self.files.len();
        self.files.push(name.to_owned());
        self.unread.push(Unread::default());
        let mut current: Option<(String, Entry)> = None;
        for line in text::lines(bytes) {
            let word = line.word();
            if word.is_empty() {
                continue;
            }
            if word.eq_ignore_ascii_case("newmtl") {
                self.keep(current.take());
                let (material, unread) = (Material::default(), Vec::new());
                let entry = Entry { file, line: line.number, material, unread };
                current = Some((line.rest().to_owned(), entry));
                continue;
            }
            match &mut current {
                Some((_, entry)) => entry.statement(&line)?,
                None => self.unread[file].note(
                    "statements before the first newmtl were passed over",
                    line.number,
                    None,
                ),
            }
        }
        self.keep(current);
        Ok(())
    }

    /// The last material of a name counts. Many programs write the same one into several files.
    fn keep(&mut self, new: Option<(String, Entry)>) {
        let Some((name, mut entry)) = new else { return };
        if let Some(before) = self.entries.get(&name) {
            let was_told = before.unread.iter().any(|(what, _)| what == TWICE);
            if was_told || before.material != entry.material {
                entry.unread.push((TWICE.into(), entry.line));
            }
        }
        self.entries.insert(name, entry);
    }
}

impl Entry {
    fn statement(&mut self, line: &Line<'_>) -> Result<(), String> {
        let known = WORDS.iter().find(|entry| entry.name.eq_ignore_ascii_case(line.word()));
        match known {
            Some(Word { done, .. }) if *done == HEIGHTS => {
                self.material.bump = map(line).or(self.material.bump.take());
            }
            Some(Word { name, taken: Taken::Read | Taken::Approximated, .. }) => {
                return self.read(name, line);
            }
            Some(Word { name, taken: Taken::WarnedOf, done }) if !is_neutral(name, line) => {
                self.material.is_transparent |= matches!(*name, "d" | "Tr");
                note(&mut self.unread, done, line);
            }
            Some(_) => {}
            None => note(&mut self.unread, &unknown(line.word()), line),
        }
        Ok(())
    }

    /// Reads the statement `line`, which begins with `word`.
    fn read(&mut self, word: &str, line: &Line<'_>) -> Result<(), String> {
        let material = &mut self.material;
        match word {
            "Kd" => material.kd = Some(colour(line, &mut self.unread)?),
            "Ks" => material.ks = Some(colour(line, &mut self.unread)?),
            "Ke" => material.ke = Some(colour(line, &mut self.unread)?),
            "Ns" => material.ns = Some(number(line)? as f32),
            "illum" => {
                let illum = number(line)? as i32;
                material.illum = Some(illum);
                if CLEAR.contains(&illum) {
                    note(&mut self.unread, GLASS_TOLD.done, line);
                }
            }
            "map_Kd" => {
                material.map_kd = Some(line.rest().to_owned()).filter(|rest| !rest.is_empty());
            }
            // Of no use without glass, so what is no number there does not matter.
            "Ni" => material.ni = number(line).ok().map(|ni| ni as f32),
            "Tf" => material.tf = colour(line, &mut Vec::new()).ok(),
            "map_Kn" | "map_norm" | "norm" => material.normals = map(line),
            "map_d" | "map_opacity" => material.map_d = map(line),
            _ => note(&mut self.unread, &unknown(word), line),
        }
        Ok(())
    }
}

/// The map that `line` names, if any.
fn map(line: &Line<'_>) -> Option<Map> {
    let words = line.rest().to_owned();
    (!words.is_empty()).then_some(Map { words, line: line.number })
}

fn note(unread: &mut Vec<(String, usize)>, what: &str, line: &Line<'_>) {
    if unread.len() < MAX_UNREAD && !unread.iter().any(|(known, _)| known == what) {
        unread.push((what.into(), line.number));
    }
}

/// Whether the unread statement would change nothing.
fn is_neutral(word: &str, line: &Line<'_>) -> bool {
    let value = || line.words().last().and_then(text::number);
    match word {
        _ if line.rest().is_empty() => true,
        "d" => value() == Some(1.0),
        "Tr" | "Pm" | "Ps" | "Pc" | "Pcr" | "aniso" | "anisor" => value() == Some(0.0),
        _ => false,
    }
}

/// The colour that `line` states: three numbers, or one for all three.
fn colour(line: &Line<'_>, unread: &mut Vec<(String, usize)>) -> Result<Rgb, String> {
    let fault = |what: &str| {
        let (number, shown) = (line.number, line.shown());
        Err(format!("says \"{shown}\" in line {number}; {what}"))
    };
    let words: Vec<&str> = line.words().collect();
    match words.first() {
        Some(&"spectral") => return fault(SPECTRAL.done),
        Some(&"xyz") => return fault(XYZ.done),
        _ => {}
    }
    let numbers: Vec<f32> =
        words.iter().take(3).map_while(|w| text::number(w)).map(|n| n as f32).collect();
    if words.len() > 3 {
        note(unread, EXTRA.done, line);
    }
    match (numbers.as_slice(), words.len()) {
        ([grey], 1) => Ok(Rgb::splat(*grey)),
        (&[r, g, b], _) => Ok(Rgb::new(r, g, b)),
        _ => fault("give the colour 3 numbers"),
    }
}

fn number(line: &Line<'_>) -> Result<f64, String> {
    line.words().next().and_then(text::number).ok_or_else(|| {
        format!("says \"{}\" in line {}; give it a number", line.shown(), line.number)
    })
}

/// The files named after `mtllib`: several, or one whose name has blanks.
fn file_names(folder: &Path, names: &str) -> Vec<String> {
    let plain = |name: &str| name.trim_matches('"').replace('\\', "/");
    let exists = |name: &str| folder.join(plain(name)).is_file();
    for whole in [names, text::without_comment(names)] {
        if exists(whole) {
            return vec![plain(whole)];
        }
    }
    let mut found = Vec::new();
    let mut begun: Vec<&str> = Vec::new();
    let ended = |begun: &[&str]| {
        let whole = begun.join(" ");
        let are_several = !exists(&whole) && begun.iter().all(|name| exists(name));
        let several = || begun.iter().map(|name| plain(name)).collect();
        if are_several { several() } else { vec![plain(&whole)] }
    };
    for word in text::without_comment(names).split_ascii_whitespace() {
        begun.push(word);
        if word.to_ascii_lowercase().ends_with(".mtl") {
            found.extend(ended(&begun));
            begun.clear();
        }
    }
    if !begun.is_empty() {
        found.extend(ended(&begun));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_changes_nothing_is_not_told() {
        let mut materials = Materials::default();
        let text = "newmtl a\nd 1.000\nTr 0\nPm 0\naniso 0\nmap_Ke\nbump \nillum 3\n";
        materials.file("a.mtl", text.as_bytes()).unwrap();
        let mut warnings = Warnings::default();
        materials.tell(["a"].into_iter(), &[], &mut warnings);
        assert_eq!(warnings.0, [""; 0]);
    }

    #[test]
    fn many_names_stand_behind_mtllib() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a b.mtl", "c.mtl", "d", "e"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let found = |names: &str| file_names(folder.path(), names);
        assert_eq!(found("a b.mtl"), ["a b.mtl"]);
        assert_eq!(found("a b.mtl c.mtl"), ["a b.mtl", "c.mtl"]);
        assert_eq!(found("c.mtl d e"), ["c.mtl", "d", "e"]);
        assert_eq!(found("d c.mtl # both"), ["d", "c.mtl"]);
        assert_eq!(found("\"a b.mtl\""), ["a b.mtl"]);
        assert_eq!(found(".\\c.mtl"), ["./c.mtl"]);
        assert_eq!(found("not there.mtl c.mtl"), ["not there.mtl", "c.mtl"]);
        assert!(found("").is_empty());
    }
}
