//! The channels of an EXR file, by their names.

use exr::prelude::{AnyChannel, FlatSamples, ReadChannels, ReadLayers, Text};
use std::collections::BTreeMap;
use std::path::Path;
use unrender::scene::Rgb;

/// The channels of a file of floats, a value for every pixel.
pub(crate) struct Channels(BTreeMap<String, Vec<f32>>);

impl Channels {
    pub(crate) fn read(path: &Path) -> Self {
        let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
        let image = reader.first_valid_layer().all_attributes().from_file(path).unwrap();
        let channel = |channel: AnyChannel<FlatSamples>| match channel.sample_data {
            FlatSamples::F32(samples) => (Text::to_string(&channel.name), samples),
            _ => panic!("{} is not of floats", channel.name),
        };
        Self(image.layer_data.channel_data.list.into_iter().map(channel).collect())
    }

    /// The values of the channel called `name`.
    #[track_caller]
    pub(crate) fn of(&self, name: &str) -> &[f32] {
        self.0.get(name).unwrap_or_else(|| panic!("no {name} among {:?}", self.0.keys()))
    }

    /// The three channels with these names after `prefix`.
    #[track_caller]
    pub(crate) fn three(&self, prefix: &str, names: [&str; 3]) -> Vec<Rgb> {
        let [a, b, c] = names.map(|name| self.of(&format!("{prefix}{name}")));
        (0..a.len()).map(|i| Rgb::new(a[i], b[i], c[i])).collect()
    }

    /// The colours of the pass called `name`.
    #[track_caller]
    pub(crate) fn colours(&self, name: &str) -> Vec<Rgb> {
        self.three(&format!("ViewLayer.{name}."), ["R", "G", "B"])
    }
}
