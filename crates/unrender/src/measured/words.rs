//! Fits as text: the table of the terminal, the lines of a project file, and a materials.json.

use crate::text_table;
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, Value};
use unrender_formats::materials::{GroupEntry, MaterialsFile, ReflectanceEntry, VERSION};
use unrender_measured::Fit;
use unrender_scene::{Hypothesis, Reflectance, Rgb};

/// The significant digits of numbers in a project file: no table is measured to half as many, and double of them is what
/// single precision does not hold.
const DIGITS: i32 = 4;

/// The table of `fits`; a star stands before the one at `chosen`.
pub(crate) fn table(fits: &[Fit], chosen: usize) -> String {
    let head = ["", "brdf", "kind", "rho_d", "rho_s", "ior", "alpha", "error", "light off"];
    let rows = fits.iter().enumerate().map(|(index, fit)| {
        let material = &fit.material;
        let has_lobe = material.rho_s.max_element() > 0.0;
        let dash = || "-".to_owned();
        let ior = match material.reflectance {
            Reflectance::Dielectric { ior, .. } => format!("{ior:.3}"),
            _ => dash(),
        };
        [
            if index == chosen { "*".to_owned() } else { String::new() },
            fit.form.model.name().to_owned(),
            kind(fit),
            triple(material.rho_d),
            if has_lobe { triple(material.rho_s) } else { dash() },
            ior,
            if has_lobe { format!("{:.4}", material.alpha_x) } else { dash() },
            format!("{:.4}", fit.errors.compressed),
            format!("{:.1} %", 100.0 * fit.errors.linear),
        ]
    });
    text_table::table(&std::iter::once(head.map(str::to_owned)).chain(rows).collect::<Vec<_>>())
}

/// The kind of the material, with what distinguishes it from others of the same model.
fn kind(fit: &Fit) -> String {
    let name = fit.form.hypothesis.name();
    match fit.material.reflectance {
        Reflectance::Dielectric { layering, .. } => format!("{name}, {layering}"),
        Reflectance::Metal { multiscatter: true } => format!("{name}, multiscatter"),
        _ => name.to_owned(),
    }
}

fn triple(rgb: Rgb) -> String {
    rgb.to_array().map(|v| format!("{v:.4}")).join(" ")
}

/// The lines of a project file in which the group `name` has the material of `fit`.
pub(crate) fn known(fit: &Fit, name: &str) -> String {
    let material = &fit.material;
    let mut entry = InlineTable::new();
    let is_plastic = matches!(material.reflectance, Reflectance::Dielectric { .. });
    if !matches!(material.reflectance, Reflectance::Metal { .. }) {
        entry.insert("rho_d", channels(material.rho_d));
    }
    if fit.form.hypothesis != Hypothesis::Diffuse && !is_plastic {
        entry.insert("rho_s", channels(material.rho_s));
    }
    let ReflectanceEntry { reflectance, ior, layering, multiscatter } =
        ReflectanceEntry::of(material);
    reflectance.map(|value| entry.insert("reflectance", value.into()));
    ior.map(|value| entry.insert("ior", number(value).into()));
    layering.map(|value| entry.insert("layering", value.into()));
    multiscatter.map(|value| entry.insert("multiscatter", value.into()));
    if fit.form.hypothesis != Hypothesis::Diffuse {
        entry.insert("alpha_x", number(material.alpha_x).into());
    }
    let mut group = Table::new();
    group.insert("known", Item::Value(Value::InlineTable(entry)));
    let mut groups = Table::new();
    groups.set_implicit(true);
    groups.insert(name, Item::Table(group));
    let mut recover = Table::new();
    recover.insert("brdf", toml_edit::value(fit.form.model.name()));
    let mut document = DocumentMut::new();
    document.insert("recover", Item::Table(recover));
    document.insert("groups", Item::Table(groups));
    document.to_string()
}

fn channels(rgb: Rgb) -> Value {
    Value::Array(rgb.to_array().into_iter().map(number).collect::<Array>())
}

/// `value` to a few significant digits.
fn number(value: f32) -> f64 {
    let value = f64::from(value);
    if value == 0.0 {
        return 0.0;
    }
    let scale = 10_f64.powi(DIGITS - 1 - value.abs().log10().floor() as i32);
    (value * scale).round() / scale
}

/// A `materials.json` in which the group `name` has the material of `fit`.
pub(crate) fn materials(fit: &Fit, name: &str) -> MaterialsFile {
    let material = &fit.material;
    let entry = GroupEntry {
        hypothesis: Some(fit.form.hypothesis),
        rho_d: Some(material.rho_d.to_array()),
        rho_s: Some(material.rho_s.to_array()),
        reflectance: ReflectanceEntry::of(material),
        alpha_x: Some(material.alpha_x),
        alpha_y: Some(material.alpha_y),
        ..GroupEntry::default()
    };
    MaterialsFile {
        version: Some(VERSION),
        brdf: Some(fit.form.model.name().to_owned()),
        groups: [(name.to_owned(), entry)].into_iter().collect(),
        ..MaterialsFile::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_to_four_digits() {
        for (value, rounded) in [(0.123_456, 0.1235), (0.000_123_456, 0.000_123_5), (1.0, 1.0)] {
            assert_eq!(number(value), rounded);
        }
        assert_eq!(number(0.0), 0.0);
    }
}
