//! Measures the error that `--denoise` leaves in pictures of 64 samples per pixel, and writes
//! docs/validation/denoise.md: `cargo run --release -p unrender --example measure_denoise`.
//!
//! The mean squared error of a picture `x` is the mean of `(x - a) (x - b)` with two independent references
//! `a` and `b`, which is unbiased however noisy these are. The bias is that of the mean of all seeds: with
//! the errors `e` of single pictures and `m` of the mean of `n`, its square is `(n m - e) / (n - 1)`.

use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use unrender::formats::{atomic, load_scene, materials};
use unrender::render::adaptive::SampleAllocation;
use unrender::render::{Accumulator, Settings, Tracer};
use unrender::scene::{Camera, Material, Rgb, RgbImage};

/// The scenes: examples of the repository, and what is hard about them.
const SCENES: [(&str, &str); 6] = [
    ("fig8", "lamps in view, glossy surfaces"),
    ("room", "many small things, mirror, carpet"),
    ("hall", "a tapestry: texture of high contrast"),
    ("corpus/textured", "textures, shadows"),
    ("corpus/plastic", "glossy surfaces of many shapes"),
    ("corpus/mirror", "mirrors and their caustics: rare bright paths"),
];
const SIDE: usize = 160;
const SPP: u32 = 64;
const SEEDS: u64 = 2;
const REFERENCE_SPP: u32 = 128;

const HEAD: &str = "# Denoising

What `unrender render --denoise` leaves of the error of a picture, and what bias it brings. This page is written by

```console
cargo run --release -p unrender --example measure_denoise
```
";

const NOTES: &str = "
Errors are root mean squares over all pixels and channels, relative to the mean radiance. *Estimated* is what the
command says: the error as the two halves of the samples tell it, without a reference. It misses what is wrong in both
halves alike. *Mean* is the signed error of the whole
picture's mean radiance. *Bias* is the share of the squared error that more seeds do not average away; the rest is noise. Shares of less than zero are the noise of this measurement.

References are pictures of independent paths with other seeds, without denoising; the error is taken against two of
them so that their own noise does not count. Caustics of mirrors leave the largest error: what a path finds once in
thousands of samples, no filter of one picture can tell from what is not there.
";

/// The sums over the seeds of one scene.
#[derive(Default)]
struct Row {
    before: f64,
    after: f64,
    estimated: f64,
    signed: f64,
    seconds: f64,
}

/// A scene, ready to be rendered.
struct Shot {
    tracer: Tracer,
    materials: Vec<Material>,
    camera: Camera,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut page = format!(
        "{HEAD}\n{SIDE} x {SIDE} pixels, {SPP} samples a pixel, {SEEDS} seeds; two references of {REFERENCE_SPP} \
         samples a pixel. Measured at commit {}.\n\n| scene | what is hard | error before | after | ratio | estimated | mean | bias | \
         seconds |\n|---|---|---|---|---|---|---|---|---|\n",
        commit()?
    );
    for (name, what) in SCENES {
        let line = measure(&Shot::load(name)?, name, what)?;
        print!("{line}");
        page.push_str(&line);
    }
    page.push_str(NOTES);
    Ok(atomic::write(&root().join("docs/validation/denoise.md"), page.as_bytes())?)
}

/// The commit of the measured code, and its date.
fn commit() -> Result<String, Box<dyn Error>> {
    let mut git = Command::new("git");
    let output = git.arg("-C").arg(root()).args(["log", "-1", "--format=%h of %cs"]).output()?;
    Ok(String::from_utf8(output.stdout)?.trim().to_owned())
}

impl Shot {
    fn load(name: &str) -> Result<Self, Box<dyn Error>> {
        let folder = root().join("examples").join(name);
        let (mut scene, _) = load_scene(&folder.join("scene.glb"))?;
        let truth = folder.join("truth.json");
        if truth.exists() {
            materials::apply_from(&truth, &mut scene)?;
        }
        scene.validate()?;
        let camera = scene.cameras.first().ok_or("the scene has no camera")?.clone();
        Ok(Self { tracer: Tracer::new(&scene), materials: scene.materials(), camera })
    }

    fn reference(&self, seed: u64) -> RgbImage {
        let settings = Settings { spp: REFERENCE_SPP, seed, ..Settings::default() };
        self.tracer.render(&self.materials, &self.camera, (SIDE, SIDE), &settings, &|_| {}).mean
    }

    fn half(&self, settings: &Settings, half: usize) -> Accumulator {
        let mut sum = Accumulator::new(SIDE, SIDE);
        let samples = (&SampleAllocation::Uniform(0..SPP), half);
        let Self { tracer, materials, camera } = self;
        tracer.accumulate_half(materials, camera, settings, samples, &mut sum, &|_| {});
        sum
    }
}

/// The row of the table.
fn measure(shot: &Shot, name: &str, what: &str) -> Result<String, Box<dyn Error>> {
    let references = [0, 1].map(|index| shot.reference((1 << 20) + index));
    let level = references.each_ref().map(mean).iter().sum::<f64>() / 2.0;
    let (mut row, mut sum) = (Row::default(), RgbImage::from_fn(SIDE, SIDE, |_, _| Rgb::ZERO));
    let n = SEEDS as f64;
    for seed in 0..SEEDS {
        let settings = Settings { seed, ..Settings::default() };
        let [first, second] = [0, 1].map(|half| shot.half(&settings, half));
        let started = Instant::now();
        let halves = [&first, &second];
        let denoised = shot.tracer.denoise(&shot.materials, &shot.camera, &settings, halves);
        row.seconds += started.elapsed().as_secs_f64() / n;
        let mut whole = first.clone();
        whole.add(&second);
        row.before += squared_error(&whole.mean(), &references) / n;
        row.after += squared_error(&denoised.radiance, &references) / n;
        row.estimated += denoised.error / n;
        row.signed += (mean(&denoised.radiance) / level - 1.0) / n;
        let pairs = sum.pixels_mut().iter_mut().zip(denoised.radiance.pixels());
        pairs.for_each(|(sum, pixel)| *sum += *pixel / SEEDS as f32);
    }
    let bias = (n * squared_error(&sum, &references) - row.after) / (n - 1.0);
    let mut line = String::new();
    let error = |squared: f64| 100.0 * squared.max(0.0).sqrt() / level;
    writeln!(
        line,
        "| {name} | {what} | {:.2} % | {:.2} % | {:.2} | {:.2} % | {:+.2} % | {:.0} % | {:.1} |",
        error(row.before),
        error(row.after),
        (row.after / row.before).sqrt(),
        100.0 * row.estimated,
        100.0 * row.signed,
        100.0 * bias / row.after,
        row.seconds
    )?;
    Ok(line)
}

/// The mean over pixels and channels.
fn mean(picture: &RgbImage) -> f64 {
    let sum: f64 = picture.pixels().iter().map(|p| f64::from(p.element_sum())).sum();
    sum / (3 * picture.pixels().len()) as f64
}

/// The mean squared error over pixels and channels.
fn squared_error(picture: &RgbImage, references: &[RgbImage; 2]) -> f64 {
    let [a, b] = references.each_ref().map(|reference| reference.pixels());
    let pixels = picture.pixels().iter().zip(a).zip(b);
    let sum: f64 = pixels.map(|((p, a), b)| (*p - *a).as_dvec3().dot((*p - *b).as_dvec3())).sum();
    sum / (3 * picture.pixels().len()) as f64
}
