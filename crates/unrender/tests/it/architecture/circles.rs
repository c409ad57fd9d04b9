//! The modules of each folder, each together with its own folder, import each other without circles. Only a module and
//! those in its folder may use each other: shared items are in the module, and the module calls those in its folder.
//!
//! Imports are found in the text: `use` items, and paths in the code. A name that a module re-exports
//! by `pub use` is followed to its definition.

use super::{product_lines, rust_files};
use std::collections::{BTreeMap, BTreeSet};

/// A module's path inside its crate; empty for its root.
type Module = Vec<String>;

/// The modules of the crate whose sources are in `src`, with their text.
fn texts(src: &str) -> BTreeMap<Module, String> {
    let module = |path: &str| -> Module {
        let inner = path[src.len() + 1..].trim_end_matches(".rs");
        let names: Vec<String> = inner.split('/').map(str::to_owned).collect();
        match names[names.len() - 1].as_str() {
            "mod" | "lib" | "main" => names[..names.len() - 1].to_vec(),
            _ => names,
        }
    };
    rust_files(src).iter().map(|path| (module(path), product_lines(path).join("\n"))).collect()
}

/// The paths of a `use` item without its braces.
fn expanded(tree: &str) -> Vec<String> {
    let Some((before, rest)) = tree.split_once('{') else {
        return vec![tree.split(" as ").next().unwrap_or_default().trim().to_owned()];
    };
    let inner = rest.rsplit_once('}').map_or(rest, |(inner, _)| inner);
    let mut parts = vec![String::new()];
    let mut depth = 0;
    for letter in inner.chars() {
        depth += i32::from(letter == '{') - i32::from(letter == '}');
        match letter {
            ',' if depth == 0 => parts.push(String::new()),
            _ => parts.last_mut().unwrap().push(letter),
        }
    }
    let parts = parts.iter().map(|part| part.trim()).filter(|part| !part.is_empty());
    parts.flat_map(expanded).map(|path| format!("{}{path}", before.trim())).collect()
}

/// The `use` items of `text`, each with whether it is re-exported.
fn uses(text: &str) -> Vec<(bool, String)> {
    let items = text.split(';').filter_map(|item| {
        let start = item.rfind("use ").filter(|start| {
            let before = item[..*start].chars().next_back();
            before.is_none_or(|letter| letter.is_whitespace())
        })?;
        let is_public = item[..start].trim_end().ends_with(['b', ')']);
        Some((is_public, item[start + 4..].split_whitespace().collect::<Vec<_>>().join(" ")))
    });
    items
        .flat_map(|(is_public, tree)| expanded(&tree).into_iter().map(move |p| (is_public, p)))
        .collect()
}

/// The paths with `::` in the code of `text`.
fn paths(text: &str) -> Vec<String> {
    let is_part = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == ':';
    let words = text.split(|letter| !is_part(letter)).filter(|word| word.contains("::"));
    words.map(|word| word.trim_matches(':').to_owned()).collect()
}

/// The modules of one crate and their re-exports.
struct Crate {
    texts: BTreeMap<Module, String>,
    /// For a module and a name: the path from which the name is re-exported.
    handed_on: BTreeMap<(Module, String), Module>,
}

impl Crate {
    fn read(src: &str) -> Self {
        Self::of(texts(src))
    }

    fn of(texts: BTreeMap<Module, String>) -> Self {
        let mut this = Self { texts, handed_on: BTreeMap::new() };
        for (module, text) in &this.texts {
            for (_, path) in uses(text).into_iter().filter(|(is_public, _)| *is_public) {
                if let Some(target) = this.absolute(module, &path) {
                    let name = target[target.len() - 1].clone();
                    this.handed_on.insert((module.clone(), name), target);
                }
            }
        }
        this
    }

    /// `path`, as written in `module`, from the root of the crate; none if it is outside the crate.
    fn absolute(&self, module: &Module, path: &str) -> Option<Module> {
        let mut base = module.clone();
        let mut parts = path.split("::").map(str::to_owned).peekable();
        let first = parts.peek()?.clone();
        let child: Module = [module.as_slice(), std::slice::from_ref(&first)].concat();
        match first.as_str() {
            "crate" => {
                parts.next();
                base.clear();
            }
            "self" | "super" => {
                while let Some(part) = parts.next_if(|part| part == "self" || part == "super") {
                    if part == "super" {
                        base.pop();
                    }
                }
            }
            _ if self.texts.contains_key(&child) => {}
            _ => return None,
        }
        base.extend(parts);
        (!base.is_empty()).then_some(base)
    }

    /// The module to which `path` (from the root) leads.
    fn target(&self, path: &Module) -> Module {
        let mut path = path.clone();
        // A name may be re-exported more than once, but not without end.
        for _ in 0..4 {
            let end = (0..=path.len()).rev().find(|end| self.texts.contains_key(&path[..*end]));
            let module = path[..end.unwrap_or(0)].to_vec();
            let handed = path
                .get(module.len())
                .and_then(|name| self.handed_on.get(&(module.clone(), name.clone())));
            match handed {
                Some(from) if *from != path => path.clone_from(from),
                _ => return module,
            }
        }
        path
    }

