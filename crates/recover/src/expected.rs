//! What the user expects of a group's numbers: the bounds that they lie in, and values to start from.
//!
//! Bounds hold for whatever is delivered: a hypothesis that cannot keep them is not tried
//! ([`ParameterBounds::allow`]), fits and the joint refinement stay within. Starting values bind nothing:
//! they are where the first iteration and one more search begin.

use serde::{Deserialize, Serialize};
use std::sync::Arc;
use unrender_scene::reflectance::ALPHA_RANGE;
use unrender_scene::{Hypothesis, Material, Rgb, Texture};

/// What is expected of a group's numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Expected {
    /// The least and the greatest value of each.
    pub bounds: ParameterBounds,
    /// Where to look besides the usual places.
    pub start: StartValues,
    /// The group that it is like, if any.
    pub like: Option<Like>,
}

/// A group's numbers are about those of another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Like {
    /// The other group's index.
    pub group: usize,
    /// The standard deviation of the differences, as a share of the other's numbers.
    pub within: f64,
}

/// The least and the greatest value of each number; the first is at most the second.
///
/// As everywhere, `alpha_x` is the lesser roughness: its lower bound also holds for `alpha_y`, and
/// the upper one of `alpha_y` for it. A round lobe's lies in both intervals.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterBounds {
    /// Of the diffuse reflectance, and of every texel of a texture.
    pub rho_d: [Rgb; 2],
    /// Of the specular reflectance.
    pub rho_s: [Rgb; 2],
    /// Of the roughness along the brushed direction, if there is a lobe.
    pub alpha_x: [f32; 2],
    /// Of the roughness across it.
    pub alpha_y: [f32; 2],
}

/// Values to start from, where there are any.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StartValues {
    /// Diffuse reflectance.
    pub rho_d: Option<Rgb>,
    /// Specular reflectance.
    pub rho_s: Option<Rgb>,
    /// Roughness along the brushed direction; that of a round lobe.
    pub alpha_x: Option<f32>,
    /// Roughness across it.
    pub alpha_y: Option<f32>,
    /// Brushed direction, radians from the surface's tangent.
    pub theta_rad: Option<f32>,
}

impl Default for ParameterBounds {
    fn default() -> Self {
        let unit = [Rgb::ZERO, Rgb::ONE];
        Self { rho_d: unit, rho_s: unit, alpha_x: ALPHA_RANGE, alpha_y: ALPHA_RANGE }
    }
}

/// `value` clamped to the interval; the lower end of an empty one.
fn into(value: f32, [low, high]: [f32; 2]) -> f32 {
    value.clamp(low, high.max(low))
}

fn into_rgb(value: Rgb, [low, high]: [Rgb; 2]) -> Rgb {
    value.clamp(low, high.max(low))
}

impl ParameterBounds {
    /// The interval of the lesser roughness.
    pub fn along(&self) -> [f32; 2] {
        [self.alpha_x[0], self.alpha_x[1].min(self.alpha_y[1])]
    }

    /// The interval of the greater roughness.
    pub fn across(&self) -> [f32; 2] {
        [self.alpha_y[0].max(self.alpha_x[0]), self.alpha_y[1]]
    }

    /// The interval of the roughness of a round lobe; empty where no round lobe keeps the bounds.
    pub fn round(&self) -> [f32; 2] {
        [self.across()[0], self.along()[1]]
    }

    /// The roughness of a round lobe within the bounds that is nearest to `alpha`.
    pub fn nearest_round(&self, alpha: f32) -> f32 {
        into(alpha, self.round())
    }

    /// The lobe `[alpha_x, alpha_y, theta]` with both roughnesses within the bounds, whichever is the lesser.
    pub fn nearest_shape(&self, [x, y, theta]: [f32; 3]) -> [f32; 3] {
        let [along, across] = [self.along(), self.across()];
        if x <= y {
            [into(x, along), into(y, across), theta]
        } else {
            [into(x, across), into(y, along), theta]
        }
    }

