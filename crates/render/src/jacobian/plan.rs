//! What is asked, looked up once: which sum the derivative by each parameter of each group and
//! source goes to, and how each group is evaluated.

use super::Parameter;
use crate::bsdf::{Bsdf, Specular};
use crate::path::Vertex;
use crate::tracer::{Appearance, Tracer};
use glam::Vec3;
use unrender_scene::{BrdfModel, Material, Rgb};

/// The slot of what nobody asked for.
pub(super) const NONE: u32 = u32::MAX;

/// Reflectances below this, if asked for, are sampled as if they were this.
const DRAWN_MIN: f32 = 0.05;

/// Where everything goes.
pub(super) struct Plan<'a> {
    pub(super) appearance: Appearance<'a>,
    /// For each parameter asked for: its slot among the sums.
    pub(super) slots: Vec<u32>,
    /// The number of slots.
    pub(super) count: usize,
    pub(super) groups: Vec<GroupPlan<'a>>,
    lights: Vec<u32>,
    /// The slot of the cache's factor.
    pub(super) seen: u32,
}

/// One group, ready to be evaluated.
pub(super) struct GroupPlan<'a> {
    pub(super) material: &'a Material,
    /// Its specular part, also where `rho_s` is zero but asked for.
    pub(super) specular: Specular,
    /// Sine and cosine of the angle from the brushed direction that paths are drawn by to its own.
    turn: Option<(f32, f32)>,
    /// The slots of rho_d, rho_s, alpha_x, alpha_y and theta.
    pub(super) slots: [u32; 5],
    /// Whether any of them is asked for.
    pub(super) asked: bool,
}

impl<'a> Plan<'a> {
    pub(super) fn new(
        tracer: &Tracer,
        appearance: Appearance<'a>,
        sampled_as: Appearance<'_>,
        parameters: &[Parameter],
    ) -> Self {
        let pairs = appearance.materials.iter().zip(sampled_as.materials).enumerate();
        let group = |(index, (material, drawn)): (usize, (&'a Material, &Material))| {
            let asked = parameters.contains(&Parameter::RhoS(index as u32));
            GroupPlan::new(tracer.model, material, asked, material.theta_rad - drawn.theta_rad)
        };
        let mut plan = Self {
            appearance,
            slots: Vec::with_capacity(parameters.len()),
            count: 0,
            groups: pairs.map(group).collect(),
            lights: vec![NONE; tracer.emitters.source_count()],
            seen: NONE,
        };
        for parameter in parameters {
            let slot = plan.slot(*parameter);
            plan.slots.push(slot);
        }
        plan
    }

    /// The slot of a parameter, which is asked for; the same one if it is asked for twice.
    fn slot(&mut self, parameter: Parameter) -> u32 {
        let next = self.count as u32;
        let mut of_nothing = NONE;
        let entry = self.entry(parameter).unwrap_or(&mut of_nothing);
        if *entry != NONE {
            return *entry;
        }
        *entry = next;
        self.count += 1;
        next
    }

    /// Where the slot of a parameter is kept; nowhere if its group does not exist.
    fn entry(&mut self, parameter: Parameter) -> Option<&mut u32> {
        let (group, kind) = match parameter {
            Parameter::RhoD(group) => (group, 0),
            Parameter::RhoS(group) => (group, 1),
            Parameter::AlphaX(group) => (group, 2),
            Parameter::AlphaY(group) => (group, 3),
            Parameter::Theta(group) => (group, 4),
            Parameter::Light(source) => return self.lights.get_mut(source as usize),
            Parameter::Seen => return Some(&mut self.seen),
        };
        let group = self.groups.get_mut(group as usize)?;
        group.asked = true;
        Some(&mut group.slots[kind])
    }

    /// The slot of a source's brightness.
    #[inline]
    pub(super) fn light(&self, source: u32) -> u32 {
        self.lights.get(source as usize).copied().unwrap_or(NONE)
    }
}

impl<'a> GroupPlan<'a> {
    fn new(model: BrdfModel, material: &'a Material, specular_asked: bool, angle: f32) -> Self {
        let rho_s = if specular_asked { Rgb::ONE } else { material.rho_s };
        let shape = Material { rho_s, texture: None, ..material.clone() };
        Self {
            material,
            specular: Bsdf::new(&shape, Rgb::ZERO, model).specular,
            turn: (angle != 0.0).then(|| angle.sin_cos()),
            slots: [NONE; 5],
            asked: false,
        }
    }

    /// The diffuse reflectance at a vertex.
    #[inline]
    pub(super) fn rho_d(&self, at: &Vertex<'_>) -> Rgb {
        self.material.rho_d_at(at.surface.uv)
    }

    /// A direction of the brushed frame that paths are drawn in, in the group's own.
    #[inline]
    pub(super) fn turned(&self, v: Vec3) -> Vec3 {
        match self.turn {
            None => v,
            Some((sin, cos)) => Vec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z),
        }
    }
}

/// The materials that paths are drawn by: those given, but where a reflectance is asked for and
/// nearly zero, one that sends some of the paths where it would reflect.
pub(super) fn drawn(materials: &[Material], parameters: &[Parameter]) -> Vec<Material> {
    let mut drawn = materials.to_vec();
    for parameter in parameters {
        let (Parameter::RhoD(group) | Parameter::RhoS(group)) = *parameter else { continue };
        let Some(material) = drawn.get_mut(group as usize) else { continue };
        let rho = match parameter {
            Parameter::RhoD(_) if material.texture.is_none() => &mut material.rho_d,
            Parameter::RhoS(_) => &mut material.rho_s,
            _ => continue,
        };
        if rho.max_element() < DRAWN_MIN {
            *rho = Rgb::splat(DRAWN_MIN);
        }
    }
    drawn
}
