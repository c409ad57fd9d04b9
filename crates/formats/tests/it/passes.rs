//! Passes for compositing programs: their channels have the names of Blender and come back to the bit, the manifest names
//! every number, and every EXR says which colours it has.

use exr::meta::attribute::AttributeValue;
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};
use std::collections::BTreeMap;
use std::path::Path;
use unrender_formats::picture::{
    self, ColourSpace, LightLayer, Matte, Pass, Passes, RANKS, Values,
};
use unrender_scene::{Image, Rgb, RgbImage};

/// The channels of an EXR of floats, and its attributes.
struct Content {
    channels: BTreeMap<String, Vec<f32>>,
    shared: ImageAttributes,
    own: LayerAttributes,
}

impl Content {
    fn read(path: &Path) -> Self {
        let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
        let image = reader.first_valid_layer().all_attributes().from_file(path).unwrap();
        let channel = |channel: &exr::prelude::AnyChannel<FlatSamples>| match &channel.sample_data {
            FlatSamples::F32(samples) => (channel.name.to_string(), samples.clone()),
            _ => panic!("{} is not of floats", channel.name),
        };
        let channels = image.layer_data.channel_data.list.iter().map(channel).collect();
        Self { channels, shared: image.attributes, own: image.layer_data.attributes }
    }

    /// The three channels with these names after `prefix`.
    fn picture(&self, prefix: &str, names: [&str; 3]) -> Vec<[f32; 3]> {
        let [a, b, c] = names.map(|name| &self.channels[&format!("{prefix}{name}")]);
        (0..a.len()).map(|i| [a[i], b[i], c[i]]).collect()
    }

    /// The text of the attribute called `name`, as UTF-8.
    fn text(&self, name: &str) -> String {
        match self.own.other.get(name.as_bytes()) {
            Some(AttributeValue::Text(text)) => {
                String::from_utf8(text.as_slice().to_vec()).unwrap()
            }
            other => panic!("{name} is {other:?}"),
        }
    }
}

fn picture_of(value: f32) -> RgbImage {
    RgbImage::from_fn(3, 2, |x, y| Rgb::new(value, value + x as f32, value + 2.0 * y as f32))
}

/// A picture of three by two pixels; the first one shows two groups, the last one none.
fn passes() -> Passes {
    let mut shares = Image::from_fn(3, 2, |_, _| [(0, 0.0); RANKS]);
    shares.pixels_mut()[..5].iter_mut().for_each(|pixel| pixel[0] = (1, 1.0));
    shares.pixels_mut()[0][..2].copy_from_slice(&[(2, 0.75), (0, 0.25)]);
    let vector = picture_of(-3.0);
    Passes {
        picture: picture_of(1.0),
        lights: vec![LightLayer { name: "Lampe à pied".into(), radiance: picture_of(0.5) }],
        others: vec![
            Pass { name: "Albedo", values: Values::Colour(picture_of(0.25)) },
            Pass { name: "Normal", values: Values::Vector(vector) },
            Pass { name: "Depth", values: Values::Distance(Image::from_fn(3, 2, |_, _| 1e10)) },
        ],
        groups: Matte {
            names: ["floor", "wäll \"1\"", "屋根"].map(str::to_owned).into(), shares
        },
    }
}

const RGB: [&str; 3] = ["R", "G", "B"];

fn arrays(picture: &RgbImage) -> Vec<[f32; 3]> {
    picture.pixels().iter().map(|v| v.to_array()).collect()
}

#[test]
fn passes_have_the_names_of_blender_and_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.exr");
    let passes = passes();
    assert_eq!(picture::write_passes(&path, &passes, ColourSpace::LinRec709).unwrap(), 0);
    let first = std::fs::read(&path).unwrap();
    for _ in 0..5 {
        picture::write_passes(&path, &passes, ColourSpace::LinRec709).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), first, "the same bytes each time");
    }
    let content = Content::read(&path);
    for (prefix, expected) in [
        ("", &passes.picture),
        ("ViewLayer.Combined.", &passes.picture),
        ("ViewLayer.Combined_Lampe___pied.", &passes.lights[0].radiance),
        ("ViewLayer.Albedo.", &picture_of(0.25)),
    ] {
        assert_eq!(content.picture(prefix, RGB), arrays(expected), "{prefix}");
    }
    let normal = content.picture("ViewLayer.Normal.", ["X", "Y", "Z"]);
    assert_eq!(normal, arrays(&picture_of(-3.0)));
    assert_eq!(content.channels["ViewLayer.Depth.Z"], [1e10; 6]);
    // Our own readers find the picture and the lights.
    let (own, warnings) = picture::read(&path).unwrap();
    assert!(own.to_linear() == passes.picture && warnings.0.is_empty(), "{warnings:?}");
    assert_eq!(picture::read_layers(path.as_path()).unwrap(), passes.lights);
}

