//! Meshes compiled by `obj2mesh`, read from the OBJ files that they were made from.

use super::motion::Motion;
use super::primitives::Primitive;
use crate::import::shapes;
use crate::input::Scope;
use crate::obj::{self, Named};
use glam::{DVec3, Vec3};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use unrender_scene::{Mesh, Warnings};

/// The parts of a mesh, each with the modifier that the file gives it, or else that of the first part that has
/// one.
type Parts = Rc<Vec<Named>>;

/// The meshes that were read, by their file and the origin in their own coordinates.
#[derive(Default)]
pub(super) struct Meshes(BTreeMap<(PathBuf, [u64; 3]), Parts>);

/// The OBJ of a mesh, seen from the folder of the scene, and whether it exists.
pub(super) fn source(p: &Primitive, folder: &Path) -> Result<(PathBuf, bool), String> {
    let compiled = p.strings.first().ok_or("a mesh names no file")?;
    let source = Path::new(compiled).with_extension("obj");
    let is_there = folder.join(&source).exists();
    Ok((source, is_there))
}

impl Meshes {
    /// The parts of the mesh `p`, made from `source`, in their places in the scene, each with its modifier.
    pub(super) fn parts(
        &mut self,
        p: &Primitive,
        source: &Path,
        (scope, folder): (&Scope, &Path),
        warnings: &mut Warnings,
    ) -> Result<Vec<Named>, String> {
        let motion = Motion::of_all(p.strings.get(1..).unwrap_or_default())
            .map_err(|problem| format!("{}: {problem}", p.named()))?;
        let (matrix, origin) = (motion.matrix(), scope.origin());
        let mut read = |zero| self.counted_from(zero, source, (scope, folder), warnings);
        let (mut parts, mut zero) = (read(DVec3::ZERO)?, DVec3::ZERO);
        // Meshes near their own zero are read once, however often they are placed.
        if origin != DVec3::ZERO && is_far(&parts) {
            zero = shapes::in_mesh(origin, &matrix);
            parts = read(zero)?;
        }
        let here = shapes::here_from_mesh(&matrix, zero, origin);
        let moved = |mesh: &Mesh| -> Result<Mesh, String> {
            scope.charge(shapes::bytes_of(mesh))?;
            Ok(shapes::moved(mesh.clone(), &here))
        };
        parts.iter().map(|(name, mesh)| Ok((name.clone(), moved(mesh)?))).collect()
    }

    fn counted_from(
        &mut self,
        zero: DVec3,
        source: &Path,
        place: (&Scope, &Path),
        warnings: &mut Warnings,
    ) -> Result<Parts, String> {
        let key = (source.to_owned(), zero.to_array().map(f64::to_bits));
        if let Some(parts) = self.0.get(&key) {
            return Ok(parts.clone());
        }
        let parts = Rc::new(read(source, place, zero, warnings)?);
        self.0.insert(key, parts.clone());
        Ok(parts)
    }
}

/// Whether meshes are farther from their zero than twice their size.
fn is_far(parts: &[Named]) -> bool {
    let positions = || parts.iter().flat_map(|(_, mesh)| mesh.positions.iter().copied());
    let (low, high) = (positions().reduce(Vec3::min), positions().reduce(Vec3::max));
    let (low, high) = (low.unwrap_or_default(), high.unwrap_or_default());
    low.abs().max(high.abs()).max_element() > 2.0 * low.distance(high)
}

fn read(
    source: &Path,
    (scope, folder): (&Scope, &Path),
    zero: DVec3,
    warnings: &mut Warnings,
) -> Result<Vec<Named>, String> {
    let path = scope
        .beside(folder, &source.to_string_lossy())
        .map_err(|problem| format!("{} {problem}", source.display()))?;
    let (mut parts, told) = obj::read_in(scope, &path, zero).map_err(|error| error.to_string())?;
    warnings.extend(told);
    let first = parts.iter().find_map(|(name, _)| name.clone());
    parts.iter_mut().for_each(|(name, _)| *name = name.take().or_else(|| first.clone()));
    Ok(parts)
}
