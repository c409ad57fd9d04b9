//! The triangles that rays may pass: those with holes, and those of glass.
//!
//! They have a hierarchy of their own, so that scenes without any lose nothing, and rays that meet none of them little. A
//! ray that passes one goes on behind it, from where rays that leave a surface start.

use crate::accel::{Accel, Hit, Ray};
use crate::shapes::Shapes;
use glam::Vec3;
use unrender_scene::{Glass, Rgb};

/// Most triangles that a ray passes; then it ends. A ray through a wood passes a hundred leaves' holes. At half of it dense
/// hedges darken, at double of it a broken mesh takes twice as long.
const PASSED_MAX: usize = 1024;

/// The triangles that rays may pass.
#[derive(Debug)]
pub(crate) struct Veil {
    accel: Accel,
    has_glass: bool,
}

/// What glass does to light on a straight way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Passage {
    /// The factor on light that passes.
    pub(crate) filter: Rgb,
    /// The probability with which a ray that chooses at random passes.
    pub(crate) probability: f32,
}

impl Passage {
    /// That of an open way.
    pub(crate) const OPEN: Self = Self { filter: Rgb::ONE, probability: 1.0 };

    /// The share of light that passes.
    pub(crate) fn transmittance(&self) -> Rgb {
        self.filter * self.probability
    }
}

/// Which glass a straight way may pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Through {
    /// Panes; solid glass bends light.
    Panes,
    /// Solid glass as well, as if it did not bend light: towards lights without an extent, which no bent ray finds.
    All,
}

impl Veil {
    /// Those of `triangles` with the indices `veiled`.
    pub(crate) fn new(triangles: &[[Vec3; 3]], veiled: &[u32], shapes: &Shapes) -> Self {
        let has_glass = veiled.iter().any(|&triangle| shapes.glass(triangle).is_some());
        Self { accel: Accel::of(triangles, veiled), has_glass }
    }

    /// Whether there is glass.
    pub(crate) fn has_glass(&self) -> bool {
        self.has_glass
    }

    /// The first hit of `ray`, holes not counted, at which `stops` is true.
    #[inline]
    fn first(
        &self,
        shapes: &Shapes,
        ray: &Ray,
        mut stops: impl FnMut(&Ray, &Hit) -> bool,
    ) -> Option<Hit> {
        let (mut ray, mut gone) = (*ray, 0.0);
        for _ in 0..PASSED_MAX {
            let hit = self.accel.closest(&ray)?;
            let far = Hit { t: gone + hit.t, ..hit };
            if !shapes.is_hole(&hit) && stops(&ray, &far) {
                return Some(far);
            }
            gone = far.t;
            ray = shapes.behind(&ray, &hit);
        }
        None
    }

    /// `hit`, or what `ray` hits before it, as if there were no glass.
    pub(crate) fn nearer(&self, shapes: &Shapes, ray: &Ray, hit: Option<Hit>) -> Option<Hit> {
        let ray = Ray { t_max: hit.map_or(ray.t_max, |hit| hit.t), ..*ray };
        self.first(shapes, &ray, |_, hit| shapes.glass(hit.triangle).is_none()).or(hit)
    }

    /// `hit`, or what `ray` hits before it, glass or not.
    pub(crate) fn next(&self, shapes: &Shapes, ray: &Ray, hit: Option<Hit>) -> Option<Hit> {
        let ray = Ray { t_max: hit.map_or(ray.t_max, |hit| hit.t), ..*ray };
        self.first(shapes, &ray, |_, _| true).or(hit)
    }

    /// What passes along `ray` to its end; none if something occludes it.
    pub(crate) fn passage(&self, shapes: &Shapes, ray: &Ray, through: Through) -> Option<Passage> {
        let mut passage = Passage::OPEN;
        let mut entered = None;
        let stops = |ray: &Ray, hit: &Hit| {
            let Some(glass) = shapes.glass(hit.triangle) else { return true };
            if !glass.is_thin && through == Through::Panes {
                return true;
            }
            let cos = ray.direction.dot(shapes.front_normal(hit.triangle));
            passage.probability *= 1.0 - glass.reflected(cos.abs());
            passage.filter *= glass.tint;
            if cos < 0.0 {
                entered = Some(hit.t);
            } else if let Some(from) = entered.take().filter(|_| !glass.is_thin) {
                passage.filter *= absorbed(glass, hit.t - from);
            }
            false
        };
        match self.first(shapes, ray, stops) {
            Some(_) => None,
            None => Some(passage),
        }
    }
}

/// The factor on light after a way of `distance`, metres, inside `glass`.
pub(crate) fn absorbed(glass: &Glass, distance: f32) -> Rgb {
    if glass.absorption == Rgb::ZERO { Rgb::ONE } else { (-distance * glass.absorption).exp() }
}
