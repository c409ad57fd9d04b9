//! Plastics and metals: furnace, reciprocity, energy, sampling, albedo by an independent quadrature, derivatives by
//! finite differences, and stored paths that equal traced ones.

use crate::common::{Estimate, Stage, assert_agree};
use crate::common::{Random, camera, settings};
use glam::{DVec3, Vec3};
use unrender_render::bsdf::{Bsdf, lobe};
use unrender_render::{GlossyLobe, Parameter, Query};
use unrender_scene::reflectance::fresnel;
use unrender_scene::{BrdfModel, Layering, LobeAlbedo, Material, Reflectance, Rgb};

const MODEL: BrdfModel = BrdfModel::Principled(Layering::Coupled);
const BASE: Rgb = Rgb::new(0.9, 0.5, 0.1);
const GOLD: Rgb = Rgb::new(0.95, 0.7, 0.3);
const ALPHAS: [f32; 6] = [0.0, 0.02, 0.1, 0.3, 0.6, 1.0];

fn direction(degrees: f32, phi: f32) -> Vec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vec3::new(sin * phi.cos(), sin * phi.sin(), cos)
}

/// In a scene of the format that has such materials.
fn bsdf(material: &Material) -> Bsdf<'static> {
    Bsdf::new(material, material.rho_d, BrdfModel::Principled(layering(material)))
}

fn layering(material: &Material) -> Layering {
    match material.reflectance {
        Reflectance::Dielectric { layering, .. } => layering,
        Reflectance::Metal { multiscatter: true } => Layering::AlbedoScaled,
        Reflectance::Metal { multiscatter: false } | Reflectance::Free => Layering::Coupled,
    }
}

/// All plastics and metals under test.
fn coated() -> impl Iterator<Item = Material> {
    ALPHAS.into_iter().flat_map(|alpha| {
        let plastics = Layering::ALL.into_iter().flat_map(move |layering| {
            [1.33, 1.5, 1.9].map(|ior| Material::plastic(BASE, ior, layering, alpha))
        });
        plastics.chain([true, false].map(|several| Material::metal(GOLD, several, alpha)))
    })
}

/// `integral f cos` over the directions that the lobe and the cosine draw, on a grid; with the delta of a perfect mirror.
fn albedo(bsdf: &Bsdf<'_>, wo: Vec3) -> DVec3 {
    const SIDE: usize = 200;
    let mut sum = DVec3::ZERO;
    let pick = [0.5 * bsdf.specular_share(), 0.5 + 0.5 * bsdf.specular_share()];
    for ((i, j), (pick, share)) in
        (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| (i, j))).flat_map(|at| {
            pick.into_iter()
                .zip([bsdf.specular_share(), 1.0 - bsdf.specular_share()])
                .map(move |p| (at, p))
        })
    {
        let u = [pick, (i as f32 + 0.5) / SIDE as f32, (j as f32 + 0.5) / SIDE as f32];
        if share > 0.0
            && let Some(sample) = bsdf.sample(wo, u)
        {
            sum += sample.weight.as_dvec3() * f64::from(share);
        }
    }
    sum / (SIDE * SIDE) as f64
}

#[test]
fn tables_have_the_albedo_of_the_lobe() {
    for ior in [1.33, 1.5, 1.77, 2.4] {
        for alpha in [0.005, 0.03, 0.08, 0.2, 0.45, 0.8, 1.0] {
            let table = LobeAlbedo::dielectric(ior, alpha);
            for degrees in [0.0, 20.0, 45.0, 60.0, 75.0, 85.0, 89.0] {
                let wo = direction(degrees, 0.4);
                let lobe = GlossyLobe::new(BrdfModel::Ggx, alpha, alpha);
                // The visible normals on a grid four times as fine, in single precision.
                let mut sum = 0.0;
                let side = 80;
                for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
                    let wi = lobe.sample(wo, [i, j].map(|k| (k as f32 + 0.5) / side as f32));
                    let (value, pdf) = lobe.value_and_pdf(wo, wi);
                    if wi.z > 0.0 && pdf > 0.0 {
                        let reflectance = fresnel(0.5 * (wo + wi).length(), ior);
                        sum += f64::from(reflectance * value * wi.z / pdf);
                    }
                }
                let expected = sum / f64::from(side * side);
                let error = (f64::from(table.at(wo.z)) - expected).abs();
                let limit = if degrees > 80.0 && alpha < 0.05 { 4e-3 } else { 1.5e-3 };
                assert!(error < limit, "{ior} {alpha} {degrees}: {error}");
            }
        }
    }
}