#[test]
fn the_manifest_names_every_number() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.exr");
    picture::write_passes(&path, &passes(), ColourSpace::AcesCg).unwrap();
    let content = Content::read(&path);
    let said = |what: &str| content.text(&format!("cryptomatte/c7dbf5e/{what}"));
    assert_eq!(said("name"), "ViewLayer.CryptoMaterial");
    assert_eq!(said("hash"), "MurmurHash3_32");
    assert_eq!(said("conversion"), "uint32_to_float32");
    let manifest: BTreeMap<String, String> = serde_json::from_str(&said("manifest")).unwrap();
    assert_eq!(manifest.keys().collect::<Vec<_>>(), ["floor", "wäll \"1\"", "屋根"]);
    let id = |name: &str| f32::from_bits(u32::from_str_radix(&manifest[name], 16).unwrap());
    let channel = |name: &str| &content.channels[&format!("ViewLayer.CryptoMaterial{name}")];
    let at = |pixel: usize| ["00.r", "00.g", "00.b", "00.a"].map(|name| channel(name)[pixel]);
    assert_eq!(at(0), [id("屋根"), 0.75, id("floor"), 0.25]);
    assert_eq!(at(1), [id("wäll \"1\""), 1.0, 0.0, 0.0]);
    assert_eq!(at(5), [0.0; 4]);
    for rank in ["01.r", "01.a", "02.g", "02.b"] {
        assert!(channel(rank).iter().all(|v| *v == 0.0), "{rank}");
    }
}

#[test]
fn colours_are_converted_and_other_passes_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let [plain, studio] = ["p.exr", "s.exr"].map(|name| folder.path().join(name));
    let passes = passes();
    picture::write_passes(&plain, &passes, ColourSpace::LinRec709).unwrap();
    picture::write_passes(&studio, &passes, ColourSpace::AcesCg).unwrap();
    let [plain, studio_content] = [&plain, &studio].map(|path| Content::read(path));
    let matrix = ColourSpace::AcesCg.from_rec709().as_mat3();
    let is_colour = |name: &str| name.ends_with(".R") || name == "R";
    for (name, values) in &plain.channels {
        let other = &studio_content.channels[name];
        if is_colour(name) {
            let prefix = name.strip_suffix('R').unwrap();
            let found = studio_content.picture(prefix, RGB);
            for (found, rec709) in found.into_iter().zip(plain.picture(prefix, RGB)) {
                let expected = matrix * Rgb::from(rec709);
                assert!(Rgb::from(found).abs_diff_eq(expected, 1e-6), "{name}");
            }
        } else if !name.ends_with(['G', 'B']) {
            assert_eq!(values, other, "{name}");
        }
    }
    // Back in the primaries of Rec. 709.
    let close = |a: &RgbImage, b: &RgbImage| {
        a.pixels().iter().zip(b.pixels()).all(|(a, b)| a.abs_diff_eq(*b, 1e-5))
    };
    assert!(close(&picture::read(&studio).unwrap().0.to_linear(), &passes.picture));
    let lights = picture::read_layers(studio.as_path()).unwrap();
    assert!(close(&lights[0].radiance, &passes.lights[0].radiance));
}

#[test]
fn every_exr_says_which_colours_it_has_and_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.exr");
    let values = RgbImage::from_fn(4, 3, |x, y| Rgb::new(x as f32, 0.25 * y as f32, 7.0));
    for space in ColourSpace::ALL {
        picture::write_in(&path, &values, space).unwrap();
        let stated = Content::read(&path).shared.chromaticities.unwrap();
        match space {
            ColourSpace::LinRec709 => assert_eq!((stated.red.0, stated.white.1), (0.64, 0.329)),
            ColourSpace::AcesCg => assert_eq!((stated.red.0, stated.white.1), (0.713, 0.33767)),
            _ => {}
        }
        let (back, warnings) = picture::read(&path).unwrap();
        let back = back.to_linear();
        let pairs = back.pixels().iter().zip(values.pixels());
        for (back, value) in pairs {
            assert!(back.abs_diff_eq(*value, 2e-5), "{space}: {back} for {value}");
        }
        assert!(warnings.0.is_empty(), "{space}: {warnings:?}");
        picture::write_denoised(&path, &values, space).unwrap();
        assert_eq!(Content::read(&path).shared.chromaticities.unwrap(), stated);
    }
    let merged =
        unrender_scene::Picture { values: values.clone(), ..picture::read(&path).unwrap().0 };
    picture::write_merged(&path, &merged).unwrap();
    assert!(Content::read(&path).shared.chromaticities.is_some());
    let channels = vec![("count".to_owned(), vec![1; 12])];
    let planes =
        unrender_formats::planes::Planes { width: 4, height: 3, text: "{}".into(), channels };
    unrender_formats::planes::write(&path, planes, &values).unwrap();
    let meta = exr::meta::MetaData::read_from_file(&path, false).unwrap();
    assert!(meta.headers[0].shared_attributes.chromaticities.is_some());
}

#[test]
fn a_png_stays_srgb_and_an_hdr_has_no_other_colours() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let values = picture_of(0.25);
    picture::write(&path("a.png"), &values).unwrap();
    picture::write_in(&path("b.png"), &values, ColourSpace::AcesCg).unwrap();
    let bytes = |name: &str| std::fs::read(path(name)).unwrap();
    assert_eq!(bytes("a.png"), bytes("b.png"));
    let error = picture::write_in(&path("a.hdr"), &values, ColourSpace::AcesCg).unwrap_err();
    assert!(error.to_string().contains("cannot say its colour space"), "{error}");
    assert!(!path("a.hdr").exists());
}
