//! The light from all around, in Radiance's words: a glow that is a source of 360 degrees, behind a panorama by the
//! direction of the ray. A glow is found by rays that are reflected, not by those to lamps: `render.sh` follows them.

use super::pictures::{place, with_frame};
use super::triple;
use crate::export::environment::{self, Around};
use crate::export::{Files, SceneView};
use crate::texels;
use std::f32::consts::{PI, TAU};
use unrender_scene::{Environment, Rgb, Wrap};

/// The panorama's file: Radiance does not read EXR.
const PICTURE: &str = "environment.hdr";
/// The modifier that lays the panorama over the glow.
const PATTERN: &str = "environment.panorama";

/// The environment as primitives, its panorama among `files`.
///
/// # Errors
/// If the panorama cannot be encoded.
pub(super) fn text(shot: &SceneView, files: &mut Files) -> Result<String, String> {
    let (pattern, radiance) = match environment::around(shot.scene) {
        None => return Ok(String::new()),
        Some(Around::Uniform(radiance)) => (String::new(), radiance),
        Some(Around::Panorama(around)) => {
            let picture = environment::panorama(&around);
            let framed = with_frame(&picture, [Wrap::Repeat, Wrap::ClampToEdge]);
            files.push((PICTURE.into(), texels::hdr(&framed)?));
            (pattern(&around, (picture.width(), picture.height())), Rgb::ONE)
        }
    };
    let modifier = if pattern.is_empty() { "void" } else { PATTERN };
    Ok(format!(
        "\n# environment\n{pattern}{modifier} glow environment\n0\n0\n4 {} 0\n\
         environment source environment.sky\n0\n0\n4 0 1 0 360\n",
        triple(radiance)
    ))
}

/// The pattern of a panorama of `width` x `height` pixels, one more on each side. A ray that leaves the scene goes
/// along `D`. Radiance measures pictures from their lower left corner.
fn pattern(around: &Environment, (width, height): (usize, usize)) -> String {
    let shorter = (width.min(height) + 2) as f32;
    let turn = around.rotation_rad();
    let across = place(&format!("frac(.5+(atan2(Dx,-Dz)+({turn}))/{TAU})"), width, shorter);
    let up = place(&format!("(1-atan2(sqrt(Dx*Dx+Dz*Dz),Dy)/{PI})"), height, shorter);
    format!("void colorpict {PATTERN}\n7 red green blue ./{PICTURE} . {across} {up}\n0\n0\n")
}
