//! Made-up results of recoveries: all fields of run.json filled, all pictures present.

use indexmap::IndexMap;
use std::path::Path;
use unrender::formats::materials::{
    AlternativeEntry, GroupEntry, LightEntry, PanoramaEntry, PhotographEntry, PhotographStd,
    ReflectanceEntry, StdEntry,
};
use unrender::formats::picture;
use unrender::run::{
    ArtistEntry, CandidateEntry, DecisionEntry, DifferenceEntry, Ended, ErrorPicture,
    GroupIterationEntry, Input, IterationEntry, LeftOut, MissEntry, Pictures, Program,
    RegistrationEntry, Run, RunGroup, SettingsEntry, Stages, Stop, Unit, VERSION, Verdict,
};
use unrender::scene::{Hypothesis, Image, Rgb};

/// Columns of the group map's grid of cells.
pub(crate) const COLUMNS: usize = 8;

/// The name of the group that could not be recovered.
pub(crate) const FAILED: &str = "failed";

/// A number between 0 and 1 with many digits, different for each `seed`.
fn noise(seed: usize) -> f64 {
    let mixed = (seed as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11) as f64 / (1u64 << 53) as f64
}

fn triple(seed: usize) -> [f32; 3] {
    [0, 1, 2].map(|channel| noise(3 * seed + channel) as f32)
}

/// Writes run.json and its pictures, of `width` x `height` pixels, into `folder`.
pub(crate) fn write(folder: &Path, names: &[String], (width, height): (usize, usize)) -> Run {
    std::fs::create_dir_all(folder.join("report")).unwrap();
    let rows = names.len().div_ceil(COLUMNS);
    let cell = |x: usize, y: usize| (y * rows / height) * COLUMNS + x * COLUMNS / width;
    let color = |group: usize| [(40 + 3 * group) as u8, (200 - 2 * group) as u8, 90];
    let grainy = |scale: f64| {
        Image::from_fn(width, height, |x, y| {
            let grain = noise(y * width + x) as f32 * 0.05;
            let [r, g, b] = triple(cell(x, y));
            Rgb::new(r, g, b) * scale as f32 + Rgb::splat(grain)
        })
    };
    let write = |file: &str, image: &Image<Rgb>| {
        picture::write_png_srgb(&folder.join(file), image).unwrap();
    };
    write("photo.png", &grainy(0.8));
    write("rerendered.png", &grainy(0.7));
    write("trust.png", &grainy(0.5));
    write("error.png", &grainy(0.4));
    // Code 191 is a quarter of the photograph's mean; the upper row of cells is not compared.
    let values = Image::from_fn(width, height, |_, y| {
        Rgb::splat(if y * rows < height { 0.0 } else { 191.0 / 255.0 })
    });
    std::fs::write(folder.join("report/values.png"), picture::png_bytes(&values).unwrap()).unwrap();
    let flat = Image::from_fn(width, height, |x, y| match cell(x, y) {
        group if group < names.len() => Rgb::from_array(color(group).map(|c| f32::from(c) / 255.0)),
        _ => Rgb::ZERO,
    });
    std::fs::write(folder.join("report/groups.png"), picture::png_bytes(&flat).unwrap()).unwrap();
    let errors = [(true, Unit::Share), (false, Unit::Radiance), (true, Unit::Noise)];
    let errors = errors.into_iter().enumerate().map(|(index, (signed, unit))| {
        let file = format!("report/error_{index}.png");
        write(&file, &grainy(0.3));
        let stop = |i: usize| Stop { value: i as f32 / 7.0 - 0.3, color: "#884422".into() };
        ErrorPicture { file, signed, unit, reach: 2, bar: (0..9).map(stop).collect() }
    });
    let errors = errors.collect();
    let groups = names.iter().enumerate().map(|(index, name)| {
        let ball = format!("report/ball_{index}.png");
        write(&ball, &Image::from_fn(32, 32, |_, _| Rgb::from_array(triple(index))));
        let [r, g, b] = color(index);
        let map_color = format!("#{r:02x}{g:02x}{b:02x}");
        (name.clone(), RunGroup { map_color, ball: Some(ball), ..group(index, name) })
    });
    let groups: IndexMap<String, RunGroup> = groups.collect();
    let run = Run {
        pictures: Pictures {
            photo: "photo.png".into(),
            rerendered: "rerendered.png".into(),
            trust: "trust.png".into(),
            groups: "report/groups.png".into(),
            errors,
            difference: Some(DifferenceEntry {
                beyond_noise: 0.004_321,
                noise: 0.015_432,
                compared: 0.97,
                values: "report/values.png".into(),
            }),
            denoised: true,
        },
        verdict: Verdict::of(groups.values()),
        groups,
        iterations: (1..=6).map(|number| iteration(number, names)).collect(),
        input: Input { width, height, ..input() },
        ..rest()
    };
    run.write(folder).unwrap();
    run
}

