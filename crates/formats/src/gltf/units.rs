//! Which units the lights of a file are in: as asked for, as noted in the file, or by its generator.

use super::document::{Asset, Document};
use super::ward::EXTRAS_KEY;
use super::ward::object;
use super::{Problem, container};
use crate::input::Scope;
use crate::{FileError, Input, LightUnits};
use serde::Deserialize;
use serde_json::{Value, json};

/// The beginning of `generator` in files by Blender's exporter; its version follows.
const BLENDER: &str = "Khronos glTF Blender I/O v";
/// What our own files say that wrote them.
pub(super) const GENERATOR: &str = "unrender";
/// The first version whose lights are not in watts.
const FIRST_IN_CANDELA: (u32, u32) = (3, 4);
const NOTE: &str = "light_units";

/// The units of the lights of the glTF file `input`, as [`read`](super::read()) takes them.
///
/// # Errors
/// If the file cannot be read.
pub fn light_units<'a>(input: impl Into<Input<'a>>) -> Result<LightUnits, FileError> {
    #[derive(Deserialize)]
    struct Head {
        asset: Asset,
    }
    let input = input.into();
    let fail = |problem: Problem| FileError::new(input.path, problem);
    let bytes = Scope::new(input).read(input.path).map_err(fail)?;
    let parts = container::split(&bytes).map_err(fail)?;
    let head: Head = serde_json::from_slice(parts.json)
        .map_err(|error| fail(format!("is not valid glTF 2.0: {error}; export the scene again")))?;
    Ok(of(&head.asset, input.light_units))
}

/// The units of a file's lights, where `asked` for, else as the file says.
pub(super) fn of(asset: &Asset, asked: Option<LightUnits>) -> LightUnits {
    asked
        .or_else(|| noted(asset))
        .unwrap_or_else(|| by_generator(asset.generator.as_str().unwrap_or_default()))
}

fn noted(asset: &Asset) -> Option<LightUnits> {
    asset.extras[EXTRAS_KEY][NOTE].as_str()?.parse().ok()
}

/// Whether the cones of spots are as Blender's exporter writes them: in its own files, and in ours in its units.
pub(super) fn has_blenders_cones(asset: &Asset) -> bool {
    let generator = asset.generator.as_str().unwrap_or_default();
    let in_its_units = noted(asset).is_some_and(|units| units != LightUnits::Radiometric);
    generator.starts_with(BLENDER) || generator == GENERATOR && in_its_units
}

fn by_generator(generator: &str) -> LightUnits {
    let Some(version) = generator.strip_prefix(BLENDER) else { return LightUnits::Radiometric };
    let mut numbers = version.split('.').map(|number| number.parse().unwrap_or(0));
    let version = (numbers.next().unwrap_or(0), numbers.next().unwrap_or(0));
    if version < FIRST_IN_CANDELA { LightUnits::BlenderRaw } else { LightUnits::BlenderStandard }
}

/// The warning of how the lights of `document` were read, where its generator decided that.
pub(super) fn warning(document: &Document, units: LightUnits) -> Option<String> {
    let read_as = match units {
        LightUnits::Radiometric | LightUnits::Unitless => return None,
        LightUnits::BlenderStandard => "Blender's Standard units: candela and lux of 683 lm/W",
        LightUnits::BlenderRaw => "Blender's Raw units: watts and W/m^2",
    };
    let has_lights = !document.extensions.punctual.lights.is_empty();
    (has_lights && noted(&document.asset).is_none()).then(|| {
        format!(
            "lights read as {read_as}, as the file's generator writes them; if the export had another \
             Lighting Mode, say so by light_units in the project, or --light-units"
        )
    })
}

/// Notes in the file `root` that its lights are in `units`.
pub(super) fn note(root: &mut Value, units: LightUnits) {
    let extras = object(&mut root["asset"]).entry("extras").or_insert_with(|| json!({}));
    let own = object(extras).entry(EXTRAS_KEY).or_insert_with(|| json!({}));
    object(own).insert(NOTE.into(), json!(units.name()));
}
