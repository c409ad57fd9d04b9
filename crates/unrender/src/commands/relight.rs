//! `unrender relight`: a rendering in light layers with other brightnesses of its lights.

use super::encoding::EncodingArgs;
use crate::global::Global;
use crate::{Error, interrupt, output};
use std::path::PathBuf;
use std::process::ExitCode;
use std::str::FromStr;
use unrender_formats::picture::{self, LightLayer};
use unrender_formats::{FileError, Input};
use unrender_render::layers;
use unrender_scene::{Rgb, RgbImage};

/// Makes lights of a rendering brighter or darker, at once: by the sum of its light layers.
///
/// `unrender render --layers` and `--aov` write the contribution of each light. The picture with other brightnesses is their
/// sum, each times its factor; nothing is traced again.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender render room.glb --layers --spp 256 --out layers.exr\n  \
    unrender relight layers.exr --light lamp=0.5 --light environment=2,1.8,1.5 --out evening.png\n  \
    unrender relight layers.exr --only lamp --out lamp_alone.exr")]
pub struct Args {
    /// A rendering with light layers.
    #[arg(value_name = "LAYERS.exr")]
    pub layers: PathBuf,
    /// The factor on the brightness of a light, for all channels or for red, green and blue; once for each
    /// light that changes. 0 is off.
    #[arg(long, value_name = "NAME=FACTOR")]
    pub light: Vec<LightFactor>,
    /// A light that is on, all others being off; once for each.
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// How the picture is written.
    #[command(flatten)]
    pub encoding: EncodingArgs,
    /// The picture to write: .exr or .hdr (linear radiance), or .png (8-bit sRGB).
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
}

/// What layers call the light from all around.
const ENVIRONMENT: &str = "environment";

/// A light and the factor on its brightness.
#[derive(Clone, Debug, PartialEq)]
pub struct LightFactor {
    /// The light's name.
    pub name: String,
    /// At least zero, per channel.
    pub factor: Rgb,
}

impl FromStr for LightFactor {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // Names may have an equals sign.
        let (name, factor) = text.rsplit_once('=').ok_or("write a name and a factor: lamp=0.5")?;
        let number = |text: &str| {
            let factor = text.trim().parse().ok();
            let fits = factor.filter(|f: &f32| f.is_finite() && *f >= 0.0);
            fits.ok_or_else(|| format!("{text:?} is not a factor: give a number of at least 0"))
        };
        let factors = factor.split(',').map(number).collect::<Result<Vec<f32>, String>>()?;
        let factor = match factors[..] {
            [all] => Rgb::splat(all),
            [r, g, b] => Rgb::new(r, g, b),
            _ => return Err("give one factor, or three for red, green and blue".into()),
        };
        Ok(Self { name: name.to_owned(), factor })
    }
}

/// Runs the command.
///
/// # Errors
/// If the layers cannot be read, a light is not among them, or the picture cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    output::check_picture(&args.out)?;
    output::check_inputs(&args.out, [args.layers.as_path()])?;
    args.encoding.check(&args.out)?;
    if args.layers.is_dir() {
        let problem = "is a folder. Render its scene with the light of each lamp first: unrender render --project \
                       PROJECT.toml --materials FOLDER --layers --out layers.exr";
        return Err(FileError::new(&args.layers, problem).into());
    }
    let layers = picture::read_layers(Input::new(&args.layers, global.limits()))?;
    let factors = factors(args, &layers)?;
    let radiances: Vec<RgbImage> = layers.into_iter().map(|layer| layer.radiance).collect();
    let relit = layers::relight(&radiances, &factors)
        .ok_or_else(|| FileError::new(&args.layers, "has no light in it: nothing can be relit"))?;
    let _until_written = interrupt::writing();
    let encoding = args.encoding.encoding();
    picture::write_in(&args.out, &encoding.exposed(relit), encoding.space)?;
    Ok(ExitCode::SUCCESS)
}

