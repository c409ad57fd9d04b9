//! The fits as JSON.

use serde::Serialize;
use unrender_formats::materials::ReflectanceEntry;
use unrender_measured::Fit;
use unrender_scene::MeasuredBrdf;

/// `fits.json`: what was fitted to a measured BRDF.
#[derive(Clone, Debug, Serialize)]
pub struct Document {
    /// The file of the measured BRDF.
    pub file: String,
    /// The cells along `theta_h`, `theta_d` and `phi_d`.
    pub cells: [usize; 3],
    /// How many of them were measured.
    pub measured: usize,
    /// The index in `fits` of the fit that `project` states.
    pub chosen: usize,
    /// The fits, the simplest first.
    pub fits: Vec<FitEntry>,
    /// The lines of a project file.
    pub project: String,
}

/// One fit.
#[derive(Clone, Debug, Serialize)]
pub struct FitEntry {
    /// The BRDF model.
    pub brdf: &'static str,
    /// `diffuse`, `isotropic`, `plastic` or `metal`.
    pub hypothesis: &'static str,
    /// Diffuse reflectance; of a plastic that of its base.
    pub rho_d: [f32; 3],
    /// Specular reflectance; of a plastic or a metal that at normal incidence.
    pub rho_s: [f32; 3],
    /// What `rho_s` means.
    #[serde(flatten)]
    pub reflectance: ReflectanceEntry,
    /// Roughness; none without a lobe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alpha: Option<f32>,
    /// The cosine-weighted cube-root error, sr^(-1/3).
    pub error: f64,
    /// The error of the reflected light, as a share of it.
    pub error_of_light: f64,
}

impl FitEntry {
    fn of(fit: &Fit) -> Self {
        let material = &fit.material;
        Self {
            brdf: fit.form.model.name(),
            hypothesis: fit.form.hypothesis.name(),
            rho_d: material.rho_d.to_array(),
            rho_s: material.rho_s.to_array(),
            reflectance: ReflectanceEntry::of(material),
            alpha: material.is_glossy().then_some(material.alpha_x),
            error: fit.errors.compressed,
            error_of_light: fit.errors.linear,
        }
    }
}

/// The document of `fits` to `table`, of which the one at `chosen` has the lines `project`.
pub(crate) fn document(
    file: String,
    table: &MeasuredBrdf,
    (fits, chosen): (&[Fit], usize),
    project: String,
) -> Document {
    let measured = (0..table.len()).filter(|cell| table.value(*cell).is_some()).count();
    let cells = table.counts();
    Document {
        file,
        cells,
        measured,
        chosen,
        fits: fits.iter().map(FitEntry::of).collect(),
        project,
    }
}