#[test]
fn plastics_have_the_albedo_of_lobe_and_base_together() {
    for material in coated().filter(|m| m.rho_d != Rgb::ZERO) {
        let Reflectance::Dielectric { ior, layering } = material.reflectance else { continue };
        let taken = LobeAlbedo::over(layering, ior, material.alpha_x);
        for degrees in [0.0, 30.0, 60.0, 80.0] {
            let wo = direction(degrees, 0.4);
            let black = Material { rho_d: Rgb::ZERO, ..material.clone() };
            let lobe = albedo(&bsdf(&black), wo);
            let base = BASE.as_dvec3() * f64::from(1.0 - taken.at(wo.z));
            let expected = lobe + base;
            let found = albedo(&bsdf(&material), wo);
            let error = (found - expected).abs().max_element();
            assert!(error < 3e-3, "{material:?} at {degrees}: {found} is not {expected}");
        }
    }
}

#[test]
fn a_white_metal_loses_nothing_if_it_scatters_several_times() {
    for alpha in ALPHAS {
        for degrees in [0.0, 30.0, 60.0, 80.0] {
            let wo = direction(degrees, 0.4);
            let found = albedo(&bsdf(&Material::metal(Rgb::ONE, true, alpha)), wo);
            assert!((found - DVec3::ONE).abs().max_element() < 6e-3, "{alpha} {degrees}: {found}");
            let once = albedo(&bsdf(&Material::metal(Rgb::ONE, false, alpha)), wo).x;
            let expected = match alpha {
                0.0 => 1.0,
                _ => {
                    let model = BrdfModel::Principled(Layering::Coupled);
                    lobe::albedo(&GlossyLobe::new(model, alpha, alpha), wo, 200)
                }
            };
            assert!((once - expected).abs() < 3e-3, "{alpha} {degrees}: {once} is not {expected}");
        }
    }
}

#[test]
fn no_more_light_leaves_than_arrives() {
    for material in coated() {
        for degrees in [0.0, 45.0, 75.0, 85.0, 89.0] {
            let found = albedo(&bsdf(&material), direction(degrees, 0.4));
            assert!(found.max_element() < 1.0 + 5e-3, "{material:?} at {degrees}: {found}");
        }
    }
}

#[test]
fn coupled_plastics_and_metals_that_scatter_once_reflect_both_ways_alike() {
    let mut random = Random::new(7);
    let is_reciprocal = |material: &Material| match material.reflectance {
        Reflectance::Dielectric { layering, .. } => layering == Layering::Coupled,
        Reflectance::Metal { multiscatter } => !multiscatter,
        Reflectance::Free => true,
    };
    let mut differs = 0.0f32;
    for material in coated() {
        let bsdf = bsdf(&material);
        for _ in 0..500 {
            let [a, b, c] = random.next3();
            let (wo, wi) = (direction(89.0 * a, 6.3 * b), direction(89.0 * c, 6.3 * random.next()));
            let (there, back) = (bsdf.value(wo, wi), bsdf.value(wi, wo));
            let difference = (there - back).abs().max_element() / there.max_element().max(1e-3);
            if is_reciprocal(&material) {
                assert!(difference <= 2e-5, "{material:?}: {difference}");
            } else {
                differs = differs.max(difference);
            }
        }
    }
    assert!(differs > 0.1, "albedo-scaled bases are not reciprocal: {differs}");
}

#[test]
fn weights_are_value_times_cosine_over_density() {
    let mut random = Random::new(9);
    for material in coated().filter(|material| material.alpha_x > 0.0) {
        let bsdf = bsdf(&material);
        for cos in [1.0, 0.5, 0.1, 1e-2, 1e-4, 1e-8f32] {
            let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            for _ in 0..300 {
                let Some(sample) = bsdf.sample(wo, random.next3()) else { continue };
                let ratio = bsdf.value(wo, sample.wi) * sample.wi.z / bsdf.pdf(wo, sample.wi);
                assert!(sample.weight.is_finite() && sample.weight.min_element() >= 0.0);
                let error = (ratio - sample.weight).abs().max_element();
                assert!(error <= 1e-5 * ratio.max_element(), "{material:?}");
            }
        }
    }
}

