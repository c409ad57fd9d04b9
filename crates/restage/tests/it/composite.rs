//! The change of an edit in the photograph, against the photograph of the changed room.
//!
//! Photographs are renderings of the true room; the model has no textures and wrong reflectances,
//! as a recovery may leave it.

use crate::common::{self, SIZE, camera, cuboid, insertion, model, picture, psnr, truth};
use glam::Vec3;
use unrender_render::{Settings, Tracer};
use unrender_restage::composite::{Gain, Photograph, composite};
use unrender_restage::insert::Place;
use unrender_restage::pair::{self, Paired, Scenes};
use unrender_restage::remove::{Bearer, Remove};
use unrender_restage::repaint::{Paint, Repaint};
use unrender_restage::{Edit, apply, touched};
use unrender_scene::{Image, Material, Rgb, RgbImage, Scene};

/// Paths a pixel where pictures are compared by their noise.
const SPP: u32 = 200;
/// A code of 8 bits, about, where these pictures are bright.
const STEP: f32 = 0.004;

/// A photograph before the edits, the truth after them, and the composite made from the first.
struct Case {
    photograph: RgbImage,
    truth: RgbImage,
    before: Scene,
    paired: Image<Paired>,
    touched: Image<Option<Rgb>>,
}

impl Case {
    fn new(real: Scene, before: Scene, edits: &[Edit]) -> Self {
        Self::of_paths(SPP, real, before, edits)
    }

    /// The same by `spp` paths a pixel.
    fn of_paths(spp: u32, mut real: Scene, mut before: Scene, edits: &[Edit]) -> Self {
        before.validate().unwrap();
        let photograph = picture(&real, spp);
        apply(&mut real, edits).unwrap();
        let truth = picture(&real, spp);
        let mut after = before.clone();
        let change = apply(&mut after, edits).unwrap();
        let scenes = Scenes { before: &before, after: &after, change: &change };
        let settings = Settings { spp, ..Settings::default() };
        let paired = pair::render(&scenes, &camera(), SIZE, &settings, &|_| ());
        let geometry = Tracer::new(&before).geometry(&camera(), SIZE.0, SIZE.1);
        let step = photograph.map(|_| Rgb::splat(STEP));
        let touched = touched::touched(&paired, &geometry, &step);
        Self { photograph, truth, before, paired, touched }
    }

    fn composite(&self, gain: Gain) -> RgbImage {
        let photograph = Photograph {
            radiance: &self.photograph,
            clipped: &self.photograph.map(|_| false),
            geometry: &Tracer::new(&self.before).geometry(&camera(), SIZE.0, SIZE.1),
            materials: &self.before.materials(),
        };
        let after = pair::after(&self.paired);
        composite(&photograph, (&self.paired, &after), &self.touched, gain).radiance
    }

    fn is_touched(&self, index: usize) -> bool {
        self.touched.pixels()[index].is_some()
    }

    /// The group that the photograph shows in each pixel.
    fn group(&self, name: &str) -> impl Fn(usize) -> bool {
        let geometry = Tracer::new(&self.before).geometry(&camera(), SIZE.0, SIZE.1);
        let group = self.before.group_index(name).unwrap() as u32;
        move |index| geometry.pixels()[index].group == group
    }
}

#[test]
fn an_inserted_box_is_as_in_the_photograph_with_it() {
    let case = Case::new(truth(), model(), &[Edit::Insert(insertion(0.3, 0.2))]);
    let made = case.composite(Gain::Auto);
    let quality = psnr(&made, &case.truth, |i| case.is_touched(i));
    let nothing = psnr(&case.photograph, &case.truth, |i| case.is_touched(i));
    println!("{quality:.1} dB, {nothing:.1} dB without the box");
    assert!(quality > 40.0 && nothing < 30.0, "{quality:.1} dB, {nothing:.1} dB");
    let same = |i: usize| made.pixels()[i] == case.photograph.pixels()[i];
    let untouched: Vec<usize> = (0..made.pixels().len()).filter(|i| !case.is_touched(*i)).collect();
    assert!(untouched.len() > made.pixels().len() / 4, "{} untouched", untouched.len());
    assert!(untouched.iter().all(|i| same(*i)));
    shadows_keep_the_texture_by_the_ratio(&case);
    the_noise_of_the_change_is_far_below_that_of_the_picture(&case);
}

fn shadows_keep_the_texture_by_the_ratio(case: &Case) {
    let floor = case.group("floor");
    let [auto, difference, ratio] = [Gain::Auto, Gain::Difference, Gain::Ratio].map(|gain| {
        psnr(&case.composite(gain), &case.truth, |i| {
            case.is_touched(i) && case.paired.pixels()[i].replaced == 0.0 && floor(i)
        })
    });
    println!("floor: {auto:.1} dB, by difference {difference:.1}, by ratio {ratio:.1}");
    assert!(auto > difference + 2.0 && auto >= ratio - 0.1);
}

