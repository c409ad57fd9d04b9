//! The paper's ladder on boxes with brushed floors, step by step: `cargo run --release -p unrender-paper --example
//! paper_steps`, from the repository's root.
//!
//! The example prints tables for `docs/method/paper.md`: the error of each rung on the floor by two ways of rendering
//! it again, each with its standard deviation, and what the ladder finds in each box.

#[path = "paper_direction/cornell_box.rs"]
mod cornell_box;

use cornell_box::{FLOOR, camera, scene, truth};
use unrender_paper::lobe::Lobes;
use unrender_paper::{Direction, Paper, recover};
use unrender_recover::compare::residual::{ResidualStats, residual_stats};
use unrender_recover::evidence::{Evidence, SampleBudget};
use unrender_recover::hypothesis::{self, Search};
use unrender_recover::observe::sample::Stage;
use unrender_recover::{
    GroupSpec, Hypothesis, Observation, Options, Picture, Problem, Renderer, Role, View,
    sample_budget,
};
use unrender_render::{ProbeSettings, ProposalLobe, Settings, Tracer};
use unrender_scene::{Image, Material, Rgb, RgbImage, Scene};

const CEILING: usize = 1;
/// Pixels on a side.
const SIDE: usize = 128;
/// Paths a pixel of a photograph.
const PATHS: u32 = 256;
/// Pixels of the floor whose error is measured, and paths in each.
const SAMPLE: (usize, u32) = (4000, 16);

/// The floors: both roughnesses, and the direction in degrees.
const FLOORS: [[f32; 3]; 3] = [[0.07, 0.11, 0.0], [0.05, 0.2, 0.0], [0.07, 0.11, 35.0]];

fn main() {
    let first = std::env::args().nth(1).and_then(|n| n.parse().ok()).unwrap_or(0);
    let only = std::env::args().nth(1).is_some();
    for (i, floor) in FLOORS.into_iter().enumerate().skip(first) {
        if only && i > first {
            break;
        }
        let mut materials = truth(floor[2]);
        (materials[FLOOR].alpha_x, materials[FLOOR].alpha_y) = (floor[0], floor[1]);
        box_with(&scene(&materials), floor, i == 0);
    }
}

fn box_with(scene: &Scene, floor: [f32; 3], shows_errors: bool) {
    let tracer = Tracer::new(scene);
    let camera = camera();
    let view = View::new(&tracer, &camera, (SIDE, SIDE), scene.brdf);
    let settings = Settings { spp: PATHS, seed: 77, ..Settings::default() };
    let film = tracer.render(&scene.materials(), &camera, (SIDE, SIDE), &settings, &|_| ());
    let count = SIDE * SIDE;
    let picture = Picture {
        values: film.mean,
        valid: Image::new(SIDE, SIDE, vec![true; count]),
        saturated: Image::new(SIDE, SIDE, vec![false; count]),
        quantisation_step: RgbImage::new(SIDE, SIDE, vec![Rgb::ZERO; count]),
    };
    let observation = Observation::new(picture, view.geometry(), scene.groups.len());
    if shows_errors {
        print_errors(&observation, &view, scene);
    }
    let mut groups: Vec<GroupSpec> = scene.groups.iter().map(GroupSpec::of).collect();
    groups[CEILING].role = Role::Known;
    let problem = Problem::new(&observation, &view, groups);
    for direction in [Direction::Rerender, Direction::Text] {
        let options = Options { spp: 2, ..Options::default() };
        let paper = Paper { direction, ..Paper::default() };
        let found = recover(&problem, &options, &paper, &mut (), None).unwrap();
        println!("\n{floor:?}, {direction:?}: {} global re-renderings", found.iterations.len());
        for (group, truth) in found.groups.iter().zip(scene.materials()) {
            let Material { rho_d, rho_s, alpha_x, alpha_y, theta_rad, .. } = group.material;
            let rgb = |v: Rgb| format!("{:.4} {:.4} {:.4}", v.x, v.y, v.z);
            let shape = [alpha_x, alpha_y, theta_rad.to_degrees()];
            let off = (rho_d - truth.rho_d).abs().max_element();
            println!(
                "| {} | {} | {} (off {off:.4}) | {} | {shape:.4?} |",
                group.name,
                group.hypothesis.name(),
                rgb(rho_d),
                rgb(rho_s)
            );
        }
        for (name, c) in
            found.groups.iter().flat_map(|g| g.selection_log.iter().map(|c| (&g.name, c)))
        {
            let ResidualStats { squared, deviation, .. } = c.residual;
            println!(
                "  {name} iteration {} {} error {:.1} %, squared {squared:.5} +- {deviation:.5} {:?}",
                c.iteration,
                c.hypothesis.name(),
                100.0 * c.residual.total(),
                [c.material.rho_d.x, c.material.rho_s.x, c.material.alpha_x, c.material.alpha_y]
            );
        }
    }
}

/// Prints one row for each rung: the error of the best floor of that rung, with the truth for everything else, by
/// separate paths for each pixel and by the gathered light.
fn print_errors(observation: &Observation, view: &View<'_>, scene: &Scene) {
    let options = Options::default();
    let stage =
        Stage { observation, camera: (&[], &[]), exposure: Rgb::ONE, renderer: view, seen: None };
    let probe = ProbeSettings {
        probes_per_pixel: 4,
        cosine: 4,
        per_lobe: 6,
        lobes: ProposalLobe::round(&[0.02, 0.06, 0.16, 0.4]),
        mirror: 1,
        keep_incident: true,
        seed: 5,
        ..ProbeSettings::default()
    };
    let allowance = sample_budget::allowance(sample_budget::Level::Refined, &options);
    let budget = SampleBudget { pixels: SAMPLE.0, pixels_seed: 5, allowance, probe };
    let mut materials = scene.materials();
    let pixels = &observation.pixels_of_group[FLOOR];
    let evidence = Evidence::gather(&stage, (&materials).into(), FLOOR, pixels, &budget);
    let sample: Vec<u32> = evidence.sample.pixels.iter().map(|p| p.pixel).collect();
    let observed = stage.observe(FLOOR, &sample);
    let mut lobes = Lobes::new(evidence.clone());
    let isotropic = lobes.isotropic(&Material::diffuse(Rgb::ZERO)).material;
    println!("| rung | rho_s | error, paths | squared | error, light | squared |");
    println!("|---|---|---|---|---|---|");
    for rung in hypothesis::UNIFORM {
        let floor = match rung {
            Hypothesis::Isotropic => isotropic.clone(),
            Hypothesis::Anisotropic => lobes.anisotropic(&isotropic).material,
            _ => hypothesis::fit(rung, &evidence, &isotropic, Search::Local).material,
        };
        materials[FLOOR] = floor.clone();
        let by_paths = [0u64, 1].map(|seed| {
            let settings = Settings { spp: SAMPLE.1, seed, ..Settings::default() };
            view.rerender((&materials).into(), &sample, &settings)
        });
        let by_light = evidence.light.radiance(&floor);
        let cells = [by_paths, by_light].map(|halves| {
            let ResidualStats { with_noise, deviation, .. } = residual_stats(&observed, &halves);
            let error = 100.0 * with_noise.max(0.0).sqrt();
            format!("{error:.1} % | {with_noise:.5} +- {deviation:.5}")
        });
        println!("| {} | {:.3} | {} |", rung.name(), floor.rho_s.x, cells.join(" | "));
    }
}