    /// The modules that have modules in a folder of their own, and the root.
    fn folders(&self) -> BTreeSet<Module> {
        let inner = self.texts.keys().filter(|module| !module.is_empty());
        inner.map(|module| module[..module.len() - 1].to_vec()).collect()
    }

    /// For every module in `folder`, the modules beside it that it or its own folder imports; with the imports.
    fn families(&self, folder: &Module) -> BTreeMap<String, BTreeMap<String, String>> {
        let depth = folder.len();
        let is_inside = |module: &Module| module.len() > depth && module.starts_with(folder);
        let mut families: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
        for (module, text) in self.texts.iter().filter(|(module, _)| is_inside(module)) {
            let imports = families.entry(module[depth].clone()).or_default();
            let used = uses(text).into_iter().map(|(_, path)| path).chain(paths(text));
            for path in used.filter_map(|path| self.absolute(module, &path)) {
                let target = self.target(&path);
                if is_inside(&target) && target[depth] != module[depth] {
                    let tie = format!("{} -> {}", module.join("::"), path.join("::"));
                    imports.insert(target[depth].clone(), tie);
                }
            }
        }
        families
    }
}

/// A circle, as the imports that form it.
fn circle(families: &BTreeMap<String, BTreeMap<String, String>>) -> Option<Vec<String>> {
    let mut left: BTreeSet<&String> = families.keys().collect();
    loop {
        let free: Vec<&String> = left
            .iter()
            .filter(|family| families[**family].keys().all(|used| !left.contains(used)))
            .copied()
            .collect();
        if free.is_empty() {
            break;
        }
        free.iter().for_each(|family| {
            left.remove(*family);
        });
    }
    // Every module that is left imports one that is left, so a walk along the imports returns.
    let mut at = *left.iter().next()?;
    let mut walked: Vec<(&String, String)> = Vec::new();
    while !walked.iter().any(|(family, _)| *family == at) {
        let (next, tie) = families[at].iter().find(|(used, _)| left.contains(used))?;
        walked.push((at, tie.clone()));
        at = next;
    }
    let ties = walked.into_iter().skip_while(|(family, _)| *family != at);
    Some(ties.map(|(_, tie)| tie).collect())
}

#[test]
fn modules_import_each_other_without_circles() {
    let crates = super::crates().into_iter().map(|name| format!("crates/{name}/src"));
    for src in crates.chain(["benches/src", "fuzz/src", "python/src"].map(str::to_owned)) {
        let modules = Crate::read(&src);
        for folder in modules.folders() {
            let families = modules.families(&folder);
            if folder.is_empty() && families.len() > 3 {
                assert!(
                    families.values().any(|used| !used.is_empty()),
                    "{src}: no import was found"
                );
            }
            let place = [std::slice::from_ref(&src), folder.as_slice()].concat().join("/");
            let circle = circle(&families);
            assert!(circle.is_none(), "{place}: these imports are a circle: {circle:#?}");
        }
    }
}

#[test]
fn circles_are_found_inside_of_folders() {
    let texts = [
        ("", "mod a;"),
        ("a", "mod b; mod c; pub use b::Shared; use c::call;"),
        ("a::b", "use super::c::d::One; pub struct Shared;"),
        ("a::c", "mod d; use super::Shared;"),
        ("a::c::d", "pub struct One;"),
    ];
    let module = |path: &str| -> Module {
        path.split("::").filter(|name| !name.is_empty()).map(str::to_owned).collect()
    };
    let texts = texts.map(|(path, text)| (module(path), text.to_owned()));
    let modules = Crate::of(texts.into_iter().collect());
    let folders = BTreeSet::from(["", "a", "a::c"].map(module));
    assert_eq!(modules.folders(), folders);
    let circles = folders.iter().map(|folder| circle(&modules.families(folder)));
    let circles: Vec<Option<Vec<String>>> = circles.collect();
    // A folder that uses items of the module above it, and the module that uses the folder, form no
    // circle.
    let ties = ["a::b -> a::c::d::One", "a::c -> a::Shared"].map(str::to_owned).to_vec();
    assert_eq!(circles, [None, Some(ties), None]);
}

#[test]
fn imports_are_read_as_the_compiler_does() {
    let tree = "use super::{a::{B, c}, d as e};\npub use crate::x::Y;\nlet use_it = f(g::h(1));";
    let expected = ["super::a::B", "super::a::c", "super::d", "crate::x::Y"];
    assert_eq!(uses(tree).into_iter().map(|u| u.1).collect::<Vec<_>>(), expected);
    assert_eq!(uses(tree).iter().map(|u| u.0).collect::<Vec<_>>(), [false, false, false, true]);
    assert!(paths(tree).contains(&"g::h".to_owned()));
    let family = |used: &[&str]| used.iter().map(|u| ((*u).to_owned(), (*u).to_owned())).collect();
    let straight = [("a", family(&["b", "c"])), ("b", family(&["c"])), ("c", family(&[]))];
    let straight = straight.map(|(name, used)| (name.to_owned(), used)).into_iter().collect();
    assert_eq!(circle(&straight), None);
    let mut round: BTreeMap<_, _> = straight;
    round.insert("c".to_owned(), family(&["a"]));
    assert_eq!(circle(&round).map(|ties| ties.len()), Some(3));
}
