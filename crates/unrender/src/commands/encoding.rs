//! How pictures are written: the flags that commands share.

use crate::Error;
use crate::output::{self, Encoding};
use std::path::Path;
use unrender_formats::FileError;
use unrender_formats::picture::{ColourSpace, HDR_OF_REC709};

/// The colour space of a picture that is written, and its exposure.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct EncodingArgs {
    /// The colour space of an .exr file, whose header states it: lin-rec709, acescg, lin-p3d65, lin-rec2020 or
    /// aces2065-1 [default: lin-rec709]. A PNG is sRGB in any case.
    #[arg(long, value_name = "NAME", visible_alias = "color-space", alias = "colorspace")]
    pub colour_space: Option<ColourSpace>,
    /// Makes the picture brighter by this many stops: each doubles it, and a negative number makes it darker
    /// [default: 0].
    #[arg(long, value_name = "STOPS", allow_negative_numbers = true, value_parser = stops)]
    pub exposure: Option<f32>,
}

impl EncodingArgs {
    pub(crate) fn encoding(&self) -> Encoding {
        Encoding {
            space: self.colour_space.unwrap_or_default(),
            factor: self.exposure.unwrap_or_default().exp2(),
        }
    }

    /// The flag that is given, if one is.
    pub(crate) fn given(&self) -> Option<&'static str> {
        let space = self.colour_space.map(|_| "--colour-space");
        space.or_else(|| self.exposure.map(|_| "--exposure"))
    }

    /// Checks that a picture can be written so to `out`.
    pub(crate) fn check(&self, out: &Path) -> Result<(), Error> {
        if self.encoding().space != ColourSpace::default() && output::extension(out) == "hdr" {
            return Err(FileError::new(out, HDR_OF_REC709).into());
        }
        Ok(())
    }
}

/// A number of stops whose factor is a number.
fn stops(text: &str) -> Result<f32, String> {
    let stops: f32 = text.parse().map_err(|_| "is no number")?;
    let fits = stops.is_finite() && stops.exp2().is_normal();
    if fits { Ok(stops) } else { Err("must be a number from -126 to 127".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_doubles() {
        assert_eq!(stops("-1.5"), Ok(-1.5));
        for bad in ["", "inf", "nan", "128", "-127", "1e9"] {
            assert!(stops(bad).is_err(), "{bad}");
        }
        let args = EncodingArgs { exposure: Some(3.0), ..EncodingArgs::default() };
        assert_eq!((args.encoding().factor, args.given()), (8.0, Some("--exposure")));
        assert_eq!(EncodingArgs::default().encoding(), Encoding::default());
    }
}