    /// Whether a material of `hypothesis` can keep the bounds. A mirror has the roughness zero; where there
    /// is no lobe, bounds of its roughness say nothing.
    pub fn allow(&self, hypothesis: Hypothesis) -> bool {
        let may_be_black = self.rho_d[0] == Rgb::ZERO;
        let may_be_dull = self.rho_s[0] == Rgb::ZERO;
        let may_shine = self.rho_s[1].max_element() > 0.0;
        let may_be_sharp = self.across()[0] <= ALPHA_RANGE[0];
        match hypothesis.of_paper() {
            Hypothesis::Diffuse | Hypothesis::Textured => may_be_dull,
            Hypothesis::Mirror => may_be_black && may_be_sharp && self.rho_s[1] == Rgb::ONE,
            Hypothesis::PartialMirror => may_be_black && may_be_sharp && may_shine,
            Hypothesis::DiffuseSpecular => may_be_sharp && may_shine,
            Hypothesis::Isotropic => may_shine && self.round()[0] <= self.round()[1],
            _ => may_shine,
        }
    }

    /// `material` with the numbers that it has within the bounds.
    #[must_use]
    pub fn nearest(&self, material: &Material) -> Material {
        let mut material = material.clone();
        let shines = material.rho_s != Rgb::ZERO;
        if material.rho_d != Rgb::ZERO || !shines {
            material.rho_d = into_rgb(material.rho_d, self.rho_d);
        }
        if shines {
            material.rho_s = into_rgb(material.rho_s, self.rho_s);
        }
        if material.is_glossy() {
            let Material { alpha_x, alpha_y, theta_rad, .. } = material;
            let is_round = alpha_x == alpha_y && self.allow(Hypothesis::Isotropic);
            let round = self.nearest_round(alpha_x);
            let shape = self.nearest_shape([alpha_x, alpha_y, theta_rad]);
            [material.alpha_x, material.alpha_y, _] =
                if is_round { [round, round, theta_rad] } else { shape };
        }
        if let Some(texture) = &mut material.texture {
            self.bound_texels(texture);
        }
        material
    }

    /// Brings every texel within the bounds.
    pub(crate) fn bound_texels(&self, texture: &mut Arc<Texture>) {
        if self.rho_d != Self::default().rho_d {
            let texels = Arc::make_mut(texture).image.pixels_mut();
            texels.iter_mut().for_each(|texel| *texel = into_rgb(*texel, self.rho_d));
        }
    }
}

/// The first roughness of a lobe that has to be there, if none is stated: half of it is nearly a mirror image, double
/// nearly diffuse.
const ALPHA_START: f32 = 0.2;

impl Expected {
    /// The first material of a group, diffuse with `rho_d` where nothing else is said; with a lobe if it `may_have`
    /// one, and its strength and roughness are given or the bounds ask for one.
    pub(crate) fn first(&self, rho_d: Rgb, may_have: bool) -> Material {
        let Self { bounds, start, .. } = self;
        let diffuse = Material::diffuse(into_rgb(start.rho_d.unwrap_or(rho_d), bounds.rho_d));
        let is_asked_for = bounds.rho_s[0] != Rgb::ZERO;
        let strength = start.rho_s.filter(|rho_s| *rho_s != Rgb::ZERO && start.alpha_x.is_some());
        let strength = strength.or(is_asked_for.then_some(bounds.rho_s[0]));
        let Some(rho_s) = strength.filter(|_| may_have) else { return diffuse };
        let alpha_x = start.alpha_x.unwrap_or(ALPHA_START);
        let alpha_y = start.alpha_y.unwrap_or(alpha_x);
        let theta_rad = start.theta_rad.unwrap_or(0.0);
        bounds.nearest(&Material { rho_s, alpha_x, alpha_y, theta_rad, ..diffuse })
    }

