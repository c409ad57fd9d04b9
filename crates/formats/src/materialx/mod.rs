//! MaterialX files (`.mtlx`) as the materials of a scene's groups.
//!
//! A `surfacematerial` with one of the shaders of `surface` is a material. A group takes the material of its name: of the
//! material itself, of the `doc` that the exporter gives its shader, or of a `materialassign` whose geometry ends in the
//! name of the group or of one of its objects. MaterialX's names are identifiers, so that "Car Paint" is `Car_Paint` too.

mod document;
mod graph;
mod inputs;
mod picture;
mod rows;
mod surface;

use crate::input::Scope;
use crate::record::Note;
use crate::{FileError, Input, relief};
use document::{Names, Xml};
use glam::DVec3;
use inputs::Inputs;
pub(crate) use rows::tables;
use std::collections::BTreeMap;
use std::path::Path;
use surface::{SHADERS, Surface};
use unrender_scene::{BrdfModel, Detail, Material, Scene, Warnings};

/// The most materials that a message names: a line of a terminal. Half of it would hide the one that is meant, double of
/// it fills the screen.
const NAMED: usize = 12;

/// A material of the file.
struct Named<'a> {
    name: &'a str,
    /// The names of groups and objects that have it.
    also: Vec<String>,
    shader: Option<Xml<'a>>,
    /// The exact numbers, if the file was exported by this program.
    exact: Option<(Material, BrdfModel)>,
}

/// A file that is open.
struct Open<'s, 'a> {
    input: Input<'s>,
    scope: &'s Scope,
    names: Names<'a>,
    materials: Vec<Named<'a>>,
}

/// What `used` makes of the file of `input`; its warnings begin with the name of the file.
fn opened(
    input: Input<'_>,
    used: impl FnOnce(&Open, &mut Warnings) -> Result<(), String>,
) -> Result<Warnings, FileError> {
    let scope = Scope::new(input);
    let fault = |problem: String| FileError::new(input.path, problem);
    let text = scope.text(input.path).map_err(fault)?;
    let document = document::parse(&scope, &text).map_err(fault)?;
    let names = Names::of(document.root_element());
    let materials = materials(&names, document.root_element());
    let open = Open { input, scope: &scope, names, materials };
    let mut warnings = Warnings::default();
    used(&open, &mut warnings).map_err(|problem| fault(problem).after(&warnings))?;
    let name = input.path.display();
    Ok(Warnings(warnings.0.into_iter().map(|warning| format!("{name}: {warning}")).collect()))
}

/// Gives the groups of `scene` the materials of the file of `input` that have their names. Groups without one stay as they
/// are.
///
/// # Errors
/// If the file cannot be read, is no MaterialX, or has no material of a group.
pub fn apply<'a>(input: impl Into<Input<'a>>, scene: &mut Scene) -> Result<Warnings, FileError> {
    opened(input.into(), |open, warnings| {
        let exact = open.materials.iter().find_map(|material| material.exact.as_ref());
        if let Some((_, model)) = exact {
            scene.brdf = scene.brdf.renamed(*model);
            if !scene.brdf.is_principled() {
                scene.free();
            }
        }
        let (mut named, mut used) = (0, 0);
        for index in 0..scene.groups.len() {
            let Some(material) = of_group(&open.materials, scene, index) else { continue };
            named += 1;
            let Some(found) = open.read(material, scene.brdf, warnings) else { continue };
            used += 1;
            give(scene, index, found);
        }
        if used == 0 && named > 0 {
            return Err("has no material of a group with a shader that is read".into());
        }
        if used == 0 {
            let groups = listed(scene.groups.iter().map(|group| group.name.as_str()));
            let own = open.listed();
            return Err(format!(
                "has no material of a group: its materials are {own}, the groups {groups}; name them alike"
            ));
        }
        Ok(())
    })
}

/// Gives the group at `index` in `scene` the material of the file of `input` that is called `name`, or, without one, that
/// which has the name of the group. The scene keeps its BRDF model.
///
/// # Errors
/// If the file cannot be read, is no MaterialX, or has no such material.
pub fn apply_to<'a>(
    input: impl Into<Input<'a>>,
    scene: &mut Scene,
    (index, name): (usize, Option<&str>),
) -> Result<Warnings, FileError> {
    opened(input.into(), |open, warnings| {
        let named = |name: &str| open.materials.iter().find(|material| material.name == name);
        let material = match name {
            Some(name) => named(name),
            None => of_group(&open.materials, scene, index),
        };
        let wanted = name.unwrap_or(&scene.groups[index].name);
        let material = material.ok_or_else(|| {
            format!("has no material \"{wanted}\"; its materials are {}", open.listed())
        })?;
        let found = open.read(material, scene.brdf, warnings);
        let found = found.ok_or_else(|| format!("has no shader that is read for \"{wanted}\""))?;
        give(scene, index, found);
        Ok(())
    })
}

impl Open<'_, '_> {
    /// The names of its materials, for messages.
    fn listed(&self) -> String {
        listed(self.materials.iter().map(|material| material.name))
    }
}

fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    let shown = names.iter().take(NAMED).map(|name| format!("\"{name}\"")).collect::<Vec<_>>();
    let more = names.len().saturating_sub(NAMED);
    match (shown.is_empty(), more) {
        (true, _) => "none".into(),
        (_, 0) => shown.join(", "),
        (_, more) => format!("{} and {more} more", shown.join(", ")),
    }
}

/// The materials of the file.
fn materials<'a>(names: &Names<'a>, root: Xml<'a>) -> Vec<Named<'a>> {
    let mut found = Vec::new();
    let mut assigned = assigned(root);
    for element in root.children().filter(|child| child.has_tag_name("surfacematerial")) {
        let Some(name) = element.attribute("name") else { continue };
        let shader =
            names.input(element, "surfaceshader").and_then(|input| input.attribute("nodename"));
        let shader = shader.and_then(|name| names.find(root, name));
        let note = shader.and_then(note);
        let mut also = assigned.remove(name).unwrap_or_default();
        also.extend(note.as_ref().and_then(|note| note.name.clone()));
        let doc = shader.and_then(|shader| shader.attribute("doc"));
        also.extend(doc.map(|doc| serde_json::from_str(doc).unwrap_or_else(|_| doc.to_owned())));
        let exact = note.and_then(|note| note.material);
        found.push(Named { name, also, shader, exact });
    }
    found
}

/// Our comment in front of `shader`.
fn note(shader: Xml) -> Option<Note> {
    let mut before = shader.prev_siblings().skip(1);
    let comment = before.find(|node| !node.is_text())?;
    let text = comment.text().filter(|_| comment.is_comment())?;
    Note::parse(text, DVec3::ZERO)
}

/// The names to which looks assign each material: the last part of each path, and the `doc`.
fn assigned(root: Xml) -> BTreeMap<String, Vec<String>> {
    let mut all: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let assigns = root.descendants().filter(|element| element.has_tag_name("materialassign"));
    for assign in assigns {
        let Some(material) = assign.attribute("material") else { continue };
        let names = all.entry(material.to_owned()).or_default();
        let paths = assign.attribute("geom").unwrap_or("").split(',');
        names.extend(paths.filter_map(|path| path.trim().rsplit('/').next()).map(str::to_owned));
        let doc = assign.attribute("doc");
        names.extend(doc.map(|doc| serde_json::from_str(doc).unwrap_or_else(|_| doc.to_owned())));
    }
    all
}

/// The material of group `index`: by its own name, then by a plain one, then by its objects.
fn of_group<'m, 'a>(
    materials: &'m [Named<'a>],
    scene: &Scene,
    index: usize,
) -> Option<&'m Named<'a>> {
    let name = scene.groups[index].name.as_str();
    let plain = |name: &str| -> String {
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
    };
    let objects = scene.objects.iter().filter(|object| object.group == index);
    let objects: Vec<&str> = objects.map(|object| object.name.as_str()).collect();
    let by = |is: &dyn Fn(&Named) -> bool| materials.iter().find(|material| is(material));
    by(&|m| m.name == name)
        .or_else(|| by(&|m| m.also.iter().any(|also| also == name)))
        .or_else(|| by(&|m| m.name == plain(name)))
        .or_else(|| by(&|m| m.also.iter().any(|also| objects.contains(&also.as_str()))))
}

impl Open<'_, '_> {
    /// The surface of `named`; none if its shader is not read.
    fn read(&self, named: &Named, model: BrdfModel, warnings: &mut Warnings) -> Option<Surface> {
        let material = named.name;
        let Some(shader) = named.shader else {
            warnings
                .push(format!("material \"{material}\" has no surface shader and was left out"));
            return None;
        };
        let tag = shader.tag_name().name();
        let Some(kind) = SHADERS.iter().find(|kind| kind.tag == tag) else {
            warnings.push(format!(
                "material \"{material}\" has the shader <{tag}> and was left out; standard_surface, open_pbr_surface and \
                 gltf_pbr are read"
            ));
            return None;
        };
        let folder = self.input.path.parent().unwrap_or(Path::new(""));
        let (input, scope, names) = (self.input, self.scope, &self.names);
        let mut inputs = Inputs { input, scope, folder, names, shader, material, warnings };
        let Some((exact, _)) = &named.exact else { return Some(kind.surface(&mut inputs, model)) };
        // What the shader cannot say is no news.
        let mut silent = Warnings::default();
        let found = kind.surface(&mut Inputs { warnings: &mut silent, ..inputs }, model);
        let exact = if model.is_principled() { exact.clone() } else { exact.clone().freed() };
        let texture = found.material.texture;
        Some(Surface { material: Material { texture, ..exact }, ..found })
    }
}

/// Gives group `index` its surface.
fn give(scene: &mut Scene, index: usize, found: Surface) {
    scene.groups[index].material = found.material;
    let Some(normals) = found.normals else { return };
    for object in scene.objects.iter_mut().filter(|object| object.group == index) {
        let detail = Detail { normals: Some(normals.clone()), ..object.mesh.detail.clone() };
        relief::give(&mut object.mesh, &detail);
    }
}
