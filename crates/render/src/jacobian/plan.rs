//! The plan of a Jacobian: the sum of each parameter of each group and light source, and how each
//! group is evaluated.

use crate::appearance::{Appearance, LightSource, SourceLayout};
use crate::bsdf::{Bsdf, Terms};
use crate::query::Parameter;
use crate::tracer::Tracer;
use crate::virtual_lamps::Passed;
use glam::Vec3;
use unrender_scene::{BrdfModel, Material, Rgb};

/// The index of a sum; none for parameters that are not asked for.
pub(super) type Slot = Option<u32>;

/// Reflectances among the parameters are sampled as if they were at least this. With half of it the
/// derivative at reflectance zero is twice as noisy; with double of it paths of dark materials
/// differ from those of a picture.
const DRAWN_MIN: f32 = 0.05;

/// The sums of a Jacobian.
pub(super) struct Plan<'a> {
    pub(super) appearance: Appearance<'a>,
    /// The slot of each parameter asked for; none if its group or light source is missing.
    pub(super) slots: Vec<Slot>,
    /// The number of sums.
    pub(super) count: usize,
    pub(super) groups: Vec<GroupPlan<'a>>,
    layout: &'a SourceLayout,
    /// By place in `layout`.
    lights: Vec<Slot>,
    /// The slot of the factor on the cache.
    pub(super) cache: Slot,
}

/// One group, prepared for evaluation.
pub(super) struct GroupPlan<'a> {
    pub(super) material: &'a Material,
    /// Its BRDF, with a specular term also where `rho_s` is zero but among the parameters.
    pub(super) bsdf: Bsdf<'static>,
    /// Sine and cosine of the angle from the anisotropy direction that paths are drawn with to its
    /// own.
    rotation: Option<(f32, f32)>,
    /// The slots of rho_d, rho_s, alpha_x, alpha_y and theta.
    pub(super) slots: [Slot; 5],
    /// Whether any of them is some.
    pub(super) asked: bool,
}

impl<'a> Plan<'a> {
    pub(super) fn new(
        tracer: &'a Tracer,
        appearance: Appearance<'a>,
        sampled_as: Appearance<'_>,
        parameters: &[Parameter],
    ) -> Self {
        let pairs = appearance.materials.iter().zip(sampled_as.materials).enumerate();
        let group = |(index, (material, drawn)): (usize, (&'a Material, &Material))| {
            let asked = parameters.contains(&Parameter::RhoS(index as u32));
            GroupPlan::new(tracer.model, material, asked, material.theta_rad - drawn.theta_rad)
        };
        let layout = tracer.emitters.layout();
        let mut plan = Self {
            appearance,
            slots: Vec::with_capacity(parameters.len()),
            count: 0,
            groups: pairs.map(group).collect(),
            layout,
            lights: vec![None; layout.count()],
            cache: None,
        };
        for parameter in parameters {
            let slot = plan.slot(*parameter);
            plan.slots.push(slot);
        }
        plan
    }

    /// Assigns a slot to a parameter; the same one if it is asked for twice.
    fn slot(&mut self, parameter: Parameter) -> Slot {
        let next = self.count as u32;
        let entry = self.entry(parameter)?;
        let is_new = entry.is_none();
        let slot = *entry.get_or_insert(next);
        self.count += usize::from(is_new);
        Some(slot)
    }

    /// The entry of a parameter's slot; none if its group or light source is missing.
    fn entry(&mut self, parameter: Parameter) -> Option<&mut Slot> {
        let (group, kind) = match parameter {
            Parameter::RhoD(group) => (group, 0),
            Parameter::RhoS(group) => (group, 1),
            Parameter::AlphaX(group) => (group, 2),
            Parameter::AlphaY(group) => (group, 3),
            Parameter::Theta(group) => (group, 4),
            Parameter::Light(source) => return self.lights.get_mut(source as usize),
            Parameter::Cache => return Some(&mut self.cache),
        };
        let group = self.groups.get_mut(group as usize)?;
        group.asked = true;
        Some(&mut group.slots[kind])
    }

    /// The slots of a light source's brightness, each with its share of it: one, or those of the parts of an
    /// environment.
    #[inline]
    pub(super) fn light(&self, source: LightSource) -> [(Slot, f32); 4] {
        let first = self.layout.index(source) as usize;
        match self.layout.corners(source) {
            None => [(self.lights[first], 1.0), (None, 0.0), (None, 0.0), (None, 0.0)],
            Some(corners) => {
                let shares = corners.shares();
                std::array::from_fn(|k| (self.lights[first + corners.pixels[k]], shares[k]))
            }
        }
    }

    /// The reflectance of a mirror that light passes, with its derivative.
    #[inline]
    pub(super) fn mirror(&self, passed: &Passed) -> Terms {
        self.groups[passed.group as usize].bsdf.mirror_terms(passed.cos)
    }

    /// The factor of the appearance on a light source's emission.
    #[inline]
    pub(super) fn brightness(&self, source: LightSource) -> Rgb {
        self.appearance.brightness(self.layout, source)
    }
}

impl<'a> GroupPlan<'a> {
    fn new(model: BrdfModel, material: &'a Material, specular_asked: bool, angle: f32) -> Self {
        let rho_s = if specular_asked { Rgb::ONE } else { material.rho_s };
        let shape = Material { rho_s, texture: None, ..material.clone() };
        let mut bsdf = Bsdf::new(&shape, Rgb::ZERO, model);
        bsdf.rho_s = material.rho_s;
        Self {
            material,
            bsdf,
            rotation: (angle != 0.0).then(|| angle.sin_cos()),
            slots: [None; 5],
            asked: false,
        }
    }

    /// A direction of the anisotropy frame that paths are drawn in, in the group's own frame.
    #[inline]
    pub(super) fn rotated(&self, v: Vec3) -> Vec3 {
        match self.rotation {
            None => v,
            Some((sin, cos)) => Vec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z),
        }
    }
}

/// The materials that paths are drawn with: those given, with reflectances among the parameters
/// raised to [`DRAWN_MIN`], so that paths sample their lobes.
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
