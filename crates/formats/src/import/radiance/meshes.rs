//! Meshes that `obj2mesh` has compiled, by the OBJ files that they were made from.

use super::files::text_of;
use super::motion::Motion;
use super::primitives::Primitive;
use crate::import::shapes;
use crate::input::Scope;
use crate::obj;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use unrender_scene::Mesh;

/// The parts of a mesh.
#[derive(Clone)]
pub(super) struct Parts {
    /// Each with the modifier that the file gives it.
    pub(super) list: Vec<(Option<String>, Mesh)>,
    /// Whether the file gives several modifiers that the parts do not have.
    pub(super) are_one: bool,
}

/// Those that were read, by their files.
#[derive(Default)]
pub(super) struct Meshes(BTreeMap<PathBuf, Rc<Parts>>);

/// What a mesh comes from, seen from the folder of the scene; nothing if it is not there.
pub(super) fn source(p: &Primitive, folder: &Path) -> Result<(PathBuf, bool), String> {
    let compiled = p.strings.first().ok_or("a mesh names no file")?;
    let source = Path::new(compiled).with_extension("obj");
    let is_there = folder.join(&source).exists();
    Ok((source, is_there))
}

impl Meshes {
    /// The parts of the mesh `p`, made from `source`, in their places in the scene.
    pub(super) fn parts(
        &mut self,
        p: &Primitive,
        source: &Path,
        (scope, folder): (&Scope, &Path),
    ) -> Result<Parts, String> {
        let motion = Motion::of_all(p.strings.get(1..).unwrap_or_default())
            .map_err(|problem| format!("{}: {problem}", p.named()))?;
        let parts = match self.0.get(source) {
            Some(parts) => parts.clone(),
            None => {
                let read = Rc::new(read(source, scope, folder)?);
                self.0.insert(source.to_owned(), read.clone());
                read
            }
        };
        let matrix = motion.matrix().as_affine3a();
        let moved = |mesh: &Mesh| -> Result<Mesh, String> {
            scope.charge(shapes::bytes_of(mesh))?;
            Ok(shapes::moved(mesh.clone(), matrix))
        };
        let list = parts.list.iter().map(|(name, mesh)| Ok((name.clone(), moved(mesh)?)));
        Ok(Parts { list: list.collect::<Result<_, String>>()?, ..*parts })
    }
}

fn read(source: &Path, scope: &Scope, folder: &Path) -> Result<Parts, String> {
    let named = |problem: String| format!("{} {problem}", source.display());
    let path = scope.beside(folder, &source.to_string_lossy()).map_err(named)?;
    let text = text_of(scope, &path).map_err(named)?;
    let names = text.lines().filter_map(|line| line.trim().strip_prefix("usemtl "));
    let names: BTreeSet<&str> = names.map(str::trim).collect();
    let first = text.lines().find_map(|line| line.trim().strip_prefix("usemtl ")).map(str::trim);
    let (scene, _) = obj::read_in(scope, &path).map_err(|error| error.to_string())?;
    let part = |object: unrender_scene::Object| {
        // The group is called as the material, unless the file says no more of it than its name.
        let group = &scene.groups[object.group].name;
        let name = if names.contains(group.as_str()) { Some(group.as_str()) } else { first };
        (name.map(str::to_owned), object.mesh)
    };
    let list: Vec<_> = scene.objects.into_iter().map(part).collect();
    let are_one = names.len() > 1 && list.iter().all(|(name, _)| name.as_deref() == first);
    Ok(Parts { list, are_one })
}
