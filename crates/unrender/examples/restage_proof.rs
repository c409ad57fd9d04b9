//! Compares restaged pictures with the truth: prints the figures of `docs/guides/restage.md`.
//!
//! ```text
//! cargo run --release --example restage_proof -- composite PROJECT.toml DIR TRUTH.exr
//! cargo run --release --example restage_proof -- view EDIT.toml TRUTH.json SPP
//! ```
//!
//! `composite` compares what `unrender restage --composite --out DIR` made of the photograph of
//! `PROJECT.toml` with the true picture `TRUTH.exr`, radiance, over the pixels that it touched. The
//! photograph of `examples/room` was rendered with 1024 paths a pixel under the seed 2002
//! (`make_room`); if the true picture was too (`unrender restage EDIT.toml --materials
//! examples/room/truth.json --spp 1024 --seed 2002`), both are equal where nothing changes, except
//! for the sensor's noise.
//!
//! `view` applies the edits to the scene with its recovered materials and with those of `TRUTH.json`,
//! renders both from the edits' camera with the same seed, and compares them group by group, in all
//! pixels whose surface the photograph shows too.

use glam::Vec3;
use std::error::Error;
use std::path::Path;
use unrender::edit::{EditSheet, Flag, Photograph, Restaging, Start};
use unrender::formats::picture;
use unrender::render::{NOTHING, PixelGeometry, Settings, Tracer};
use unrender::scene::{Image, Rgb, RgbImage};

type Fallible<T> = Result<T, Box<dyn Error>>;

fn main() -> Fallible<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["composite", project, folder, truth] => {
            composite(project, Path::new(folder), Path::new(truth))
        }
        ["view", edits, truth, spp] => {
            let read = || EditSheet::read(Path::new(edits));
            let recovered = Restaging::load(vec![read()?])?;
            let truth =
                Restaging::load(vec![read()?, EditSheet::of_flag(Flag::Materials, truth)?])?;
            view(&recovered, &truth, &Settings { spp: spp.parse()?, ..Settings::default() })
        }
        _ => {
            Err("usage: restage_proof composite PROJECT DIR TRUTH.exr | view EDIT TRUTH SPP".into())
        }
    }
}

/// Renders the scene after its edits.
fn render(restaging: &Restaging, settings: &Settings) -> Fallible<RgbImage> {
    let photograph = photograph(restaging)?;
    let camera = &restaging.view.cameras()[0];
    let materials = restaging.after.materials();
    let tracer = Tracer::new(&restaging.after);
    Ok(tracer.render(&materials, camera, photograph.size(), settings, &|_| ()).mean)
}

fn photograph(restaging: &Restaging) -> Fallible<&Photograph> {
    Ok(restaging.start.photograph.as_ref().ok_or("the edits name no project")?)
}

fn composite(project: &str, folder: &Path, truth: &Path) -> Fallible<()> {
    let (start, _) = Start::load(&[EditSheet::of_flag(Flag::Project, project)?])?;
    let photograph = start.photograph.ok_or("the project has no photograph")?;
    let picture = |path: &Path| picture::read(path).map(|(picture, _)| picture.values);
    let truth = picture(truth)?;
    let mask = |name: &str| picture(&folder.join(name));
    let (touched, invented) = (mask("touched.png")?, mask("invented.png")?);
    let is_touched = |i: usize| touched.pixels()[i].x > 0.0;
    let is_invented = |i: usize| invented.pixels()[i].x > 0.0;
    let made = mask("composite.png")?;
    let photo = &photograph.picture.values;
    let all = 0..photo.pixels().len();
    let count = all.clone().filter(|&i| is_touched(i)).count();
    let same = |i: &usize| made.pixels()[*i] == photo.pixels()[*i];
    let kept = all.clone().filter(|&i| !is_touched(i)).filter(same).count();
    println!("{count} of {} pixels touched, {kept} of the others have their codes", all.len());
    for (name, made) in [
        ("composite", picture(&folder.join("composite.exr"))?),
        ("synthetic", picture(&folder.join("synthetic.exr"))?),
        ("photograph", photograph.photo.radiance.clone()),
    ] {
        let touched = psnr(&photograph, &made, &truth, &is_touched);
        print!("{name:<10}  {touched:5.1} dB where it is touched");
        if all.clone().any(is_invented) {
            print!(", {:5.1} dB where invented", psnr(&photograph, &made, &truth, &is_invented));
        }
        println!(", {:5.1} dB elsewhere", psnr(&photograph, &made, &truth, &|i| !is_touched(i)));
    }
    Ok(())
}