#[test]
fn derivatives_are_those_of_differences() {
    let mut worst = 0.0f32;
    for material in coated().filter(|m| m.alpha_x > 0.01 && m.alpha_x < 0.9) {
        let pairs = [
            (20.0, 0.0, 30.0, 3.0),
            (60.0, 1.0, 50.0, 4.0),
            (10.0, 0.0, 70.0, 2.0),
            (40.0, 0.5, 42.0, 3.6),
        ];
        for (a, b, c, d) in pairs {
            let (wo, wi) = (direction(a, b), direction(c, d));
            let terms = bsdf(&material).terms(material.rho_d, wo, wi);
            let value = |changed: &Material| bsdf(changed).terms(changed.rho_d, wo, wi).value;
            assert!((terms.value - bsdf(&material).value(wo, wi)).abs().max_element() < 1e-6);
            let differences = |change: &dyn Fn(&mut Material, f32), step: f32| {
                let [plus, minus] = [step, -step].map(|step| {
                    let mut changed = material.clone();
                    change(&mut changed, step);
                    value(&changed)
                });
                (plus - minus) / (2.0 * step)
            };
            let scale = terms.value.max_element().max(0.05);
            let mut check = |found: Rgb, expected: Rgb, unit: f32, name: &str| {
                let error = (found - expected).abs().max_element() / (scale * unit);
                assert!(error < 2e-2, "{name} of {material:?}: {found} is not {expected}");
                worst = worst.max(error);
            };
            let by_base = differences(&|m, step| m.rho_d += Rgb::splat(step), 1e-2);
            check(Rgb::splat(terms.by_rho_d), by_base, 1.0, "rho_d");
            // Within one interval of the tables.
            let step = 2e-4 * material.alpha_x;
            let by_x = differences(&|m, step| m.alpha_x += step, step);
            check(terms.by_alpha_x, by_x, 1.0 / material.alpha_x, "alpha_x");
            let by_y = differences(&|m, step| m.alpha_y += step, step);
            check(terms.by_alpha_y, by_y, 1.0 / material.alpha_x, "alpha_y");
            if let Reflectance::Metal { .. } = material.reflectance {
                let by_f0 = differences(&|m, step| m.rho_s += Rgb::splat(step), 1e-3);
                check(terms.by_rho_s, by_f0, 1.0, "rho_s");
            }
        }
    }
    assert!(worst > 0.0);
}

/// A ball of `material` in a black room that emits `radiance` all around; the mean of its picture.
fn in_the_furnace(material: Material, radiance: Rgb) -> Estimate {
    let model = BrdfModel::Principled(layering(&material));
    let mut stage = Stage::default();
    let wall = stage.group(Material::diffuse(Rgb::ZERO), radiance);
    stage.room(wall, Vec3::splat(2.0));
    let ball = stage.group(material, Rgb::ZERO);
    stage.sphere(ball, Vec3::ZERO, 0.5, 24);
    stage.scene.brdf = model;
    let view = camera(Vec3::new(0.3, 0.4, 1.8), Vec3::new(0.03, 0.02, 0.0), 0.3);
    Estimate::of_film(&stage.render(&view, 16, settings(1024)))
}

#[test]
fn white_plastics_vanish_in_the_furnace() {
    let radiance = Rgb::new(2.0, 1.0, 0.5);
    for (layering, alpha) in Layering::ALL.into_iter().flat_map(|l| [0.0, 0.1, 0.5].map(|a| (l, a)))
    {
        let found = in_the_furnace(Material::plastic(Rgb::ONE, 1.5, layering, alpha), radiance);
        if layering == Layering::Coupled && alpha > 0.0 {
            // What microfacets scatter more than once is lost.
            let share = (found.mean / radiance.as_dvec3()).max_element();
            let range = if alpha < 0.2 { 0.99..0.999 } else { 0.9..0.97 };
            assert!(range.contains(&share), "{alpha}: {share}");
        } else {
            assert_agree("white plastic", found, Estimate::exactly(radiance), 3e-3);
        }
    }
}

/// A lamp over a floor that a wall is seen in.
fn corner(floor: Material, wall: Material) -> Stage {
    let mut stage = Stage::default();
    let floor = stage.group(floor, Rgb::ZERO);
    stage.plate(floor, Vec3::ZERO, Vec3::Z, Vec3::X);
    let wall = stage.group(wall, Rgb::ZERO);
    stage.plate(wall, Vec3::new(0.0, 0.5, -0.8), Vec3::X, 0.6 * Vec3::Y);
    let lamp = stage.group(Material::diffuse(Rgb::ZERO), Rgb::new(5.0, 6.0, 7.0));
    stage.plate(lamp, Vec3::new(0.2, 1.4, 0.3), 0.3 * Vec3::X, 0.3 * Vec3::Z);
    stage.scene.brdf = MODEL;
    stage
}

