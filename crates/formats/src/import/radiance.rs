//! Radiance scenes (`.rad`): what our own export writes, exactly, and the common primitives.
//!
//! Surfaces: `polygon`, round ones (`sphere`, `cylinder`, `cone`, `ring` and those inside out), and `mesh`
//! if the OBJ from which it was compiled lies beside it. Materials, mixtures and aliases: see
//! `materials.rs` and `reflectance.rs`. Lights: surfaces of `light`, `glow` and `illum` shine, a
//! `spotlight` is a spot light; a narrow `source` is a directional light, wide ones are the environment.
//! Commands: `xform`, `cat`, `genbox`, `genprism` and `gensky` are carried out here; no program is ever
//! run, and others are refused. The camera is that of `view.vf`, or of the scene's name and `.vf`, if there
//! is such a file. Warnings name what is approximated or left out, with its line. ["The RADIANCE 5.4
//! Synthetic Imaging System" (reference manual), section 2.1]

mod files;
mod generators;
mod gensky;
mod kinds;
mod lamps;
mod materials;
mod meshes;
mod modifiers;
mod motion;
mod patterns;
mod primitives;
mod reflectance;
mod shell;
mod sky;
mod surfaces;
mod view;
mod words;
mod xform;

use super::shapes;
use crate::FileError;
use crate::entry::{Table, Taken};
use crate::input::{Input, Scope};
use crate::names::unique;
use crate::record::Note;
use glam::DVec3;
use kinds::Sort;
use lamps::Lamps;
use materials::{Materials, Seen};
use meshes::Meshes;
use primitives::{Noted, Primitive};
use std::collections::BTreeMap;
use std::path::Path;
use surfaces::{brush, polygon, round};
use unrender_scene::{Group, Mesh, Object, Scene, Ungrouped, Warnings};

/// What is read of Radiance's scenes, commands and views.
pub(crate) fn tables() -> Vec<Table> {
    vec![
        Table::new("Radiance: primitives", "kind", kinds::entries().chain(&kinds::CASES)),
        Table::new("Radiance: commands", "program", &files::PROGRAMS),
        Table::new("Radiance: view files", "option", &view::OPTIONS),
    ]
}

/// Reads the scene at `path` with the files that it names; it is not yet validated: see
/// [`load_scene`](crate::load_scene).
///
/// # Errors
/// If a file is missing or damaged, if a modifier is missing, or if a command or a lamp is not understood.
pub fn read<'a>(input: impl Into<Input<'a>>) -> Result<(Scene, Warnings), FileError> {
    let input = input.into();
    let mut warnings = Warnings::default();
    let scene = scene(input, &mut warnings)
        .map_err(|problem| FileError::new(input.path, problem).after(&warnings))?;
    Ok((scene, warnings))
}

fn scene(input: Input<'_>, warnings: &mut Warnings) -> Result<Scene, String> {
    let path = input.path;
    let scope = Scope::new(input);
    let folder = path.parent().unwrap_or(Path::new(""));
    let primitives = files::read(&scope, path, warnings)?;
    let mut reader = Reader {
        place: (&scope, folder),
        materials: Materials::new((&scope, folder)),
        meshes: Meshes::default(),
        objects: Vec::new(),
        ungrouped: Vec::new(),
        lamps: Lamps::default(),
        warnings,
    };
    for noted in primitives {
        let place = noted.primitive.place.clone();
        reader.primitive(noted).map_err(|problem| format!("{place}: {problem}"))?;
    }
    let mut scene = reader.finished()?;
    scene.glass_told().into_iter().for_each(|told| warnings.push(told));
    scene.cameras.extend(view::beside(&scope, path, warnings)?);
    Ok(scene)
}

/// An object in the making: the meshes of one name and one material.
struct ObjectMeshes {
    name: String,
    group: usize,
    /// The direction of its highlights in the world.
    along: Option<DVec3>,
    meshes: Vec<Mesh>,
}

struct Reader<'a> {
    /// The limits of reading the scene, and its folder.
    place: (&'a Scope, &'a Path),
    materials: Materials<'a>,
    meshes: Meshes,
    objects: Vec<ObjectMeshes>,
    ungrouped: Vec<Ungrouped>,
    lamps: Lamps,
    warnings: &'a mut Warnings,
}

