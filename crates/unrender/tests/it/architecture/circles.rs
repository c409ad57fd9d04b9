//! The modules of each folder, each together with its own folder, import each other without circles. Only a module and
//! those in its folder may use each other: shared items are in the module, and the module calls those in its folder.
//!
//! Imports are found in the text: `use` items, and paths in the code. A name that a module re-exports
//! by `pub use` is followed to its definition.

use super::{read, rust_files};
use proc_macro2::{TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use syn::visit::{self, Visit};
use syn::{Attribute, ItemFn, ItemMod, ItemUse, Macro, UseTree, Visibility};

/// A module's path inside its crate; empty for its root.
type Module = Vec<String>;

/// What a module imports.
#[derive(Default)]
struct Imports {
    /// The paths of `use` items, each with whether it is handed on.
    uses: Vec<(bool, Module)>,
    /// The other paths in its code.
    paths: Vec<Module>,
}

impl Imports {
    fn of(text: &str) -> Self {
        let mut this = Self::default();
        this.visit_file(&syn::parse_file(text).unwrap());
        this
    }

    fn all(&self) -> impl Iterator<Item = &Module> {
        self.uses.iter().map(|(_, path)| path).chain(&self.paths)
    }

    fn add(&mut self, tree: &UseTree, mut path: Module, is_public: bool) {
        match tree {
            UseTree::Path(inner) => {
                path.push(inner.ident.to_string());
                return self.add(&inner.tree, path, is_public);
            }
            UseTree::Group(group) => {
                group.items.iter().for_each(|tree| self.add(tree, path.clone(), is_public));
                return;
            }
            UseTree::Name(name) => path.push(name.ident.to_string()),
            UseTree::Rename(rename) => path.push(rename.ident.to_string()),
            UseTree::Glob(_) => {}
        }
        self.uses.push((is_public, path));
    }

    /// The paths among the arguments of a macro.
    fn scan(&mut self, tokens: TokenStream) {
        let mut path = Module::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Ident(name) if path.is_empty() || colons == 2 => {
                    path.push(name.to_string());
                    colons = 0;
                    continue;
                }
                TokenTree::Punct(sign) if sign.as_char() == ':' && !path.is_empty() => {
                    colons += 1;
                    continue;
                }
                TokenTree::Group(group) => self.scan(group.stream()),
                TokenTree::Ident(_) | TokenTree::Punct(_) | TokenTree::Literal(_) => {}
            }
            self.paths.push(std::mem::take(&mut path));
            colons = 0;
        }
        self.paths.push(path);
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    let is_test = |attribute: &Attribute| {
        let names_test = attribute.parse_args::<syn::Ident>().is_ok_and(|name| name == "test");
        attribute.path().is_ident("cfg") && names_test
    };
    attributes.iter().any(is_test)
}

impl<'a> Visit<'a> for Imports {
    fn visit_item_mod(&mut self, item: &'a ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_fn(&mut self, item: &'a ItemFn) {
        if !is_test(&item.attrs) {
            visit::visit_item_fn(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'a ItemUse) {
        if !is_test(&item.attrs) {
            self.add(&item.tree, Module::new(), !matches!(item.vis, Visibility::Inherited));
        }
    }

    fn visit_path(&mut self, path: &'a syn::Path) {
        self.paths.push(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &'a Macro) {
        self.scan(call.tokens.clone());
        visit::visit_macro(self, call);
    }
}

/// The modules of the crate whose sources are in `src`, with their imports.
fn modules(src: &str) -> BTreeMap<Module, Imports> {
    let module = |path: &str| -> Module {
        let inner = path[src.len() + 1..].trim_end_matches(".rs");
        let names: Vec<String> = inner.split('/').map(str::to_owned).collect();
        match names[names.len() - 1].as_str() {
            "mod" | "lib" | "main" => names[..names.len() - 1].to_vec(),
            _ => names,
        }
    };
    rust_files(src).iter().map(|path| (module(path), Imports::of(&read(path)))).collect()
}

/// The modules of one crate and their re-exports.
struct Crate {
    modules: BTreeMap<Module, Imports>,
    /// For a module and a name: the path from which the name is re-exported.
    handed_on: BTreeMap<(Module, String), Module>,
}

impl Crate {
    fn read(src: &str) -> Self {
        Self::of(modules(src))
    }

    fn of(modules: BTreeMap<Module, Imports>) -> Self {
        let mut this = Self { modules, handed_on: BTreeMap::new() };
        for (module, imports) in &this.modules {
            for (_, path) in imports.uses.iter().filter(|(is_public, _)| *is_public) {
                if let Some(target) = this.absolute(module, path) {
                    let name = target[target.len() - 1].clone();
                    this.handed_on.insert((module.clone(), name), target);
                }
            }
        }
        this
    }

    /// `path`, as written in `module`, from the root of the crate; none if it is outside the crate.
    fn absolute(&self, module: &Module, path: &Module) -> Option<Module> {
        let mut base = module.clone();
        let mut parts = path.iter().cloned().peekable();
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
            _ if self.modules.contains_key(&child) => {}
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
            let end = (0..=path.len()).rev().find(|end| self.modules.contains_key(&path[..*end]));
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
        let inner = self.modules.keys().filter(|module| !module.is_empty());
        inner.map(|module| module[..module.len() - 1].to_vec()).collect()
    }

    /// For every module in `folder`, the modules beside it that it or its own folder imports; with the imports.
    fn families(&self, folder: &Module) -> BTreeMap<String, BTreeMap<String, String>> {
        let depth = folder.len();
        let is_inside = |module: &Module| module.len() > depth && module.starts_with(folder);
        let mut families: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
        for (module, found) in self.modules.iter().filter(|(module, _)| is_inside(module)) {
            let imports = families.entry(module[depth].clone()).or_default();
            for path in found.all().filter_map(|path| self.absolute(module, path)) {
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
    let modules = texts.map(|(path, text)| (module(path), Imports::of(text)));
    let modules = Crate::of(modules.into_iter().collect());
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
    let imports = Imports::of(
        "use super::{a::{B, c}, d as e};\npub use crate::x::Y;\n#[cfg(test)]\nmod tests { use super::t; }\n\
         fn use_it() { f(g::h(1)); assert!(k(m::n::o(2), p)); }",
    );
    let uses: Vec<(bool, String)> =
        imports.uses.iter().map(|(p, path)| (*p, path.join("::"))).collect();
    let private = ["super::a::B", "super::a::c", "super::d"].map(|path| (false, path.to_owned()));
    assert_eq!(uses[..3], private);
    assert_eq!(uses[3..], [(true, "crate::x::Y".to_owned())]);
    let paths: Vec<String> = imports.paths.iter().map(|path| path.join("::")).collect();
    assert!(["g::h", "m::n::o"].iter().all(|path| paths.iter().any(|p| p == path)), "{paths:?}");
    let family = |used: &[&str]| used.iter().map(|u| ((*u).to_owned(), (*u).to_owned())).collect();
    let straight = [("a", family(&["b", "c"])), ("b", family(&["c"])), ("c", family(&[]))];
    let straight = straight.map(|(name, used)| (name.to_owned(), used)).into_iter().collect();
    assert_eq!(circle(&straight), None);
    let mut round: BTreeMap<_, _> = straight;
    round.insert("c".to_owned(), family(&["a"]));
    assert_eq!(circle(&round).map(|ties| ties.len()), Some(3));
}
