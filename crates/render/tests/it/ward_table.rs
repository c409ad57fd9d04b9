//! Proves Ward's lobe against 1800 values that Radiance computed for its plastic and metal, plain
//! and anisotropic (`data/ward_rtrace_table.csv`; made with Radiance's rtrace).
//!
//! The columns `rs` and `rd` are the shares of the lobe and of the diffuse part, metal or plastic
//! alike: the value is `rd/pi + rs w`. Beside Radiance's own value the table has three forms
//! computed from their formulas in double precision.

use glam::Vec3;
use std::f32::consts::FRAC_1_PI;
use unrender_render::WardLobe;
use unrender_render::bsdf::Bsdf;
use unrender_scene::{Material, Rgb, WardModel};

const TABLE: &str = include_str!("../data/ward_rtrace_table.csv");

struct Row {
    material: Material,
    wi: Vec3,
    wo: Vec3,
    radiance: f32,
    /// In the order of `WardModel::ALL`.
    forms: [f32; 3],
}

fn direction(theta_deg: f32, phi_deg: f32) -> Vec3 {
    let (theta, phi) = (f64::from(theta_deg).to_radians(), f64::from(phi_deg).to_radians());
    Vec3::new(
        (theta.sin() * phi.cos()) as f32,
        (theta.sin() * phi.sin()) as f32,
        theta.cos() as f32,
    )
}

fn rows() -> Vec<Row> {
    let mut lines = TABLE.lines();
    assert_eq!(
        lines.next(),
        Some(
            "material,rs,rd,ax,ay,theta_i,phi_i,theta_o,phi_o,brdf_radiance,ward1992,ward_duer,\
             wgmd2010"
        )
    );
    let parse = |line: &str| {
        let n: Vec<f32> = line.split(',').skip(1).map(|n| n.parse().unwrap()).collect();
        Row {
            material: Material {
                alpha_x: n[2],
                alpha_y: n[3],
                rho_s: Rgb::splat(n[0]),
                ..Material::diffuse(Rgb::splat(n[1]))
            },
            wi: direction(n[4], n[5]),
            wo: direction(n[6], n[7]),
            radiance: n[8],
            forms: [n[9], n[10], n[11]],
        }
    };
    lines.map(parse).collect()
}

fn value(row: &Row, model: WardModel) -> f32 {
    Bsdf::new(&row.material, row.material.rho_d, model).value(row.wo, row.wi).x
}

#[test]
fn ward_gmd_is_what_radiance_computes() {
    let rows = rows();
    assert_eq!(rows.len(), 1800);
    for (index, row) in rows.iter().enumerate() {
        let error = value(row, WardModel::WardGmd) / row.radiance - 1.0;
        assert!(error.abs() < 1e-3, "row {index}: {error}");
    }
}

#[test]
fn each_form_is_its_formula() {
    for (index, row) in rows().iter().enumerate() {
        for (model, expected) in WardModel::ALL.into_iter().zip(row.forms) {
            let error = value(row, model) / expected - 1.0;
            assert!(error.abs() < 2e-5, "row {index}, {model:?}: {error}");
        }
    }
}

#[test]
fn the_lobe_alone_is_right_where_it_outshines_the_diffuse_part() {
    let mut compared = 0;
    for (index, row) in rows().iter().enumerate() {
        let lobe = row.radiance - row.material.rho_d.x * FRAC_1_PI;
        if lobe > 0.5 * row.radiance {
            let w = WardLobe::new(WardModel::WardGmd, row.material.alpha_x, row.material.alpha_y);
            let error = row.material.rho_s.x * w.value(row.wo, row.wi) / lobe - 1.0;
            assert!(error.abs() < 1e-3, "row {index}: {error}");
            compared += 1;
        }
    }
    assert!(compared > 100, "{compared} rows");
}
