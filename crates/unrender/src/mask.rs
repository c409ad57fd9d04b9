//! The mask of a project: the pixels of its photograph that are left out.

use crate::{Error, Project};
use unrender_formats::picture::{self, Picture};
use unrender_formats::{FileError, Input};
use unrender_scene::{Image, Rgb};

/// Masks are black and white; values from here on are white. Many programs smooth edges: at half,
/// they lie where they were drawn.
const WHITE: f32 = 0.5;

/// The mask that `project` names, for its photograph `photo`: false where it is black.
pub(crate) fn read(project: &Project, photo: &Picture) -> Result<Option<Image<bool>>, Error> {
    let Some(path) = &project.mask else { return Ok(None) };
    let (mask, _) = picture::read(Input::new(path, project.limits))?;
    let counts = counts(&mask, &photo.values).map_err(|problem| FileError::new(path, problem))?;
    Ok(Some(counts))
}

/// As [`read`], for a mask in memory.
///
/// # Errors
/// If it is of another size than the photograph, or black everywhere.
pub(crate) fn counts(mask: &Picture, photo: &Image<Rgb>) -> Result<Image<bool>, String> {
    let size = |image: &Image<Rgb>| (image.width(), image.height());
    let ((width, height), (wide, high)) = (size(&mask.values), size(photo));
    if (width, height) != (wide, high) {
        return Err(format!(
            "the mask has {width} x {height} pixels and the photo {wide} x {high}; make it again \
             at the photo's size"
        ));
    }
    let white = least_white(mask);
    let mut counts = mask.values.map(|value| value.max_element() >= white);
    // Pixels without a value, and transparent ones, are not white.
    mask.invalid.iter().for_each(|&index| counts.pixels_mut()[index] = false);
    if !counts.pixels().contains(&true) {
        return Err(
            "the mask is black everywhere, so no pixel of the photo would be used; make the pixels \
             to use white"
                .into(),
        );
    }
    Ok(counts)
}

/// The least value that is white: in an integer file whose codes are 0 and 1 alone, as programs write arrays of
/// yes and no, the code 1.
fn least_white(mask: &Picture) -> f32 {
    let Some(max_code) = mask.depth.max_code() else { return WHITE };
    let one = WHITE / max_code;
    let greatest = mask.values.pixels().iter().map(|value| value.max_element()).fold(0.0, f32::max);
    if (one..3.0 * one).contains(&greatest) { one } else { WHITE }
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_formats::picture::Depth;

    fn mask(values: &[f32]) -> Picture {
        let values = values.iter().map(|v| Rgb::splat(*v)).collect::<Vec<_>>();
        Picture::new(Image::new(values.len(), 1, values), Depth::Float)
    }

    #[test]
    fn white_counts_and_black_does_not() {
        let photo = Image::new(4, 1, vec![Rgb::ONE; 4]);
        let mut of = mask(&[0.0, 0.49, 0.5, 1.0]);
        assert_eq!(counts(&of, &photo).unwrap().pixels(), [false, false, true, true]);
        of.invalid.push(2);
        assert_eq!(counts(&of, &photo).unwrap().pixels(), [false, false, false, true]);
        let red = Image::new(1, 1, vec![Rgb::X]);
        assert!(
            counts(&Picture::new(red, Depth::Eight), &Image::new(1, 1, vec![Rgb::ONE])).is_ok()
        );
    }

    #[test]
    fn codes_of_zero_and_one_are_black_and_white() {
        let photo = Image::new(3, 1, vec![Rgb::ONE; 3]);
        for (depth, white) in [(Depth::Eight, 255.0), (Depth::Sixteen, 65535.0)] {
            let of = |codes: &[f32]| {
                let values: Vec<_> = codes.iter().map(|code| code / white).collect();
                counts(&Picture { depth, ..mask(&values) }, &photo)
            };
            assert_eq!(of(&[0.0, 1.0, 0.0]).unwrap().pixels(), [false, true, false]);
            assert_eq!(of(&[0.0, 1.0, white]).unwrap().pixels(), [false, false, true]);
            assert!(of(&[0.0, 1.0, 2.0]).unwrap_err().contains("black everywhere"));
            assert!(of(&[0.0; 3]).unwrap_err().contains("black everywhere"));
        }
    }

    #[test]
    fn masks_that_cannot_be_meant_are_reported() {
        let photo = Image::new(2, 2, vec![Rgb::ONE; 4]);
        let problem = counts(&mask(&[1.0; 4]), &photo).unwrap_err();
        assert!(problem.contains("4 x 1 pixels and the photo 2 x 2"), "{problem}");
        let photo = Image::new(2, 1, vec![Rgb::ONE; 2]);
        assert!(counts(&mask(&[0.0, 0.1]), &photo).unwrap_err().contains("black everywhere"));
    }
}
