//! Finds the constants of the recovery in its code, and replaces their values there.

use crate::{Failure, root};
use std::fmt;
use std::path::{Path, PathBuf};

/// The folder of the recovery.
const CODE: &str = "crates/recover/src";

/// A constant whose value is one number.
#[derive(Debug, PartialEq)]
pub(super) struct Constant {
    /// Its file, from the root.
    pub(super) file: PathBuf,
    pub(super) name: String,
    kind: String,
    pub(super) value: String,
}

impl Constant {
    /// Whether `name` is its name, or its file and its name.
    pub(super) fn is_called(&self, name: &str) -> bool {
        let (file, name) = name.rsplit_once("::").map_or((None, name), |(f, n)| (Some(f), n));
        let stem = self.file.file_stem().and_then(|stem| stem.to_str());
        self.name == name && (file.is_none() || file == stem)
    }

    /// The number times `factor`, as code; a whole number is at least one. None if that changes nothing.
    fn times(&self, factor: f64) -> Option<String> {
        let number: f64 = self.value.replace('_', "").parse().ok()?;
        let value = number * factor;
        let text = match self.kind.as_str() {
            "f64" | "f32" => format!("{value:?}"),
            _ => format!("{:.0}", value.round().max(1.0)),
        };
        (text.parse() != Ok(number)).then_some(text)
    }

    /// The `text` of its file with `factor` times its value.
    ///
    /// # Errors
    /// If the value is the same, or the constant is not there.
    pub(super) fn changed(&self, text: &str, factor: f64) -> Result<String, Failure> {
        let Self { name, kind, value, .. } = self;
        let other = self.times(factor).ok_or("the same value")?;
        let [from, to] = [value, &other].map(|value| format!("const {name}: {kind} = {value};"));
        if !text.contains(&from) {
            return Err(format!("{from} is not in the code").into());
        }
        Ok(text.replacen(&from, &to, 1))
    }
}

impl fmt::Display for Constant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = self.file.file_stem().unwrap_or_default().to_string_lossy();
        write!(f, "{file}::{}", self.name)
    }
}

/// All constants of the recovery whose value is one number, file by file.
///
/// # Errors
/// If the code cannot be read.
pub(super) fn constants() -> Result<Vec<Constant>, Failure> {
    let mut files = Vec::new();
    sources(&root().join(CODE), &mut files)?;
    files.sort();
    let mut all = Vec::new();
    for path in files {
        let file = path.strip_prefix(root())?.to_owned();
        all.extend(constants_of(&file, &std::fs::read_to_string(&path)?));
    }
    Ok(all)
}

/// Those of the file `text`, without its tests.
fn constants_of(file: &Path, text: &str) -> Vec<Constant> {
    let product = text.split("#[cfg(test)]").next().unwrap_or_default();
    let constant = |line: &str| {
        let (_, declared) = line.split_once("const ")?;
        let (name, rest) = declared.split_once(": ")?;
        let (kind, rest) = rest.split_once(" = ")?;
        let value = rest.strip_suffix(';')?;
        value.replace('_', "").parse::<f64>().ok()?;
        let [name, kind, value] = [name, kind, value].map(str::to_owned);
        Some(Constant { file: file.to_owned(), name, kind, value })
    };
    product.lines().filter_map(constant).collect()
}

/// Adds the sources below `folder` to `files`.
fn sources(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), Failure> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            sources(&path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "/// A.\npub(crate) const A: f64 = 0.5;\nconst B: usize = 1_200;\nconst C: u32 = 1 << 4;\n\
        const D: i32 = 1;\n#[cfg(test)]\nmod tests {\n    const E: f64 = 1.0;\n}\n";

    #[test]
    fn numbers_are_found_and_changed() {
        let all = constants_of(Path::new("crates/recover/src/a.rs"), TEXT);
        let names: Vec<String> = all.iter().map(Constant::to_string).collect();
        assert_eq!(names, ["a::A", "a::B", "a::D"]);
        assert!(all[0].is_called("A") && all[0].is_called("a::A") && !all[0].is_called("b::A"));
        let half = all[0].changed(TEXT, 0.5).unwrap();
        assert!(half.contains("pub(crate) const A: f64 = 0.25;"), "{half}");
        assert!(all[1].changed(TEXT, 2.0).unwrap().contains("const B: usize = 2400;"));
        // Half of one is not another whole number.
        assert!(all[2].changed(TEXT, 0.5).is_err());
        assert!(all[2].changed("", 2.0).is_err());
    }

    #[test]
    fn the_recovery_has_constants() {
        let all = constants().unwrap();
        assert!(all.len() > 100, "{}", all.len());
        for constant in &all {
            let text = std::fs::read_to_string(root().join(&constant.file)).unwrap();
            assert!(
                constant.changed(&text, 2.0).is_ok() || constant.times(2.0).is_none(),
                "{constant}"
            );
        }
    }
}