fn the_noise_of_the_change_is_far_below_that_of_the_picture(case: &Case) {
    let back = case.group("back");
    let pixels = (0..case.paired.pixels().len()).filter(|i| back(*i));
    let (mut change, mut picture) = (0.0, 0.0);
    for pixel in pixels.map(|i| &case.paired.pixels()[i]).filter(|p| p.replaced == 0.0) {
        change += pixel.change_variance.y;
        picture += pixel.before_variance.y + pixel.after_variance.y;
    }
    println!("variance {:.4} of what independent renderings would have", change / picture);
    assert!(change < 0.2 * picture, "{}", change / picture);
}

#[test]
fn the_mirror_shows_the_box_and_the_wall_its_colour() {
    let case = Case::new(truth(), model(), &[Edit::Insert(insertion(-1.2, -0.4))]);
    let made = case.composite(Gain::Auto);
    let mirror = case.group("mirror");
    let in_mirror = |i: usize| mirror(i) && case.paired.pixels()[i].replaced == 1.0;
    let shown: Vec<usize> = (0..made.pixels().len()).filter(|i| in_mirror(*i)).collect();
    let sum = |of: &RgbImage| shown.iter().map(|&i| of.pixels()[i]).sum::<Rgb>();
    let off = (sum(&made) / sum(&case.truth) - 1.0).abs().max_element();
    let red = shown.iter().filter(|i| made.pixels()[**i].x > 3.0 * made.pixels()[**i].y).count();
    println!("{red} red pixels in the mirror, their mean {:.2} % off", 100.0 * off);
    assert!(red > 20 && off < 0.03, "{red} red pixels, {off} off");
    // The floor before the box turns redder than it darkens.
    let floor = case.group("floor");
    let bleeding = (0..made.pixels().len()).filter(|&i| {
        let ratio = made.pixels()[i] / case.photograph.pixels()[i];
        floor(i) && case.paired.pixels()[i].replaced == 0.0 && ratio.x > 1.05 * ratio.z
    });
    assert!(bleeding.count() > 10);
}

#[test]
fn what_no_path_meets_changes_nothing() {
    let with_crate = || {
        let mut scene = model();
        let (low, high) = (Vec3::new(-0.5, 0.0, -0.9), Vec3::new(0.5, 0.9, 0.1));
        common::add(&mut scene, "crate", Material::diffuse(Rgb::splat(0.4)), cuboid(low, high));
        scene
    };
    let mut insert = insertion(0.0, 0.0);
    insert.place = Place::At(Vec3::new(0.0, 0.2, -0.4).as_dvec3());
    // Nothing differs, however few paths are used.
    let case = Case::of_paths(16, with_crate(), with_crate(), &[Edit::Insert(insert)]);
    for pixel in case.paired.pixels() {
        assert_eq!(pixel.before, pixel.after);
        assert_eq!((pixel.change_variance, pixel.replaced), (Rgb::ZERO, 0.0));
    }
    assert!(case.touched.pixels().iter().all(Option::is_none));
}

#[test]
fn a_removed_box_leaves_the_background_that_the_model_knows() {
    let with_box = |mut scene: Scene| {
        apply(&mut scene, &[Edit::Insert(insertion(0.3, 0.2))]).unwrap();
        scene
    };
    // The model has the textures here: the uncovered surfaces are rendered with them.
    let remove = Remove { name: "box.red".into(), what: Bearer::Any };
    let case = Case::new(with_box(truth()), with_box(truth()), &[Edit::Remove(remove)]);
    let made = case.composite(Gain::Auto);
    let uncovered = |i: usize| case.paired.pixels()[i].uncovered > 0.0;
    let [all, behind] =
        [psnr(&made, &case.truth, |i| case.is_touched(i)), psnr(&made, &case.truth, uncovered)];
    println!("{all:.1} dB, {behind:.1} dB of it uncovered");
    assert!(all > 40.0 && behind > 38.0, "{all:.1} dB, {behind:.1} dB");
    let box_pixels = case.group("box.red");
    let mut pixels = (0..made.pixels().len()).filter(|i| box_pixels(*i));
    assert!(pixels.all(uncovered), "all that showed the box is said to be invented");
}

#[test]
fn repainted_surfaces_are_synthetic_and_not_invented() {
    let paint = Paint { rho_d: Some(Rgb::new(0.1, 0.3, 0.6)), ..Paint::default() };
    let edit = Edit::Repaint(Repaint { group: "back".into(), paint });
    let case = Case::new(model(), model(), &[edit]);
    let back = case.group("back");
    for index in (0..case.paired.pixels().len()).filter(|i| back(*i)) {
        let pixel = &case.paired.pixels()[index];
        assert!(pixel.replaced > 0.0 && pixel.uncovered == 0.0);
    }
    let quality = psnr(&case.composite(Gain::Auto), &case.truth, |i| case.is_touched(i));
    assert!(quality > 38.0, "{quality:.1} dB");
}
