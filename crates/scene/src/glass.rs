//! Smooth glass, and other surfaces that let light through without scattering it.
//!
//! Glass is part of the way between surfaces: at each of its faces light is reflected or goes on, by Fresnel's
//! equations. *Solid* glass is a body, whose front is outside, and bends light where it enters and leaves it. A *thin*
//! pane is both faces of a plate in one: light goes straight on, and what is reflected to and fro inside is counted,
//! `R = 2 r / (1 + r)` of the reflectance `r` of one face.

use crate::Mesh;
use crate::Rgb;
use crate::reflectance::fresnel;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// What a surface of glass does to light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Glass {
    /// The refractive index of the inside over that of the outside, above zero. One reflects nothing.
    pub ior: f32,
    /// The factor on light that passes the surface once, 0 to 1 per channel.
    pub tint: Rgb,
    /// What solid glass absorbs of light on its way through it, per metre: `exp(-absorption distance)` is left.
    pub absorption: Rgb,
    /// Whether the surface is a pane; else it bounds a body.
    pub is_thin: bool,
}

impl Glass {
    /// A pane without colour.
    pub fn pane(ior: f32) -> Self {
        Self { ior, tint: Rgb::ONE, absorption: Rgb::ZERO, is_thin: true }
    }

    /// A body without colour.
    pub fn solid(ior: f32) -> Self {
        Self { is_thin: false, ..Self::pane(ior) }
    }

    /// The share of light that is reflected where it arrives from outside at an angle of this cosine.
    ///
    /// ```
    /// use unrender_scene::Glass;
    /// assert!((Glass::solid(1.5).reflected(1.0) - 0.04).abs() < 1e-6);
    /// assert!((Glass::pane(1.5).reflected(1.0) - 0.08 / 1.04).abs() < 1e-6);
    /// ```
    pub fn reflected(&self, cos: f32) -> f32 {
        let once = fresnel(cos, self.ior);
        if self.is_thin { 2.0 * once / (1.0 + once) } else { once }
    }

    /// Whether its numbers are usable.
    pub fn is_valid(&self) -> bool {
        let is_amount = |rgb: Rgb| rgb.is_finite() && rgb.min_element() >= 0.0;
        let is_share = is_amount(self.tint) && self.tint.max_element() <= 1.0;
        self.ior.is_finite() && self.ior > 0.0 && is_share && is_amount(self.absorption)
    }
}

impl Mesh {
    /// Whether the mesh bounds a body: each edge has as many triangles on one side as on the other. Vertices at the same
    /// place count as one.
    ///
    /// ```
    /// use unrender_scene::Mesh;
    /// use glam::Vec3;
    ///
    /// assert!(Mesh::sphere(Vec3::ZERO, 1.0).is_closed());
    /// assert!(!Mesh::flat(&[Vec3::ZERO, Vec3::X, Vec3::Y], &[], &[[0, 1, 2]]).is_closed());
    /// ```
    pub fn is_closed(&self) -> bool {
        // Zero has two signs.
        let place =
            |vertex: u32| (self.positions[vertex as usize] + 0.0).to_array().map(f32::to_bits);
        let mut sides: HashMap<[[u32; 3]; 2], i64> = HashMap::new();
        for &[a, b, c] in &self.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let (from, to) = (place(from), place(to));
                let (edge, side) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
                if from != to {
                    *sides.entry(edge).or_default() += side;
                }
            }
        }
        !self.triangles.is_empty() && sides.values().all(|sum| *sum == 0)
    }
}