/// The peak signal-to-noise ratio in codes of the photograph, over the pixels that `counts`.
fn psnr(
    photograph: &Photograph,
    made: &RgbImage,
    truth: &RgbImage,
    counts: &dyn Fn(usize) -> bool,
) -> f64 {
    let codes =
        |radiance| photograph.transfer.codes(radiance).map(|c| c.clamp(Rgb::ZERO, Rgb::ONE));
    let (made, truth) = (codes(made), codes(truth));
    let (mut squares, mut count) = (0.0, 0.0);
    for index in (0..made.pixels().len()).filter(|&index| counts(index)) {
        let error = made.pixels()[index] - truth.pixels()[index];
        squares += f64::from(error.length_squared());
        count += 3.0;
    }
    -10.0 * (squares / count).log10()
}

fn view(recovered: &Restaging, truth: &Restaging, settings: &Settings) -> Fallible<()> {
    let photograph = photograph(recovered)?;
    let (width, height) = photograph.size();
    let (made, real) = (render(recovered, settings)?, render(truth, settings)?);
    let camera = &recovered.view.cameras()[0];
    let geometry = Tracer::new(&recovered.after).geometry(camera, width, height);
    let before = Tracer::new(&recovered.start.scene);
    let shown = before.geometry(&photograph.camera, width, height);
    let seen = Image::from_fn(width, height, |x, y| {
        let pixel = geometry.at(x, y);
        let direction = camera.direction(x as f32 + 0.5, y as f32 + 0.5, width, height);
        let point = camera.origin() + pixel.depth * direction;
        pixel.group != NOTHING && is_seen(photograph, &shown, pixel, point)
    });
    println!("{:<14} pixels  seen     mean |error|  mean error", "group");
    for (index, group) in recovered.after.groups.iter().enumerate() {
        let of_group = |i: &usize| geometry.pixels()[*i].group as usize == index;
        let pixels: Vec<usize> = (0..made.pixels().len()).filter(of_group).collect();
        let counted: Vec<usize> = pixels.iter().copied().filter(|&i| seen.pixels()[i]).collect();
        if counted.is_empty() || group.is_emitter() {
            continue;
        }
        let sum = |f: &dyn Fn(usize) -> Vec3| {
            counted.iter().map(|&i| f64::from(f(i).element_sum())).sum::<f64>()
        };
        let (made, real) = (made.pixels(), real.pixels());
        let level = sum(&|i| real[i]);
        println!(
            "{:<14} {:6}  {:6}  {:10.2} %  {:8.2} %",
            group.name,
            pixels.len(),
            counted.len(),
            100.0 * sum(&|i| (made[i] - real[i]).abs()) / level,
            100.0 * sum(&|i| made[i] - real[i]) / level
        );
    }
    Ok(())
}

/// Whether the photograph shows the point of a pixel of the new view.
fn is_seen(
    photograph: &Photograph,
    shown: &Image<PixelGeometry>,
    pixel: &PixelGeometry,
    point: Vec3,
) -> bool {
    let (width, height) = photograph.size();
    let Some((x, y)) = photograph.camera.project(point, width, height) else { return false };
    let there = shown.at(x as usize, y as usize);
    let distance = (point - photograph.camera.origin()).length();
    there.group == pixel.group && (there.depth / distance - 1.0).abs() < 0.02
}