/// The factor on each of `layers`.
fn factors(args: &Args, layers: &[LightLayer]) -> Result<Vec<Rgb>, Error> {
    let asked = args.light.iter().map(|light| &light.name).chain(&args.only);
    for name in asked {
        if !layers.iter().any(|layer| is_meant(name, layer)) {
            let there: Vec<String> = layers.iter().map(|l| format!("\"{}\"", l.name)).collect();
            let problem = format!("has no light \"{name}\"; it has {}", there.join(", "));
            return Err(FileError::new(&args.layers, problem).into());
        }
    }
    let is_on = |layer: &LightLayer| {
        args.only.is_empty() || args.only.iter().any(|name| is_meant(name, layer))
    };
    let in_vain = |light: &&LightFactor| {
        !layers.iter().any(|layer| is_meant(&light.name, layer) && is_on(layer))
    };
    if let Some(light) = args.light.iter().find(in_vain) {
        let name = &light.name;
        return Err(Error::Request(format!(
            "--light {name}=... changes nothing, as --only leaves it off: add --only \"{name}\""
        )));
    }
    let factor = |layer: &LightLayer| {
        let asked = args.light.iter().rfind(|light| is_meant(&light.name, layer));
        if is_on(layer) { asked.map_or(Rgb::ONE, |light| light.factor) } else { Rgb::ZERO }
    };
    Ok(layers.iter().map(factor).collect())
}

/// Whether `name` means the light of `layer`: a recovered environment has several, which have their number behind it.
fn is_meant(name: &str, layer: &LightLayer) -> bool {
    let of_environment = |number: &str| {
        number.strip_prefix(' ').is_some_and(|number| number.parse::<usize>().is_ok())
    };
    layer.name == name
        || name == ENVIRONMENT && layer.name.strip_prefix(name).is_some_and(of_environment)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_lights_of_an_environment_are_meant_by_its_name() {
        let layer = |name: &str| LightLayer {
            name: name.to_owned(),
            radiance: RgbImage::new(1, 1, vec![Rgb::ONE]),
        };
        let layers = ["lamp", "environment 0", "environment 12", "environments"].map(layer);
        let asked = |light: &str, only: &[&str]| {
            let light = vec![LightFactor::from_str(light).unwrap()];
            let only = only.iter().map(|name| (*name).to_owned()).collect();
            let [layers_at, out] = ["l.exr", "o.png"].map(PathBuf::from);
            let encoding = EncodingArgs::default();
            let args = Args { layers: layers_at, light, only, encoding, out };
            factors(&args, &layers).map(|factors| factors.iter().map(|f| f.x).collect::<Vec<_>>())
        };
        assert_eq!(asked("environment=0.5", &[]).unwrap(), [1.0, 0.5, 0.5, 1.0]);
        assert_eq!(asked("environment=2", &["environment"]).unwrap(), [0.0, 2.0, 2.0, 0.0]);
        assert_eq!(asked("environment 12=3", &[]).unwrap(), [1.0, 1.0, 3.0, 1.0]);
        let error = asked("lamp=2", &["environment"]).unwrap_err().to_string();
        assert!(error.contains("changes nothing, as --only leaves it off"), "{error}");
    }

    #[test]
    fn a_factor_is_one_number_or_three() {
        let factor = |text: &str| LightFactor::from_str(text);
        let lamp = |factor| LightFactor { name: "lamp".into(), factor };
        assert_eq!(factor("lamp=0.5"), Ok(lamp(Rgb::splat(0.5))));
        assert_eq!(factor("lamp=1, 2,0"), Ok(lamp(Rgb::new(1.0, 2.0, 0.0))));
        assert_eq!(factor("a=b=2").unwrap().name, "a=b");
        for bad in ["lamp", "lamp=", "lamp=-1", "lamp=inf", "lamp=1,2", "lamp=1,2,3,4"] {
            assert!(factor(bad).is_err(), "{bad}");
        }
    }
}
