//! What an MTL file says of materials.

use super::text::{self, Line};
use super::unread::{Unread, Use, unknown, use_of};
use crate::input::Scope;
use std::collections::HashMap;
use std::path::Path;
use unrender_scene::{Rgb, Warnings};

const OPAQUE: Use =
    Use::Told("transparency (d, Tr or a map of it) is not read; the surface is taken as opaque");
const BUMPS: Use = Use::Told(
    "a map of bumps or normals (bump, disp, norm) is not read; the surface is taken as it is",
);
const MIRRORED: Use = Use::Told("a reflected picture (refl) is not read");
const PBR: Use = Use::Told(
    "the roughness, metal, sheen and coat of Pr, Pm, Ps and Pc are not read; Kd, Ks and Ns count",
);

/// All words of MTL in lower case, and how they are taken. Those that are read may still be told of,
/// where their numbers mean something that is not.
pub(super) const WORDS: [(&str, Use); 43] = [
    ("newmtl", Use::Read),
    ("kd", Use::Read),
    ("ks", Use::Read),
    ("ke", Use::Read),
    ("ns", Use::Read),
    ("illum", Use::Read),
    ("map_kd", Use::Read),
    // What light all around does in a picture without shadows; no part of the reflectance.
    ("ka", Use::Nothing),
    ("map_ka", Use::Nothing),
    // Of transparent surfaces and of pictures that are reflected, which are told themselves.
    ("ni", Use::Nothing),
    ("sharpness", Use::Nothing),
    ("tf", Use::Nothing),
    ("map_aat", Use::Nothing),
    ("d", OPAQUE),
    ("tr", OPAQUE),
    ("map_d", OPAQUE),
    ("map_tr", OPAQUE),
    ("map_opacity", OPAQUE),
    ("map_ke", Use::Told("map_Ke is not read; the surface emits Ke all over")),
    ("map_ks", Use::Told("map_Ks is not read; the specular part is Ks all over")),
    ("map_ns", Use::Told("map_Ns is not read; the roughness is that of Ns all over")),
    ("bump", BUMPS),
    ("map_bump", BUMPS),
    ("map_disp", BUMPS),
    ("map_kn", BUMPS),
    ("map_norm", BUMPS),
    ("disp", BUMPS),
    ("norm", BUMPS),
    ("refl", MIRRORED),
    ("map_refl", MIRRORED),
    ("decal", Use::Told("a decal is not read")),
    ("pr", PBR),
    ("pm", PBR),
    ("ps", PBR),
    ("pc", PBR),
    ("pcr", PBR),
    ("map_pr", PBR),
    ("map_pm", PBR),
    ("map_ps", PBR),
    ("map_pc", PBR),
    ("map_pcr", PBR),
    ("aniso", Use::Told("aniso is not read; the highlight is taken as round")),
    ("anisor", Use::Told("anisor is not read; the highlight is taken as round")),
];

/// The `illum` of glass and of other refraction.
const GLASS: [i32; 4] = [4, 6, 7, 9];
const GLASS_TOLD: &str = "illum 4, 6, 7 and 9 (glass, refraction) are not read; the surface is \
                          taken as opaque, of Kd and Ks";
const TWICE: &str = "the material is defined several times; the last one counts";
const EXTRA: &str = "numbers behind the third one of a colour were passed over";

/// Material files beyond so many are refused: an OBJ of a megabyte could name 100 000. Half as many are still ten
/// times what programs write; double would do no harm.
const MAX_FILES: usize = 1000;
/// What a material says that is not read is kept up to so many kinds: enough for all words of the table.
const MAX_UNREAD: usize = 64;
/// A word of two bytes becomes a sentence of a hundred.
const BYTES_A_BYTE: u64 = 64;

/// What a material file says of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Material {
    pub(super) kd: Option<Rgb>,
    pub(super) ks: Option<Rgb>,
    pub(super) ke: Option<Rgb>,
    pub(super) ns: Option<f32>,
    pub(super) illum: Option<i32>,
    /// What stands behind `map_Kd`: options and the name of a file.
    pub(super) map_kd: Option<String>,
}