#[test]
fn a_polished_floor_reflects_lamps_by_fresnels_equations() {
    // The lamp lights the wall by way of the floor, too: virtual samples and directions must agree, path by path and in
    // stored paths.
    let view = camera(Vec3::new(0.1, 0.9, 1.6), Vec3::new(0.0, 0.2, -0.4), 0.9);
    for layering in Layering::ALL {
        let floor = Material::plastic(BASE, 1.5, layering, 0.0);
        let stage = corner(floor, Material::diffuse(Rgb::splat(0.7)));
        let nearly = Material::plastic(BASE, 1.5, layering, 2e-3);
        let rough = corner(nearly, Material::diffuse(Rgb::splat(0.7)));
        let [smooth, rough] =
            [stage, rough].map(|stage| Estimate::of_film(&stage.render(&view, 24, settings(1024))));
        assert_agree("a smooth and a nearly smooth floor", smooth, rough, 1e-2);
    }
}

#[test]
fn stored_paths_bring_what_traced_ones_bring() {
    let view = camera(Vec3::new(0.1, 0.9, 1.6), Vec3::new(0.0, 0.2, -0.4), 0.9);
    let floors = [
        Material::plastic(BASE, 1.5, Layering::AlbedoScaled, 0.0),
        Material::plastic(BASE, 1.5, Layering::Coupled, 0.15),
        Material::metal(GOLD, true, 0.3),
        Material::metal(GOLD, false, 0.0),
    ];
    for floor in floors {
        let stage =
            corner(floor.clone(), Material::plastic(BASE, 1.4, Layering::AlbedoScaled, 0.2));
        let tracer = unrender_render::Tracer::new(&stage.scene);
        let materials = stage.scene.materials();
        let pixels: Vec<u32> = (0..256).collect();
        let parameters = [
            Parameter::RhoD(0),
            Parameter::RhoS(0),
            Parameter::AlphaX(0),
            Parameter::RhoD(1),
            Parameter::AlphaX(1),
        ];
        let settings = settings(16);
        let traced = tracer.jacobian(
            &view,
            (16, 16),
            &Query { parameters: &parameters, ..Query::new(&materials, &pixels, &settings) },
        );
        let paths = tracer.store(
            &view,
            (16, 16),
            &Query { parameters: &parameters, ..Query::new(&materials, &pixels, &settings) },
        );
        let replayed = paths.replay(&tracer, &materials, &parameters, None);
        let scale = traced.radiance.iter().map(|r| r.max_element()).fold(0.0, f32::max);
        for (a, b) in traced.radiance.iter().zip(&replayed.radiance) {
            assert!((a - b).abs().max_element() < 1e-4 * scale, "{floor:?}: {a} {b}");
        }
        let most = traced.derivatives.iter().map(|d| d.abs().max_element()).fold(0.0, f32::max);
        for (a, b) in traced.derivatives.iter().zip(&replayed.derivatives) {
            assert!((a - b).abs().max_element() < 1e-3 * most, "{floor:?}: {a} {b}");
        }
    }
}

#[test]
fn derivatives_of_pictures_are_those_of_stored_paths_under_other_materials() {
    let view = camera(Vec3::new(0.1, 0.9, 1.6), Vec3::new(0.0, 0.2, -0.4), 0.9);
    let floor = Material::plastic(BASE, 1.5, Layering::Coupled, 0.15);
    let stage = corner(floor, Material::metal(GOLD, true, 0.3));
    let tracer = unrender_render::Tracer::new(&stage.scene);
    let materials = stage.scene.materials();
    let pixels: Vec<u32> = (0..256).collect();
    let parameters =
        [Parameter::RhoD(0), Parameter::AlphaX(0), Parameter::RhoS(1), Parameter::AlphaX(1)];
    let paths = tracer.store(
        &view,
        (16, 16),
        &Query { parameters: &parameters, ..Query::new(&materials, &pixels, &settings(16)) },
    );
    let jacobian = paths.replay(&tracer, &materials, &parameters, None);
    for (k, parameter) in parameters.iter().enumerate() {
        let step = 5e-4;
        let [plus, minus] = [step, -step].map(|step| {
            let mut changed = materials.clone();
            match parameter {
                Parameter::RhoD(group) => changed[*group as usize].rho_d += Rgb::splat(step),
                Parameter::RhoS(group) => changed[*group as usize].rho_s += Rgb::splat(step),
                Parameter::AlphaX(group) => changed[*group as usize].alpha_x += step,
                _ => {}
            }
            paths.replay(&tracer, &changed, &[], None).radiance
        });
        let column = jacobian.derivatives.iter().skip(k).step_by(parameters.len());
        let differences = plus.iter().zip(&minus).map(|(p, m)| (*p - *m) / (2.0 * step));
        let pairs: Vec<_> = column.zip(differences).collect();
        let scale = pairs.iter().map(|(d, _)| d.abs().max_element()).fold(0.0, f32::max);
        for (found, expected) in pairs {
            let error = (*found - expected).abs().max_element();
            assert!(error < 2e-2 * scale, "{parameter:?}: {found} is not {expected}");
        }
    }
}
