//! The records of a recovery in the form of run.json.

use super::{artist, memory};
use crate::Job;
use crate::engine::Recovered;
use crate::lighting::EnvironmentChoice;
use crate::project::CameraTable;
use crate::recovered::labels;
use crate::run::{
    CandidateEntry, DecisionEntry, Ended, EnvironmentEntry, GroupIterationEntry, Input,
    IterationEntry, LeftOut, MissEntry, PhotographRun, Pictures, Program, RegistrationEntry, Run,
    RunGroup, SettingsEntry, Stages, VERSION, Verdict,
};
use indexmap::IndexMap;
use serde_json::json;
use unrender_formats::materials::MaterialsFile;
use unrender_recover::record::CandidateRecord;
use unrender_recover::{Decision, GroupIteration, GroupResult, IterationRecord, Status};
use unrender_scene::Warnings;

/// The run; `materials` has the contents of materials.json, `pictures` and `balls` name files
/// beside it.
pub(super) fn build(
    job: &Job,
    recovered: &Recovered,
    materials: &MaterialsFile,
    (mut pictures, balls, misses): (Vec<Pictures>, Vec<Option<String>>, &[Option<MissEntry>]),
    warnings: Warnings,
) -> Run {
    let recovery = &recovered.recovery;
    let iterations = recovery.iterations.iter().zip(&recovered.times.iterations);
    let (parts, labels) = (recovered.parts(job), labels::labels(&job.scene));
    let named = |part: &Vec<usize>| part.iter().map(|object| labels[*object].clone()).collect();
    let alike = recovered.alike(job);
    let groups = recovery.groups.iter().enumerate().map(|(index, result)| {
        let agrees_with = alike.get(result.name.as_str()).into_iter().flatten();
        let entry = materials.groups.get(&result.name).cloned().unwrap_or_default();
        let of_group = recovered.group_map.pixels().iter().zip(recovery.status.pixels());
        let status = of_group.filter(|(group, _)| **group as usize == index).map(|(_, t)| t);
        let group = RunGroup {
            entry,
            asked: result.status != Status::Known,
            parts: parts.get(&index).into_iter().flatten().map(named).collect(),
            agrees_with: agrees_with.map(|name| (*name).to_owned()).collect(),
            error_share: result.error_share.filter(|share| share.is_finite()),
            counted: LeftOut::count(status),
            map_color: super::hex(super::group_picture::color(index)),
            ball: balls[index].clone(),
            miss: misses[index],
            artist: Some(artist::entry(job.scene.brdf, &result.material)),
            selection_log: result.selection_log.iter().map(candidate).collect(),
            decisions: result.decisions.iter().map(decision).collect(),
        };
        (result.name.clone(), group)
    });
    let groups: IndexMap<String, RunGroup> = groups.collect();
    Run {
        version: VERSION,
        program: Program {
            unrender: env!("CARGO_PKG_VERSION").to_owned(),
            system: std::env::consts::OS.to_owned(),
            processor: std::env::consts::ARCH.to_owned(),
        },
        command: std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect(),
        input: input(job),
        settings: settings(job, recovered),
        seconds: recovered.times.all,
        stages: stages(recovered),
        peak_memory_bytes: memory::peak_bytes(),
        termination: recovery.termination.message(recovery.iterations.len()),
        ended: Ended::of(recovery.termination),
        verdict: Verdict::of(groups.values()),
        warnings: warnings.0,
        exposure: recovery.exposure.to_array(),
        photograph: recovered.photographs[0].clone(),
        photographs: photographs(job, recovered, &pictures),
        exposure_std: recovery.exposure_std.map(|std| std.to_array()),
        registration: registration(job, recovered),
        pixels: LeftOut::count(recovery.status.pixels()),
        pictures: pictures.swap_remove(0),
        iterations: iterations
            .map(|(record, seconds)| iteration(record, *seconds, &recovery.groups))
            .collect(),
        groups,
        lights: materials.lights.clone(),
        environment: recovered.scene(job).environment.as_ref().map(EnvironmentEntry::of),
    }
}

/// Each of several photographs, with its `pictures`; empty if there is only one.
fn photographs(job: &Job, recovered: &Recovered, pictures: &[Pictures]) -> Vec<PhotographRun> {
    let one = |(k, pictures): (usize, &Pictures)| {
        let (alone, of_it) = (job.alone(k), recovered.alone(job, k));
        PhotographRun {
            photo: alone.project.photo.clone(),
            width: alone.photograph_size().0,
            height: alone.photograph_size().1,
            exposure: recovered.exposure_of(job, k).to_array(),
            photograph: of_it.photographs[0].clone(),
            lights_off: off(&alone),
            registration: registration(&alone, &of_it),
            pixels: LeftOut::count(of_it.recovery.status.pixels()),
            pictures: pictures.clone(),
        }
    };
    if pictures.len() == 1 { Vec::new() } else { pictures.iter().enumerate().map(one).collect() }
}

/// The names of the lights that were off.
fn off(job: &Job) -> Vec<String> {
    let sources = job.scene.sources();
    let off = sources.filter(|source| job.off.contains(&(source.index as u32)));
    off.map(|source| source.name.to_owned()).collect()
}

fn input(job: &Job) -> Input {
    Input {
        project: job.project.path.clone(),
        scene: job.project.scene.clone(),
        photo: job.project.photo.clone(),
        bracket: job.project.bracket.as_ref().map_or(Vec::new(), |frames| frames.files.clone()),
        environment: job.project.environment.as_ref().and_then(EnvironmentChoice::in_words),
        up_axis: job.project.up_axis,
        width: job.photograph_size().0,
        height: job.photograph_size().1,
        side: job.side,
    }
}