/// A material, where it stands, and what of it was not read.
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
    /// What stands before the first material of each, and, of those that are used, what was not read.
    unread: Vec<Unread>,
    entries: HashMap<String, Entry>,
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

    /// The name of the material that the OBJ calls `name`, maybe with a comment behind; or `name`.
    pub(super) fn resolve<'a>(&self, name: &'a str) -> &'a str {
        let short = text::without_comment(name);
        if !self.entries.contains_key(name) && self.entries.contains_key(short) {
            short
        } else {
            name
        }
    }

    /// The material called `name` with the file that it stands in.
    pub(super) fn get(&self, name: &str) -> Option<(&Material, &str)> {
        let entry = self.entries.get(name)?;
        Some((&entry.material, &self.files[entry.file]))
    }

    /// Tells what was not read of the materials called `used`.
    pub(super) fn tell<'a>(self, used: impl Iterator<Item = &'a str>, warnings: &mut Warnings) {
        let Self { files, mut unread, entries } = self;
        for (name, entry) in used.filter_map(|name| Some((name, entries.get(name)?))) {
            for (what, line) in &entry.unread {
                unread[entry.file].note(what, *line, Some(name));
            }
        }
        for (file, unread) in files.iter().zip(unread) {
            unread.tell(file, warnings);
        }
    }

    fn open(&mut self, scope: &Scope, folder: &Path, name: &str) -> Result<(), String> {
        let read = scope.beside(folder, name).and_then(|path| scope.read(&path));
        let bytes = read.map_err(|problem| {
            format!("needs the material file \"{name}\", which {problem}; put it beside the scene")
        })?;
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
                    "what stands before the first newmtl was passed over",
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
        let word = line.word().to_ascii_lowercase();
        let material = &mut self.material;
        match word.as_str() {
            "kd" => material.kd = Some(colour(line, &mut self.unread)?),
            "ks" => material.ks = Some(colour(line, &mut self.unread)?),
            "ke" => material.ke = Some(colour(line, &mut self.unread)?),
            "ns" => material.ns = Some(number(line)? as f32),
            "illum" => {
                let illum = number(line)? as i32;
                material.illum = Some(illum);
                if GLASS.contains(&illum) {
                    note(&mut self.unread, GLASS_TOLD, line);
                }
            }
            "map_kd" => {
                material.map_kd = Some(line.rest().to_owned()).filter(|rest| !rest.is_empty());
            }
            _ => match use_of(&WORDS, &word) {
                Some(Use::Told(what)) if !is_neutral(&word, line) => {
                    note(&mut self.unread, what, line);
                }
                Some(_) => {}
                None => note(&mut self.unread, &unknown(line.word()), line),
            },
        }
        Ok(())
    }
}

fn note(unread: &mut Vec<(String, usize)>, what: &str, line: &Line<'_>) {
    if unread.len() < MAX_UNREAD && !unread.iter().any(|(known, _)| known == what) {
        unread.push((what.into(), line.number));
    }
}

/// Whether what is not read would change nothing.
fn is_neutral(word: &str, line: &Line<'_>) -> bool {
    let value = || line.words().last().and_then(text::number);
    match word {
        _ if line.rest().is_empty() => true,
        "d" => value() == Some(1.0),
        "tr" | "pm" | "ps" | "pc" | "pcr" | "aniso" | "anisor" => value() == Some(0.0),
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
    if let Some(&kind @ ("spectral" | "xyz")) = words.first() {
        return fault(&format!("{kind} colours are not read: give it red, green and blue"));
    }
    let numbers: Vec<f32> =
        words.iter().take(3).map_while(|w| text::number(w)).map(|n| n as f32).collect();
    if words.len() > 3 {
        note(unread, EXTRA, line);
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

/// The files that stand behind `mtllib`: several, or one whose name has blanks.
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
    fn every_word_is_taken_as_its_table_says() {
        for (word, taken) in WORDS {
            let mut materials = Materials::default();
            let text = format!("newmtl a\n{word} 0.5 0.5 0.5\n");
            materials.file("a.mtl", text.as_bytes()).unwrap();
            let mut warnings = Warnings::default();
            materials.tell(["a"].into_iter(), &mut warnings);
            match taken {
                Use::Told(what) => {
                    assert_eq!(warnings.0, [format!("a.mtl: \"a\": {what} (line 2).")]);
                }
                _ => assert_eq!(warnings.0, [""; 0], "{word}"),
            }
        }
    }

    #[test]
    fn what_changes_nothing_is_not_told() {
        let mut materials = Materials::default();
        let text = "newmtl a\nd 1.000\nTr 0\nPm 0\naniso 0\nmap_Ke\nbump \nillum 3\n";
        materials.file("a.mtl", text.as_bytes()).unwrap();
        let mut warnings = Warnings::default();
        materials.tell(["a"].into_iter(), &mut warnings);
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