impl Reader<'_> {
    fn primitive(&mut self, noted: Noted) -> Result<(), String> {
        let noted = noted.counted_from(self.place.0.origin());
        let Noted { primitive, note } = &noted;
        if let Some(light) = note.as_ref().and_then(|note| note.light.clone()) {
            // The primitives that follow only repeat it in Radiance's words.
            if note.as_ref().is_some_and(|note| note.is_first) {
                self.lamps.lights.push(light);
            }
            return Ok(());
        }
        match primitive.kind.as_str() {
            "polygon" => {
                // Our export adds backs to mirrors.
                if note.is_some() && primitive.id.ends_with(".back") {
                    return Ok(());
                }
                self.surface(primitive, note.as_ref(), polygon(primitive)?)
            }
            "mesh" => self.mesh(primitive, note.as_ref()),
            "source" => self.far(primitive),
            kind if kinds::entry(kind).is_some_and(|entry| entry.taken == Taken::Refused) => {
                let why = kinds::entry(kind).map_or("", |entry| entry.done);
                Err(format!("{} {why}", primitive.named()))
            }
            kind if kinds::kind(kind).map(|kind| kind.sort) == Some(Sort::Surface) => {
                self.surface(primitive, note.as_ref(), round(primitive)?)
            }
            _ => self.materials.define(noted, self.warnings),
        }
    }

    fn surface(&mut self, p: &Primitive, note: Option<&Note>, mesh: Mesh) -> Result<(), String> {
        self.place.0.charge(shapes::bytes_of(&mesh))?;
        self.tell_words(p);
        let modifier = self.materials.modifiers.find(&p.modifier);
        let modifier = modifier.map_err(|problem| format!("{} {problem}", p.named()))?;
        let Some(modifier) = modifier else {
            self.warnings.push(format!(
                "{}: {} has no material (void) and is invisible; it was left out",
                p.place,
                p.named()
            ));
            return Ok(());
        };
        let seen = self.materials.seen(modifier, self.warnings);
        match seen.map_err(|problem| format!("{}: {problem}", p.named()))? {
            Seen::Nothing => Ok(()),
            Seen::Spot(spot) => self.lamps.spot(&p.id, spot, mesh),
            Seen::Glass(material, glass) => {
                self.ungrouped.push(Ungrouped { material, mesh, glass: Some(glass) });
                Ok(())
            }
            Seen::Group(group, along) => {
                self.add(p, note, group, along, mesh);
                Ok(())
            }
        }
    }

    /// Adds `mesh` to the object that it belongs to.
    fn add(
        &mut self,
        p: &Primitive,
        note: Option<&Note>,
        group: usize,
        along: Option<DVec3>,
        mesh: Mesh,
    ) {
        let name = note.and_then(|note| note.name.clone()).unwrap_or_else(|| p.id.clone());
        let starts = note.is_none_or(|note| note.is_first);
        let goes_on = |o: &&mut ObjectMeshes| {
            !starts && o.name == name && o.group == group && o.along == along
        };
        match self.objects.last_mut().filter(goes_on) {
            Some(part) => part.meshes.push(mesh),
            None => self.objects.push(ObjectMeshes { name, group, along, meshes: vec![mesh] }),
        }
    }

    fn tell_words(&mut self, p: &Primitive) {
        if p.kind != "mesh" && !p.strings.is_empty() {
            self.warnings.push(format!("{}: the words of {} are not read", p.place, p.named()));
        }
    }

    /// A compiled mesh, read from its OBJ.
    fn mesh(&mut self, p: &Primitive, note: Option<&Note>) -> Result<(), String> {
        let (source, is_there) = meshes::source(p, self.place.1)?;
        if !is_there {
            self.warnings.push(format!(
                "{}: {} was left out: there is no {} beside it",
                p.place,
                p.named(),
                self.place.1.join(source).display()
            ));
            return Ok(());
        }
        let read = self.meshes.parts(p, &source, self.place, self.warnings)?;
        let mut parts: BTreeMap<String, Vec<Mesh>> = BTreeMap::new();
        for (named, mesh) in read {
            let modifier = named.filter(|_| p.modifier == "void");
            parts.entry(modifier.unwrap_or_else(|| p.modifier.clone())).or_default().push(mesh);
        }
        for (number, (modifier, meshes)) in parts.into_iter().enumerate() {
            let mesh = shapes::joined(meshes.into_iter());
            let is_first = note.is_some_and(|note| note.is_first) && number == 0;
            let note = note.map(|note| Note { is_first, ..note.clone() });
            self.surface(&Primitive { modifier, ..p.clone() }, note.as_ref(), mesh)?;
        }
        Ok(())
    }

    /// A disk infinitely far away.
    fn far(&mut self, p: &Primitive) -> Result<(), String> {
        self.tell_words(p);
        let modifier = self.materials.modifiers.find(&p.modifier);
        let modifier = modifier.map_err(|problem| format!("{} {problem}", p.named()))?;
        let far = modifier.map(|modifier| self.materials.far(modifier, self.warnings));
        match far.transpose()?.flatten() {
            Some(far) => self.lamps.far(&p.id, p.reals()?, far),
            None => {
                self.warnings.push(format!(
                    "{}: {} gives no light and was left out",
                    p.place,
                    p.named()
                ));
                Ok(())
            }
        }
    }

    /// The scene, with the groups that objects use, each with a name of its own.
    fn finished(self) -> Result<Scene, String> {
        let groups = self.materials.groups(self.objects.iter().map(|o| o.group));
        let wanted: Vec<String> = groups.iter().map(|(_, group)| group.name.clone()).collect();
        let names = unique(&wanted, self.warnings);
        let places: BTreeMap<usize, usize> =
            groups.iter().enumerate().map(|(place, (index, _))| (*index, place)).collect();
        let (brdf, ungrouped) = (self.materials.brdf(), self.ungrouped);
        let mut scene = Scene { brdf, ungrouped, ..Scene::default() };
        for part in self.objects {
            let group = places.get(&part.group).copied().unwrap_or(0);
            let mut mesh = shapes::joined(part.meshes.into_iter());
            if let Some(along) = part.along {
                brush(&mut mesh, along);
            }
            scene.objects.push(Object { name: part.name, group, mesh });
        }
        scene.groups = groups
            .into_iter()
            .zip(names)
            .map(|((_, group), name)| Group { name, ..group })
            .collect();
        (scene.lights, scene.environment) = self.lamps.finished(&scene.objects, self.warnings)?;
        Ok(scene)
    }
}
