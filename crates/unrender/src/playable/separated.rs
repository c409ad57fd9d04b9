//! The light of a picture, separated by lamp, and its derivative by the colour of each group, all on the same paths.

use unrender_formats::materials;
use unrender_render::denoise::ratios::{Ratio, Smoother};
use unrender_render::{Appearance, Integrator, Jacobian, Parameter, Query, Settings, Tracer};
use unrender_scene::color::luminance;
use unrender_scene::{Camera, ENVIRONMENT, Material, Reflectance, Rgb, RgbImage, Scene};

/// Pixels whose derivatives are in memory at a time, beside the sums. Half of it and double of it take the same time.
const BLOCK: usize = 4096;

/// A diffuse reflectance below this gives a surface no colour of its own. Metals come out with less than half of it, and
/// dark paint that shines has double of it.
const COLOURLESS: f32 = 0.05;

/// The light of one lamp, or of all around.
#[derive(Clone, Debug)]
pub(crate) struct Lamp {
    /// Its name.
    pub(crate) name: String,
    /// Whether it was on in the photograph.
    pub(crate) is_on: bool,
    /// The share of its light in that of all lamps, each at full brightness.
    pub(crate) share: RgbImage,
}

/// What a colour is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ColourOf {
    /// The diffuse reflectance, which is uniform.
    Diffuse,
    /// The specular reflectance.
    Specular,
    /// The mean of a texture.
    Texture,
}

/// What the colour of a group does to the picture.
#[derive(Clone, Debug)]
pub(crate) struct Colour {
    /// The colour as it is.
    pub(crate) own: OwnColour,
    /// The relative change of the picture per unit of the colour: `J / L`.
    pub(crate) response: RgbImage,
}

/// A lamp, before its light is known.
pub(super) struct Source {
    name: String,
    /// Its places in the layout of sources: several of an environment in parts.
    pub(super) places: Vec<u32>,
    is_on: bool,
}

/// The colour that a group has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OwnColour {
    /// The group's number.
    pub(crate) group: usize,
    /// What it is of.
    pub(crate) of: ColourOf,
    /// A reflectance per channel.
    pub(crate) now: Rgb,
}

impl OwnColour {
    /// The parameter of the colour.
    pub(super) fn parameter(&self) -> Parameter {
        match self.of {
            ColourOf::Specular => Parameter::RhoS(self.group as u32),
            ColourOf::Diffuse | ColourOf::Texture => Parameter::RhoD(self.group as u32),
        }
    }

    /// The colour of a unit of the parameter, which for a texture is a factor on it.
    pub(super) fn unit(&self) -> Rgb {
        match self.of {
            ColourOf::Texture => self.now.max(Rgb::splat(f32::MIN_POSITIVE)),
            ColourOf::Diffuse | ColourOf::Specular => Rgb::ONE,
        }
    }
}

/// The light of a picture in parts.
pub(super) struct Separated {
    pub(super) lamps: Vec<Lamp>,
    pub(super) colours: Vec<Colour>,
}

/// A scene whose lamps and colours are played with.
pub(super) struct Stage<'a> {
    /// The scene with all lamps on.
    scene: &'a Scene,
    pub(super) tracer: &'a Tracer,
    pub(super) materials: Vec<Material>,
    /// The factor on each source in the photograph: zero where it was off.
    pub(super) lights: Vec<Rgb>,
    pub(super) camera: Camera,
    pub(super) size: (usize, usize),
}

impl<'a> Stage<'a> {
    /// The scene with all lamps on, of which those with the numbers `off` were off in the photograph.
    pub(super) fn new(
        (scene, tracer): (&'a Scene, &'a Tracer),
        off: &[usize],
        camera: Camera,
    ) -> Self {
        let count = scene.groups.len() + scene.lights.len();
        let mut lights = vec![Rgb::ONE; scene.environment_parts().end.max(count)];
        off.iter().for_each(|source| lights[*source] = Rgb::ZERO);
        Self { scene, tracer, materials: scene.materials(), lights, camera, size: (0, 0) }
    }

    /// The scene in the photograph's light.
    pub(super) fn now(&self) -> Appearance<'_> {
        Appearance { materials: &self.materials, lights: &self.lights }
    }

    /// The lamps. All of an environment is one.
    pub(super) fn lamps(&self) -> Vec<Source> {
        let around = self.scene.environment_parts();
        let mut lamps: Vec<Source> = Vec::new();
        for place in self.tracer.light_sources() {
            let is_further = place > around.start && around.contains(&place);
            if let Some(environment) = lamps.last_mut().filter(|_| is_further) {
                environment.places.push(place as u32);
                continue;
            }
            let source = self.scene.sources().find(|source| source.index == place);
            let name = source.map_or(ENVIRONMENT, |source| source.name).to_owned();
            let is_on = self.lights[place] != Rgb::ZERO;
            lamps.push(Source { name, places: vec![place as u32], is_on });
        }
        lamps
    }

    /// The colour of each group that has objects.
    pub(super) fn colours(&self) -> Vec<OwnColour> {
        let paint = |(group, material): (usize, &Material)| {
            let (of, now) = match &material.texture {
                Some(texture) => (ColourOf::Texture, materials::mean_of(&texture.image)),
                None if is_metallic(material) => (ColourOf::Specular, material.rho_s),
                None => (ColourOf::Diffuse, material.rho_d),
            };
            OwnColour { group, of, now }
        };
        let is_there =
            |paint: &OwnColour| self.scene.objects.iter().any(|object| object.group == paint.group);
        self.materials.iter().enumerate().map(paint).filter(is_there).collect()
    }
}