/// Every key of a reflectance, in one group or another.
fn reflectance(index: usize) -> ReflectanceEntry {
    let named = |name: &str| Some(name.to_owned());
    match index {
        4 => ReflectanceEntry {
            reflectance: named("dielectric"),
            ior: Some(1.5),
            layering: named("coupled"),
            multiscatter: None,
        },
        5 => ReflectanceEntry {
            reflectance: named("metal"),
            multiscatter: Some(true),
            ..ReflectanceEntry::default()
        },
        _ => ReflectanceEntry::default(),
    }
}

fn group(index: usize, name: &str) -> RunGroup {
    if name == FAILED {
        let note = "it may be isotropic: rendering noise leaves that open";
        let mut failed = known(index);
        failed.entry.status = Some(serde_json::from_str("\"assumed\"").unwrap());
        failed.entry.note = Some(note.to_owned());
        failed.asked = true;
        return failed;
    }
    let hypothesis = Hypothesis::ALL[index % 6];
    let alternative = AlternativeEntry {
        hypothesis: Some(Hypothesis::Isotropic),
        rho_d: Some(triple(index + 50)),
        rho_s: Some(triple(index + 60)),
        alpha_x: Some(noise(index + 9) as f32),
        alpha_y: Some(noise(index + 9) as f32),
        theta_deg: Some(0.0),
        error: Some(noise(index + 11)),
    };
    let entry = GroupEntry {
        hypothesis: Some(hypothesis),
        status: Some(serde_json::from_str("\"recovered\"").unwrap()),
        alpha_x: Some(noise(index + 400) as f32),
        alpha_y: Some(noise(index + 401) as f32),
        theta_deg: Some(90.0 * noise(index + 402) as f32),
        rho_s: (!index.is_multiple_of(6)).then(|| triple(index + 500)),
        albedo_d: (index == 4).then(|| triple(index + 550)),
        reflectance: reflectance(index),
        std: Some(std(index)),
        error: Some(noise(index + 600) * 0.1),
        alternatives: if index == 5 { vec![alternative] } else { Vec::new() },
        note: (index % 7 == 3).then(|| "rho_d and rho_s are tied together".to_owned()),
        ..known(index).entry
    };
    let selection_log =
        Hypothesis::ALL[..6].iter().enumerate().map(|(rung, other)| CandidateEntry {
            iteration: 3,
            hypothesis: *other,
            error: Some(noise(index + 700 + rung)),
            deviation_of_square: Some(noise(index + rung)),
            model_error: Some(0.02),
            criterion: Some(10.0),
            rho_d: triple(index + rung),
            rho_s: triple(index + 2 * rung),
            alpha_x: 0.1,
            alpha_y: 0.1,
            theta_deg: 0.0,
            accepted: *other == hypothesis,
        });
    let decision = DecisionEntry {
        iteration: 3,
        from: Hypothesis::Diffuse,
        to: hypothesis,
        rule: ["light samples", "prediction", "simpler"][index % 3].into(),
        difference: Some(-120.5),
        deviation: Some(14.0),
        price: Some(21.0),
        sigmas: Some(120.5 / 14.0),
        accepted: index > 0,
    };
    let selection_log = if index == 0 { Vec::new() } else { selection_log.collect() };
    RunGroup {
        entry,
        selection_log,
        decisions: vec![decision],
        asked: true,
        parts: if index == 4 { vec![vec!["a".into()], vec!["b".into()]] } else { Vec::new() },
        agrees_with: if index == 2 { vec![FAILED.to_owned()] } else { Vec::new() },
        error_share: Some(if index == 3 { 0.0002 } else { noise(index + 800) }),
        miss: Some(miss(index)),
        artist: Some(artist(index)),
        ..known(index)
    }
}

fn std(index: usize) -> StdEntry {
    StdEntry {
        rho_d: Some(triple(index + 100).map(|v| 1e-3 * v)),
        rho_s: Some(triple(index + 200).map(|v| 1e-6 * v)),
        alpha_x: Some(noise(index + 300) as f32 * 0.01),
        alpha_y: Some(noise(index + 301) as f32 * 0.01),
        theta_deg: Some(noise(index + 302) as f32),
    }
}

fn miss(index: usize) -> MissEntry {
    MissEntry {
        too_bright: 0.3 * noise(index + 801),
        too_dark: 0.3 * noise(index + 802),
        largest: noise(index + 803) - 0.5,
        place: [noise(index + 804), noise(index + 805)],
        photograph: 1,
    }
}

