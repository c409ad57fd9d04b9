//! The definitions so far, and what a name stands for: materials, patterns and textures, one
//! modifying the other.

use super::kinds::{Sort, kind};
use super::primitives::{Noted, Place, Primitive};
use crate::record::Note;
use std::collections::BTreeMap;
use std::rc::Rc;

/// The longest chain of modifiers; scenes have a handful.
const DEPTH: usize = 64;

/// The number of a definition.
pub(super) type Number = usize;

/// A modifier.
pub(super) struct Definition {
    /// Its kind and arguments; those of the original for an alias.
    pub(super) made: Rc<Primitive>,
    pub(super) id: String,
    pub(super) place: Place,
    pub(super) note: Option<Note>,
    /// What modifies it.
    modifier: Option<Number>,
    /// The modifiers that its words name, in order: two for mixtures, one for others.
    pub(super) named: Vec<Option<Number>>,
    /// Whether a material is among its words or behind it.
    has_material: bool,
}

impl Definition {
    pub(super) fn sort(&self) -> Option<Sort> {
        kind(&self.made.kind).map(|kind| kind.sort)
    }

    /// Its kind and name, for messages.
    pub(super) fn shown(&self) -> String {
        format!("the {} \"{}\"", self.made.kind, self.id)
    }
}

/// The modifiers of a surface: one material, and patterns and textures before and behind it.
#[derive(Default)]
pub(super) struct Chain {
    pub(super) material: Option<Number>,
    pub(super) others: Vec<Number>,
}

/// All of them.
#[derive(Default)]
pub(super) struct Modifiers {
    all: Vec<Definition>,
    /// From an identifier to what it means now: the latest definition.
    by_id: BTreeMap<String, Number>,
}

impl Modifiers {
    pub(super) fn get(&self, number: Number) -> &Definition {
        &self.all[number]
    }

    /// What `id` means now; nothing for `void`.
    pub(super) fn find(&self, id: &str) -> Result<Option<Number>, String> {
        if id == "void" {
            return Ok(None);
        }
        let found = self.by_id.get(id).copied();
        found.map(Some).ok_or_else(|| {
            let advice = if id == "inherit" { "; only an alias inherits" } else { "" };
            format!("is made of \"{id}\", which is not there{advice}")
        })
    }

    /// Adds the modifier `noted`.
    pub(super) fn define(&mut self, noted: Noted) -> Result<(), String> {
        let Noted { primitive, note } = noted;
        let (id, place) = (primitive.id.clone(), primitive.place.clone());
        let definition = if kind(&primitive.kind).map(|kind| kind.sort) == Some(Sort::Alias) {
            self.alias(&primitive)?
        } else {
            let shown = primitive.named();
            let modifier =
                self.find(&primitive.modifier).map_err(|problem| format!("{shown} {problem}"))?;
            let named = self.named(&primitive);
            let has_material = self.has_material(&primitive, modifier, &named);
            let made = Rc::new(primitive);
            Definition { made, id: id.clone(), place, note, modifier, named, has_material }
        };
        // Radiance, too, keeps the former definition if the new one is the same.
        let before = self.by_id.get(&id).map(|number| &self.all[*number]);
        if !before.is_some_and(|before| same(before, &definition)) {
            self.by_id.insert(id, self.all.len());
            self.all.push(definition);
        }
        Ok(())
    }

    /// The original under another name, and behind another modifier unless it inherits that, too.
    fn alias(&self, p: &Primitive) -> Result<Definition, String> {
        let original = p.strings.first().map_or("", String::as_str);
        let number = self.find(original).ok().flatten().ok_or_else(|| {
            format!("the alias \"{}\" stands for \"{original}\", which is not there", p.id)
        })?;
        let original = &self.all[number];
        let modifier = match p.modifier.as_str() {
            "inherit" => original.modifier,
            modifier => self
                .find(modifier)
                .map_err(|problem| format!("the alias \"{}\" {problem}", p.id))?,
        };
        let note = original.note.clone().map(|note| Note { name: None, ..note });
        Ok(Definition {
            made: original.made.clone(),
            id: p.id.clone(),
            place: p.place.clone(),
            note,
            modifier,
            named: original.named.clone(),
            has_material: self.has_material(&original.made, modifier, &original.named),
        })
    }

    fn has_material(
        &self,
        p: &Primitive,
        modifier: Option<Number>,
        named: &[Option<Number>],
    ) -> bool {
        let is_in = |number: &Number| self.all[*number].has_material;
        match kind(&p.kind).map(|kind| kind.sort) {
            Some(Sort::Pattern | Sort::Texture) => modifier.as_ref().is_some_and(is_in),
            Some(Sort::Mixture) => named.iter().flatten().chain(&modifier).any(is_in),
            _ => true,
        }
    }

    /// The modifiers that the words of `p` begin with.
    fn named(&self, p: &Primitive) -> Vec<Option<Number>> {
        let count = match p.kind.as_str() {
            kind if kind.starts_with("mix") => 2,
            "illum" | "mirror" | "WGMDfunc" => 1,
            _ => 0,
        };
        p.strings.iter().take(count).map(|id| self.by_id.get(id).copied()).collect()
    }

    /// The chain of modifiers from `start` on. A mixture counts as a material.
    pub(super) fn chain(&self, start: Number) -> Result<Chain, String> {
        let (mut chain, mut next) = (Chain::default(), Some(start));
        for _ in 0..DEPTH {
            let Some(number) = next else { return Ok(chain) };
            let definition = &self.all[number];
            match definition.sort() {
                Some(Sort::Pattern | Sort::Texture) => chain.others.push(number),
                // Of patterns or textures.
                Some(Sort::Mixture) if !self.mixes_materials(definition) => {
                    chain.others.push(number)
                }
                _ if chain.material.is_none() => chain.material = Some(number),
                // Radiance ignores those behind the first.
                _ => return Ok(chain),
            }
            next = definition.modifier;
        }
        Err(format!("has more than {DEPTH} modifiers behind one another"))
    }

    fn mixes_materials(&self, mixture: &Definition) -> bool {
        mixture.named.iter().flatten().any(|number| self.all[*number].has_material)
    }
}

/// Whether two definitions say the same.
fn same(one: &Definition, other: &Definition) -> bool {
    let names =
        |definition: &Definition| definition.note.as_ref().and_then(|note| note.name.clone());
    let exact =
        |definition: &Definition| definition.note.as_ref().and_then(|note| note.material.clone());
    one.made.kind == other.made.kind
        && one.made.strings == other.made.strings
        && one.made.reals == other.made.reals
        && one.modifier == other.modifier
        && one.named == other.named
        && names(one) == names(other)
        && exact(one) == exact(other)
}
