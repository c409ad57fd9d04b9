//! The picture that a recovery shows while it works: `rerendered.png` in the folder of its results, from the first fit on.

use crate::result_folder::ResultFolder;
use std::time::{Duration, Instant};
use unrender_formats::picture;
use unrender_photo::Exposure;
use unrender_scene::{Rgb, RgbImage};

/// Its name, which is that of the last picture.
const FILE: &str = "rerendered.png";
/// The time between two pictures. At half of it a draft spends a tenth of its time on them, at double a quick one shows two.
const BETWEEN: Duration = Duration::from_secs(10);

/// The picture of a recovery that works.
pub(crate) struct GrowingPicture<'a> {
    folder: &'a ResultFolder,
    /// A linear value of one in the photograph, in units of the pictures that come.
    exposure: Rgb,
    last: Option<Instant>,
}

impl<'a> GrowingPicture<'a> {
    /// That of a recovery into `folder` of a photograph of this `exposure`; none if results are there already, which stay
    /// whole until the new ones are.
    pub(crate) fn new(folder: &'a ResultFolder, exposure: Exposure) -> Option<Self> {
        // A photograph of a fixed exposure was developed with it.
        let exposure = exposure.or_one();
        (!folder.has_results()).then_some(Self { folder, exposure, last: None })
    }

    /// Removes it from `folder`, where no results came of it.
    pub(crate) fn remove(folder: &ResultFolder) {
        folder.remove_grown(FILE);
    }

    /// Whether it is time for another one.
    pub(crate) fn is_due(&self) -> bool {
        self.last.is_none_or(|last| last.elapsed() >= BETWEEN)
    }

    /// Writes `rough`, linear values of the photograph, and says where it is the first time. A picture that cannot be
    /// written is not missed: the results say why at the end.
    pub(crate) fn show(&mut self, rough: &RgbImage) -> Option<String> {
        let is_first = self.last.is_none();
        let rough = rough.map(|radiance| *radiance / self.exposure);
        let written =
            self.folder.grow(FILE, |path| Ok(picture::write_png_srgb(path, &rough).map(drop)?));
        self.last = Some(Instant::now());
        let path = written.ok()?;
        is_first.then(|| format!("{} shows how far it is, from now on", path.display()))
    }
}
