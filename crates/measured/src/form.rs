//! The reflectances that are fitted to a measured BRDF, and the numbers that each has.

use unrender_scene::reflectance::{ALPHA_RANGE, IOR_MAX};
use unrender_scene::{BrdfModel, Hypothesis, Layering, Material, Rgb};

/// The least refractive index of a fit: a project file wants one above 1. It reflects 0.002 % at normal incidence; half or
/// double of its difference from one is no lobe that is seen either.
const LEAST_IOR: f64 = 1.01;

/// A reflectance that is fitted: a BRDF model, and what of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Form {
    /// The BRDF model of the project that can state it.
    pub model: BrdfModel,
    /// `Diffuse`, `Isotropic` (a lobe of free reflectance over a base), `Plastic` or `Metal`.
    pub hypothesis: Hypothesis,
}

/// One number of a form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    /// `rho_d` of a channel.
    Base(usize),
    /// `rho_s` of a channel.
    Lobe(usize),
    /// The refractive index.
    Ior,
    /// The roughness.
    Alpha,
}

impl Form {
    /// All forms of `model`, or of all models, the simplest first. A surface without a lobe is one form of any model, and the
    /// free lobe of `principled` is that of GGX.
    pub fn of(model: Option<BrdfModel>) -> Vec<Self> {
        let principled = model.is_some_and(BrdfModel::is_principled);
        let asked = |other: &BrdfModel| model.is_none_or(|model| model.name() == other.name());
        let form = |model, hypothesis| Self { model, hypothesis };
        let mut forms = vec![form(model.unwrap_or_default(), Hypothesis::Diffuse)];
        for model in BrdfModel::ALL.into_iter().filter(asked) {
            if model.is_principled() {
                forms.push(form(model, Hypothesis::Plastic));
                forms.push(form(model, Hypothesis::Metal));
            } else {
                forms.push(form(model, Hypothesis::Isotropic));
            }
        }
        if principled {
            forms
                .insert(1, form(BrdfModel::Principled(Layering::default()), Hypothesis::Isotropic));
        }
        forms
    }

    /// The numbers that are free.
    pub(super) fn numbers(self) -> Vec<Number> {
        use Number::{Alpha, Base, Ior, Lobe};
        match self.hypothesis {
            Hypothesis::Plastic => vec![Base(0), Base(1), Base(2), Ior, Alpha],
            Hypothesis::Metal => vec![Lobe(0), Lobe(1), Lobe(2), Alpha],
            Hypothesis::Isotropic => {
                vec![Base(0), Base(1), Base(2), Lobe(0), Lobe(1), Lobe(2), Alpha]
            }
            _ => vec![Base(0), Base(1), Base(2)],
        }
    }

    /// The material of these `values`, one for each of [`Form::numbers`].
    pub(super) fn material(self, values: &[f64]) -> Material {
        let (mut rho_d, mut rho_s, mut ior, mut alpha) = (Rgb::ZERO, Rgb::ZERO, 1.0, 0.0);
        for (number, value) in self.numbers().into_iter().zip(values) {
            let value = *value as f32;
            match number {
                Number::Base(channel) => rho_d[channel] = value,
                Number::Lobe(channel) => rho_s[channel] = value,
                Number::Ior => ior = value,
                Number::Alpha => alpha = value,
            }
        }
        let layering = self.model.layering();
        match self.hypothesis {
            Hypothesis::Plastic => Material::plastic(rho_d, ior, layering, alpha),
            // As in a project file that does not say.
            Hypothesis::Metal => Material::metal(rho_s, layering == Layering::AlbedoScaled, alpha),
            Hypothesis::Isotropic => Material::isotropic(rho_d, rho_s, alpha),
            _ => Material::diffuse(rho_d),
        }
    }
}

/// A number within its range, stated by an angle `u` without bounds: `x = low + (high - low) sin^2 u`, where `x` is
/// the number, or its logarithm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounded {
    low: f64,
    high: f64,
    is_logarithm: bool,
}

impl Number {
    pub(super) fn bounded(self) -> Bounded {
        let [low, high] = ALPHA_RANGE.map(|alpha| f64::from(alpha).ln());
        match self {
            Self::Base(_) | Self::Lobe(_) => Bounded { low: 0.0, high: 1.0, is_logarithm: false },
            Self::Ior => Bounded { low: LEAST_IOR, high: f64::from(IOR_MAX), is_logarithm: false },
            Self::Alpha => Bounded { low, high, is_logarithm: true },
        }
    }
}

impl Bounded {
    /// The number at `u`, and its derivative.
    pub(super) fn at(self, u: f64) -> (f64, f64) {
        let width = self.high - self.low;
        let (x, slope) = (self.low + width * u.sin().powi(2), width * (2.0 * u).sin());
        if self.is_logarithm { (x.exp(), x.exp() * slope) } else { (x, slope) }
    }

    /// The `u` of a `number` within the range.
    pub(super) fn angle(self, number: f64) -> f64 {
        let x = if self.is_logarithm { number.ln() } else { number };
        ((x - self.low) / (self.high - self.low)).clamp(0.0, 1.0).sqrt().asin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_ranges_and_have_their_slopes() {
        for (number, value) in [(Number::Base(0), 0.3), (Number::Ior, 1.5), (Number::Alpha, 0.1)] {
            let bounded = number.bounded();
            let u = bounded.angle(value);
            assert!((bounded.at(u).0 - value).abs() < 1e-6);
            let numeric = (bounded.at(u + 1e-6).0 - bounded.at(u - 1e-6).0) / 2e-6;
            assert!((bounded.at(u).1 - numeric).abs() < 1e-6 * numeric.abs().max(1.0));
            for u in [-7.0, 0.0, 1.0, 100.0] {
                let x = bounded.at(u).0;
                assert!(x >= bounded.at(0.0).0 - 1e-12 && x <= 3.0 + 1e-12, "{number:?} {u} {x}");
            }
        }
    }

    #[test]
    fn a_model_has_its_own_forms() {
        let names = |model: Option<&str>| {
            let forms = Form::of(model.map(|name| name.parse().unwrap()));
            forms.iter().map(|f| format!("{} {}", f.model, f.hypothesis)).collect::<Vec<_>>()
        };
        assert_eq!(names(Some("ggx")), ["ggx diffuse", "ggx isotropic"]);
        assert_eq!(names(Some("principled")).len(), 6);
        assert_eq!(names(None).len(), 1 + 4 + 4);
    }
}