    /// A sentence for every bound of the project on which a number of `material`, of `hypothesis`, lies.
    pub(crate) fn touched(&self, hypothesis: Hypothesis, material: &Material) -> Vec<String> {
        use Hypothesis::{Anisotropic, Diffuse, DiffuseSpecular, Isotropic, PartialMirror};
        let (bounds, free) = (&self.bounds, ParameterBounds::default());
        let mut touched = Vec::new();
        if matches!(hypothesis, Diffuse | DiffuseSpecular | Isotropic | Anisotropic) {
            touched.extend(touches_rgb("rho_d", material.rho_d, bounds.rho_d, free.rho_d));
        }
        if matches!(hypothesis, PartialMirror | DiffuseSpecular | Isotropic | Anisotropic) {
            touched.extend(touches_rgb("rho_s", material.rho_s, bounds.rho_s, free.rho_s));
        }
        let mut alpha = |name: &str, value: f32, interval: [f32; 2]| {
            let ends = std::array::from_fn::<_, 2, _>(|end| {
                let (bound, free) = (interval[end], ALPHA_RANGE[end]);
                bound != free && (value / bound).ln().abs() <= TOUCHES_LN_ALPHA
            });
            if let Some(end) = ends.iter().position(|touches| *touches) {
                touched.push(sentence(name, end, &interval[end].to_string(), ""));
            }
        };
        match hypothesis {
            Isotropic => alpha("alpha_x", material.alpha_x, bounds.round()),
            Anisotropic => {
                alpha("alpha_x", material.alpha_x, bounds.along());
                alpha("alpha_y", material.alpha_y, bounds.across());
            }
            _ => {}
        }
        touched
    }
}

/// A reflectance lies on a bound if it is nearer to it than nearly anyone needs to know it, and so does the logarithm
/// of a roughness. At half of it, numbers that the ladder's last step leaves there are not named; at double, some that
/// stopped by themselves are.
const TOUCHES: f32 = 1e-3;
const TOUCHES_LN_ALPHA: f32 = 2e-3;

fn sentence(name: &str, end: usize, value: &str, channels: &str) -> String {
    format!("{name} lies on its bound {} = {value}{channels}", ["min", "max"][end])
}

