//! The passes of a picture for compositing programs: from its sums, and from what the camera sees first.

use crate::output::Encoding;
use unrender_formats::picture::{LightLayer, Matte, Pass, Passes, Values};
use unrender_render::{Accumulator, FirstHits, Tracer, layers};
use unrender_scene::{ENVIRONMENT, RgbImage, Scene};

/// The sums of a picture.
pub(crate) struct Sums<'a> {
    /// All of it.
    pub(crate) picture: &'a Accumulator,
    /// The part of it that has been reflected once at most.
    pub(crate) direct: &'a Accumulator,
    /// The contribution of each light.
    pub(crate) lights: Vec<LightLayer>,
}

/// The passes of a picture of `scene`, at the exposure of `encoding`.
pub(crate) fn of(scene: &Scene, sums: Sums<'_>, hits: FirstHits, encoding: Encoding) -> Passes {
    let exposed = |picture: RgbImage| encoding.exposed(picture);
    let indirect = layers::indirect(sums.picture, sums.direct);
    let colour = |name, picture| Pass { name, values: Values::Colour(picture) };
    let vector = |name, picture| Pass { name, values: Values::Vector(picture) };
    let place = hits.position.map(|here| here.map_or(glam::Vec3::ZERO, |here| world(scene, here)));
    Passes {
        picture: exposed(sums.picture.mean()),
        lights: sums.lights.into_iter().map(|light| exposed_light(light, encoding)).collect(),
        others: vec![
            colour("Direct", exposed(sums.direct.mean())),
            colour("Indirect", exposed(indirect)),
            colour("Albedo", hits.albedo),
            vector("Normal", hits.normal),
            vector("Position", place),
            Pass { name: "Depth", values: Values::Distance(hits.depth) },
        ],
        groups: Matte {
            names: scene.groups.iter().map(|group| group.name.clone()).collect(),
            shares: hits.groups,
        },
    }
}

/// The position `here` of `scene` in the world of its file.
fn world(scene: &Scene, here: glam::Vec3) -> glam::Vec3 {
    scene.in_world(here).as_vec3()
}

fn exposed_light(light: LightLayer, encoding: Encoding) -> LightLayer {
    LightLayer { radiance: encoding.exposed(light.radiance), ..light }
}

/// The contributions of the lights called `names`, whose sums are the first of `layers`.
pub(crate) fn lights(names: &[String], layers: &[Accumulator]) -> Vec<LightLayer> {
    let layer = |(name, sum): (&String, &Accumulator)| LightLayer {
        name: name.clone(),
        radiance: sum.mean(),
    };
    names.iter().zip(layers).map(layer).collect()
}

/// The name of each light of `scene` that has a layer, no two of them the same.
pub(crate) fn light_names(scene: &Scene, tracer: &Tracer) -> Vec<String> {
    let around = scene.environment_parts();
    let name = |place: usize| match place.checked_sub(around.start) {
        Some(part) if around.len() > 1 => format!("{ENVIRONMENT} {part}"),
        _ => {
            let source = scene.sources().find(|source| source.index == place);
            source.map_or_else(|| place.to_string(), |source| source.name.to_owned())
        }
    };
    let mut names: Vec<String> = Vec::new();
    for name in tracer.light_sources().into_iter().map(name) {
        let numbered = (2..).map(|number| format!("{name} {number}"));
        let free = std::iter::once(name.clone()).chain(numbered).find(|n| !names.contains(n));
        names.extend(free);
    }
    names
}