fn artist(index: usize) -> ArtistEntry {
    ArtistEntry {
        color: "#a1b2c3".to_owned(),
        base_color: if index == 2 { "#112233" } else { "#a1b2c3" }.to_owned(),
        roughness: noise(index + 806) as f32,
        metallic: index == 5,
        ior: (index == 4).then_some(1.5),
        glossy: index == 2,
    }
}

fn known(index: usize) -> RunGroup {
    let entry = GroupEntry {
        hypothesis: Some(Hypothesis::Diffuse),
        status: Some(serde_json::from_str("\"known\"").unwrap()),
        rho_d: Some(triple(index)),
        pixels: Some(1000 + index as u64),
        ..GroupEntry::default()
    };
    let counted = LeftOut { valid: 900 + index, edge: 70, outlier: 30, ..LeftOut::default() };
    RunGroup { entry, counted, ..RunGroup::default() }
}

fn iteration(number: usize, names: &[String]) -> IterationEntry {
    let group = |(index, name): (usize, &String)| {
        let entry = GroupIterationEntry {
            hypothesis: Hypothesis::ALL[index % 6],
            error: Some(noise(index + number) / 10f64.powi(number as i32)),
            rho_d: triple(index + number),
            rho_s: triple(index + number + 1),
            alpha_x: noise(index + number) as f32,
            alpha_y: noise(index + number) as f32,
            theta_deg: 0.0,
        };
        (name.clone(), entry)
    };
    IterationEntry {
        iteration: number,
        refining: number > 4,
        seconds: 1.5 * number as f64 + noise(number),
        change: Some(noise(number) * 1e-4),
        worst_error: Some(noise(number) / 10f64.powi(number as i32)),
        open_groups: Vec::new(),
        groups: names.iter().enumerate().filter(|(_, n)| *n != FAILED).map(group).collect(),
    }
}

fn input() -> Input {
    Input {
        project: "rooms/<i>12</i>/room.toml".into(),
        scene: "rooms/12/room.glb".into(),
        photo: "rooms/12/photo 1.jpg".into(),
        ..Input::default()
    }
}

fn photograph() -> PhotographEntry {
    let std = PhotographStd {
        gamma: Some(0.0123),
        vignetting: Some([0.01, 0.02, 0.03]),
        corner: Some(0.0045),
        exposure: Some([0.01, 0.02, 0.03]),
    };
    PhotographEntry {
        gamma: Some(2.234_567),
        vignetting: Some([-0.123_456, 0.034_567, -0.001_234]),
        corner: Some(0.912_345),
        exposure: Some([1.5, 1.25, 1.125]),
        std: Some(std),
        note: Some("gamma and exposure are tied together".into()),
    }
}

fn rest() -> Run {
    let panorama = PanoramaEntry {
        columns: 1,
        rows: 2,
        radiance: vec![triple(33), triple(34)],
        std: vec![triple(35), triple(36)],
    };
    let light =
        LightEntry { intensity: Some(triple(31)), std: Some(triple(32)), panorama: Some(panorama) };
    Run {
        version: VERSION,
        program: Program {
            unrender: "0.1.0".into(),
            system: "linux".into(),
            processor: "x86_64".into(),
        },
        command: ["unrender", "recover", "rooms/it's 12.toml"].map(str::to_owned).to_vec(),
        settings: SettingsEntry {
            brdf: "ward-gmd".into(),
            ladder: "default".into(),
            effort: "normal".to_owned(),
            refine: true,
            seed: 7,
            spp: 64,
            max_bounces: 48,
            threads: 2,
            thresholds: [("explained".to_owned(), 0.01)].into_iter().collect(),
        },
        seconds: 82.718_281_828,
        stages: Stages {
            registration: 1.25,
            camera: 0.5,
            ladder: 31.4159,
            refinement: 40.5,
            picture: 9.55,
        },
        peak_memory_bytes: Some(223_456_789),
        termination: "refined together after 6 global re-renderings".into(),
        ended: Some(Ended::Converged),
        warnings: vec!["the lamp \"<b>a & b</b>\" is 3 m away".into()],
        exposure: triple(21),
        exposure_std: Some(triple(22)),
        photograph: Some(photograph()),
        registration: RegistrationEntry {
            displacement_pixels: Some(0.31),
            ..RegistrationEntry::default()
        },
        pixels: LeftOut { valid: 12345, edge: 678, clipped: 90, spike: 1, outlier: 2, nothing: 3 },
        lights: [("la<mp".to_owned(), light)].into_iter().collect(),
        ..Run::default()
    }
}