fn settings(job: &Job, recovered: &Recovered) -> SettingsEntry {
    let Recovered { options, paper, .. } = recovered;
    let thresholds = &options.thresholds;
    let mut named: IndexMap<String, f64> = [
        ("explained", Some(thresholds.explained)),
        ("simpler", thresholds.simpler),
        ("textured", Some(thresholds.textured)),
        ("dispersion", Some(thresholds.dispersion)),
    ]
    .into_iter()
    .filter_map(|(name, value)| Some((name.to_owned(), value.filter(|v| v.is_finite())?)))
    .collect();
    if let Some(paper) = paper {
        let rungs = unrender_recover::Hypothesis::ALL.iter().zip(paper.thresholds);
        named.extend(rungs.map(|(rung, value)| (rung.name().to_owned(), value)));
    }
    SettingsEntry {
        brdf: job.scene.brdf.name().to_owned(),
        ladder: if paper.is_some() { "paper" } else { "default" }.to_owned(),
        effort: options.effort.name().to_owned(),
        refine: options.refine && paper.is_none(),
        seed: options.seed,
        spp: options.spp,
        max_bounces: options.max_bounces,
        threads: rayon::current_num_threads(),
        thresholds: named,
    }
}

/// The time per stage: iterations of the ladder come before passes of the refinement.
fn stages(recovered: &Recovered) -> Stages {
    let times = &recovered.times;
    let iterations = recovered.recovery.iterations.iter().zip(&times.iterations);
    let mut climbed =
        iterations.filter(|(iteration, _)| !iteration.refining).map(|(_, seconds)| *seconds);
    let climbed = climbed.next_back().unwrap_or(times.developed);
    let refined = times.iterations.last().copied().unwrap_or(climbed);
    Stages {
        registration: times.registered,
        camera: times.developed - times.registered,
        ladder: climbed - times.developed,
        refinement: refined - climbed,
        picture: times.all - refined,
    }
}

/// How the model was registered with the photograph, and the camera that was used.
fn registration(job: &Job, recovered: &Recovered) -> RegistrationEntry {
    let registered = &recovered.registered[0];
    let table = CameraTable::of(&recovered.camera(job), 1.0, job.scene.origin);
    let lens = table.lens;
    let camera = json!({
        "eye": table.eye.to_array(),
        "target": table.target.to_array(),
        "up": table.up.to_array(),
        "fov_y_deg": table.fov_y_deg,
        "near": table.near,
        "principal_point": lens.principal_point,
        "fx_over_fy": lens.fx_over_fy,
        "k1": lens.k1,
        "k2": lens.k2,
        "k3": lens.k3,
        "p1": lens.p1,
        "p2": lens.p2,
    });
    let found = registered.registration.as_ref();
    let side = job.side as f32;
    RegistrationEntry {
        camera,
        displacement_pixels: found.map(|r| side * r.displacement),
        uncertainty_pixels: found.map(|r| side * r.uncertainty),
        deviation_pixels: found.map(|r| side * r.deviation),
        confirmed_edge_points: found.map(|r| r.confirmed),
    }
}

fn iteration(record: &IterationRecord, seconds: f64, groups: &[GroupResult]) -> IterationEntry {
    let asked = groups.iter().zip(&record.groups).filter(|(g, _)| g.status != Status::Known);
    IterationEntry {
        iteration: record.iteration,
        refining: record.refining,
        seconds,
        change: Some(record.change).filter(|v| v.is_finite()),
        worst_error: Some(record.worst_error).filter(|v| v.is_finite()),
        open_groups: record.open_groups.clone(),
        groups: asked.map(|(g, iteration)| (g.name.clone(), group_iteration(iteration))).collect(),
    }
}

fn group_iteration(iteration: &GroupIteration) -> GroupIterationEntry {
    let material = &iteration.material;
    GroupIterationEntry {
        hypothesis: iteration.hypothesis,
        error: iteration.error.filter(|e| e.is_finite()),
        rho_d: material.rho_d.to_array(),
        rho_s: material.rho_s.to_array(),
        alpha_x: material.alpha_x,
        alpha_y: material.alpha_y,
        theta_deg: material.theta_rad.to_degrees(),
    }
}

fn decision(decision: &Decision) -> DecisionEntry {
    let finite = |value: f64| Some(value).filter(|value| value.is_finite());
    let mut entry = DecisionEntry {
        iteration: decision.iteration,
        from: decision.from,
        to: decision.to,
        rule: decision.rule.name().to_owned(),
        difference: finite(decision.difference),
        deviation: finite(decision.deviation),
        price: finite(decision.price),
        sigmas: None,
        accepted: decision.accepted,
    };
    entry.sigmas = entry.gain_in_sigmas();
    entry
}

fn candidate(record: &CandidateRecord) -> CandidateEntry {
    let material = &record.material;
    CandidateEntry {
        iteration: record.iteration,
        hypothesis: record.hypothesis,
        error: Some(record.residual.relative()).filter(|e| e.is_finite()),
        deviation_of_square: Some(record.residual.deviation).filter(|d| d.is_finite()),
        model_error: Some(record.model_error).filter(|e| e.is_finite()),
        criterion: Some(record.criterion).filter(|c| c.is_finite()),
        rho_d: material.rho_d.to_array(),
        rho_s: material.rho_s.to_array(),
        alpha_x: material.alpha_x,
        alpha_y: material.alpha_y,
        theta_deg: material.theta_rad.to_degrees(),
        accepted: record.accepted,
    }
}