/// The sentence for a reflectance that lies on a bound, unless it is that of all reflectances, `free`.
fn touches_rgb(name: &str, value: Rgb, bounds: [Rgb; 2], free: [Rgb; 2]) -> Option<String> {
    let touches = |end: usize| -> Vec<usize> {
        let near = |c: usize| (value[c] - bounds[end][c]).abs() <= TOUCHES;
        (0..3).filter(|&c| bounds[end][c] != free[end][c] && near(c)).collect()
    };
    let (end, channels) =
        [0, 1].map(|end| (end, touches(end))).into_iter().find(|t| !t.1.is_empty())?;
    let [r, g, b] = bounds[end].to_array();
    let shown = if r == g && g == b { r.to_string() } else { format!("[{r}, {g}, {b}]") };
    let names: Vec<&str> = channels.iter().map(|c| ["red", "green", "blue"][*c]).collect();
    let of = if names.len() == 3 { String::new() } else { format!(" in {}", names.join(" and ")) };
    Some(sentence(name, end, &shown, &of))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_alphas(alpha_x: [f32; 2], alpha_y: [f32; 2]) -> ParameterBounds {
        ParameterBounds { alpha_x, alpha_y, ..ParameterBounds::default() }
    }

    #[test]
    fn shapes_come_within_the_bounds_whichever_roughness_is_the_lesser() {
        let bounds = with_alphas([0.02, 0.1], [0.15, 0.4]);
        assert_eq!(bounds.nearest_shape([0.01, 0.5, 1.0]), [0.02, 0.4, 1.0]);
        assert_eq!(bounds.nearest_shape([0.5, 0.01, 1.0]), [0.4, 0.02, 1.0]);
        assert_eq!(bounds.nearest_shape([0.05, 0.2, 1.0]), [0.05, 0.2, 1.0]);
        assert!(!bounds.allow(Hypothesis::Isotropic) && bounds.allow(Hypothesis::Anisotropic));
        // The lesser one bounds the greater one from below, and the other way round.
        assert_eq!(with_alphas([0.1, 1.0], ALPHA_RANGE).across(), [0.1, 1.0]);
        assert_eq!(with_alphas(ALPHA_RANGE, [0.005, 0.3]).along(), [0.005, 0.3]);
        assert_eq!(with_alphas([0.02, 1.0], [0.1, 1.0]).round(), [0.1, 1.0]);
    }

    #[test]
    fn hypotheses_that_cannot_keep_the_bounds_are_not_allowed() {
        let all = |bounds: &ParameterBounds| Hypothesis::ALL.map(|rung| bounds.allow(rung));
        let free = ParameterBounds::default();
        assert_eq!(all(&free), [true; 7]);
        let rough = with_alphas([0.02, 1.0], ALPHA_RANGE);
        assert_eq!(all(&rough), [true, false, false, false, true, true, true]);
        let bright = ParameterBounds { rho_d: [Rgb::splat(0.1), Rgb::ONE], ..free };
        assert_eq!(all(&bright), [true, false, false, true, true, true, true]);
        let shiny = ParameterBounds { rho_s: [Rgb::splat(0.1), Rgb::ONE], ..free };
        assert_eq!(all(&shiny), [false, true, true, true, true, true, false]);
        let dull = ParameterBounds { rho_s: [Rgb::ZERO, Rgb::ZERO], ..free };
        assert_eq!(all(&dull), [true, false, false, false, false, false, true]);
    }

    #[test]
    fn a_group_begins_at_its_start() {
        let start = StartValues { rho_d: Some(Rgb::splat(0.9)), ..StartValues::default() };
        let bounds =
            ParameterBounds { rho_d: [Rgb::ZERO, Rgb::splat(0.6)], ..ParameterBounds::default() };
        let expected = Expected { bounds, start, like: None };
        assert_eq!(expected.first(Rgb::ONE, true), Material::diffuse(Rgb::splat(0.6)));
        let start = StartValues { rho_s: Some(Rgb::splat(0.2)), alpha_x: Some(0.1), ..start };
        let lobe = Material::isotropic(Rgb::splat(0.6), Rgb::splat(0.2), 0.1);
        assert_eq!(Expected { bounds, start, like: None }.first(Rgb::ONE, true), lobe);
        assert!(Expected { bounds, start, like: None }.first(Rgb::ONE, false).rho_s == Rgb::ZERO);
        let bounds = ParameterBounds { rho_s: [Rgb::splat(0.1), Rgb::ONE], ..bounds };
        let asked = Expected { bounds, ..Expected::default() }.first(Rgb::ONE, true);
        assert_eq!((asked.rho_s, asked.alpha_x), (Rgb::splat(0.1), ALPHA_START));
    }

    #[test]
    fn numbers_on_stated_bounds_are_named() {
        let bounds = ParameterBounds {
            rho_d: [Rgb::ZERO, Rgb::new(0.5, 1.0, 0.5)],
            alpha_x: [0.1, 1.0],
            ..ParameterBounds::default()
        };
        let expected = Expected { bounds, ..Expected::default() };
        let touched = |rho_d: Rgb, alpha: f32| {
            let lobe = Material::isotropic(rho_d, Rgb::splat(0.3), alpha);
            expected.touched(Hypothesis::Isotropic, &lobe)
        };
        assert_eq!(touched(Rgb::splat(0.3), 0.2), [""; 0]);
        assert_eq!(
            touched(Rgb::new(0.5, 1.0, 0.3), 0.1),
            [
                "rho_d lies on its bound max = [0.5, 1, 0.5] in red",
                "alpha_x lies on its bound min = 0.1"
            ]
        );
        let dark = Material::diffuse(Rgb::splat(0.5));
        let told = expected.touched(Hypothesis::Diffuse, &dark);
        assert_eq!(told, ["rho_d lies on its bound max = [0.5, 1, 0.5] in red and blue"]);
    }

    #[test]
    fn texels_are_bounded_too() {
        let bounds = ParameterBounds {
            rho_d: [Rgb::splat(0.2), Rgb::splat(0.6)],
            ..ParameterBounds::default()
        };
        let image = unrender_scene::Image::from_fn(2, 1, |x, _| Rgb::splat(x as f32));
        let wrap = unrender_scene::Wrap::Repeat;
        let texture = Arc::new(Texture { image, wrap_u: wrap, wrap_v: wrap });
        let material = Material { texture: Some(texture), ..Material::diffuse(Rgb::splat(0.5)) };
        let texels = bounds.nearest(&material).texture.unwrap();
        assert_eq!(texels.image.pixels(), [Rgb::splat(0.2), Rgb::splat(0.6)]);
    }
}