/// Whether the specular reflectance is what gives a surface its colour. A plastic's has none.
fn is_metallic(material: &Material) -> bool {
    !matches!(material.reflectance, Reflectance::Dielectric { .. })
        && luminance(material.rho_s) > luminance(material.rho_d)
        && material.rho_d.max_element() < COLOURLESS
}

/// Separates the light of a picture.
pub(super) fn separate(
    stage: &Stage<'_>,
    settings: &Settings,
    progress: &dyn Fn(f64),
) -> Separated {
    let (lamps, colours) = (stage.lamps(), stage.colours());
    let traced = Traced::new(stage, (&lamps, &colours), settings, progress);
    let geometry = stage.tracer.geometry(&stage.camera, stage.size.0, stage.size.1);
    let smoother = Smoother::new(&stage.camera, &geometry);
    let smooth = |part: usize, under: [&RgbImage; 2]| {
        let numerator = [0, 1].map(|half| &traced.halves[half].parts[part]);
        smoother.smooth(&Ratio { numerator, denominator: under })
    };
    let whole = [0, 1].map(|half| &traced.halves[half].whole);
    let now = [0, 1].map(|half| &traced.halves[half].now);
    let mut shares: Vec<RgbImage> = (0..lamps.len()).map(|lamp| smooth(lamp, whole)).collect();
    whole_shares(&mut shares);
    let named = lamps.into_iter().zip(shares);
    let named: Vec<Lamp> =
        named.map(|(of, share)| Lamp { name: of.name, is_on: of.is_on, share }).collect();
    let colour = |(index, paint): (usize, &OwnColour)| {
        let response = smooth(named.len() + index, now).map(|response| *response / paint.unit());
        Colour { own: *paint, response }
    };
    let is_felt =
        |colour: &Colour| colour.response.pixels().iter().any(|response| *response != Rgb::ZERO);
    let colours = colours.iter().enumerate().map(colour).filter(is_felt).collect();
    Separated { lamps: named, colours }
}

/// Makes the shares of all lamps add up to one again.
fn whole_shares(shares: &mut [RgbImage]) {
    let count = shares.first().map_or(0, |share| share.pixels().len());
    for pixel in 0..count {
        let sum: Rgb = shares.iter().map(|share| share.pixels()[pixel]).sum();
        let scale = sum.map(|sum| if sum > 0.0 { 1.0 / sum } else { 0.0 });
        shares.iter_mut().for_each(|share| share.pixels_mut()[pixel] *= scale);
    }
}

/// The light of a picture in parts, twice with independent noise.
struct Traced {
    halves: [TracedHalf; 2],
}

/// One half of the paths.
struct TracedHalf {
    /// The light of each lamp, then the derivative by each colour.
    parts: Vec<RgbImage>,
    /// The light of all lamps, each at full brightness.
    whole: RgbImage,
    /// The light of the photograph.
    now: RgbImage,
}

impl Traced {
    fn new(
        stage: &Stage<'_>,
        (lamps, colours): (&[Source], &[OwnColour]),
        settings: &Settings,
        progress: &dyn Fn(f64),
    ) -> Self {
        let sources = lamps.iter().flat_map(|lamp| &lamp.places);
        let parameters = sources.map(|place| Parameter::Light(*place));
        let parameters: Vec<Parameter> =
            parameters.chain(colours.iter().map(OwnColour::parameter)).collect();
        let half = |half: u32| {
            let spp = settings.spp / 2;
            let first = settings.first + half * spp;
            let settings = Settings { spp, first, integrator: Integrator::Path, ..*settings };
            let progress = |done: f64| progress(0.5 * (f64::from(half) + done));
            Self::half(stage, (lamps, colours.len()), (&parameters, &settings), &progress)
        };
        Self { halves: [0, 1].map(half) }
    }

    fn half(
        stage: &Stage<'_>,
        (lamps, colours): (&[Source], usize),
        (parameters, settings): (&[Parameter], &Settings),
        progress: &dyn Fn(f64),
    ) -> TracedHalf {
        let (width, height) = stage.size;
        let pixels: Vec<u32> = (0..(width * height) as u32).collect();
        // The parts, all lamps together, and the photograph's light.
        let mut columns = vec![Vec::with_capacity(pixels.len()); lamps.len() + colours + 2];
        for block in pixels.chunks(BLOCK) {
            let query = Query { parameters, ..Query::new(stage.now(), block, settings) };
            let Jacobian { radiance, derivatives } =
                stage.tracer.jacobian(&stage.camera, stage.size, &query);
            for (row, now) in derivatives.chunks(parameters.len().max(1)).zip(&radiance) {
                let mut rest = row;
                for (lamp, column) in lamps.iter().zip(&mut columns) {
                    let (own, others) = rest.split_at(lamp.places.len());
                    column.push(own.iter().sum());
                    rest = others;
                }
                let all: Rgb = row[..row.len() - rest.len()].iter().sum();
                let others = rest.iter().copied().chain([all, *now]);
                let columns = columns[lamps.len()..].iter_mut();
                columns.zip(others).for_each(|(column, value)| column.push(value));
            }
            progress(f64::from(block[block.len() - 1] + 1) / pixels.len() as f64);
        }
        let image = |column: Vec<Rgb>| {
            let column = column
                .into_iter()
                .map(|v| if v.is_finite() { v.max(Rgb::ZERO) } else { Rgb::ZERO });
            RgbImage::new(width, height, column.collect())
        };
        let mut parts: Vec<RgbImage> = columns.into_iter().map(image).collect();
        let now = parts.pop().expect("the last column is the photograph's light");
        let whole = parts.pop().expect("the one before is all light");
        TracedHalf { parts, whole, now }
    }
}
