//! Colours that are declared by code points (PNG's chunk cICP): primaries, and the transfer curve [ITU-T
//! H.273].

use super::curves::sampled;
use super::primaries::{Corners, matrix, of_primaries};
use unrender_scene::Profile;
use unrender_scene::color::linear_from_srgb;

const D65: [f32; 2] = [0.3127, 0.3290];
const C: [f32; 2] = [0.310, 0.316];

/// The profile that `data`, the chunk's, declares.
///
/// # Errors
/// If the codes do not represent scene light (PQ and HLG) or use a part of the range only. As the end of a
/// sentence about the file.
pub(super) fn profile(data: &[u8]) -> Result<Profile, String> {
    let &[primaries, transfer, matrix_code, range] = data else {
        return Ok(of_primaries(None, "a chunk cICP that has no four bytes"));
    };
    let source = format!("its chunk cICP ({})", name(primaries, transfer));
    match transfer {
        16 => return Err(refused("PQ (SMPTE ST 2084)")),
        18 => return Err(refused("HLG (ARIB STD-B67)")),
        _ => {}
    }
    if range == 0 {
        return Err(
            "uses a part of the range of codes (cICP, narrow range), which is not read; save it \
             with the full range"
                .into(),
        );
    }
    let (Some(corners), Some(curve)) = (corners(primaries), curve(transfer)) else {
        return Ok(of_primaries(None, &source));
    };
    if matrix_code != 0 {
        return Ok(of_primaries(None, &source));
    }
    let curve = sampled(curve);
    let curves = Some([curve.clone(), curve.clone(), curve]);
    Ok(Profile { curves, ..of_primaries(matrix(corners), &source) })
}

fn refused(curve: &str) -> String {
    format!(
        "is encoded for screens by {curve} (its chunk cICP), which is not read; save it as a \
         linear EXR"
    )
}

fn name(primaries: u8, transfer: u8) -> String {
    match (primaries, transfer) {
        (1, 13) => "sRGB".into(),
        (12, 13) => "Display P3".into(),
        (1, 1) => "BT.709".into(),
        (9, 1 | 14 | 15) => "BT.2020".into(),
        _ => format!("primaries {primaries}, curve {transfer}"),
    }
}

/// Red, green, blue and white of the code for primaries.
fn corners(code: u8) -> Option<Corners> {
    Some(match code {
        1 => [[0.640, 0.330], [0.300, 0.600], [0.150, 0.060], D65],
        4 => [[0.67, 0.33], [0.21, 0.71], [0.14, 0.08], C],
        5 => [[0.64, 0.33], [0.29, 0.60], [0.15, 0.06], D65],
        6 | 7 => [[0.630, 0.340], [0.310, 0.595], [0.155, 0.070], D65],
        8 => [[0.681, 0.319], [0.243, 0.692], [0.145, 0.049], C],
        9 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], D65],
        10 => [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]],
        11 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], [0.314, 0.351]],
        12 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], D65],
        22 => [[0.630, 0.340], [0.295, 0.605], [0.155, 0.077], D65],
        _ => return None,
    })
}

/// Linear values of codes, by the code for the curve.
fn curve(code: u8) -> Option<fn(f32) -> f32> {
    Some(match code {
        1 | 6 | 14 | 15 => {
            |v| if v < 0.081 { v / 4.5 } else { ((v + 0.099) / 1.099).powf(1.0 / 0.45) }
        }
        4 => |v| v.powf(2.2),
        5 => |v| v.powf(2.8),
        7 => |v| if v < 0.0912 { v / 4.0 } else { ((v + 0.1115) / 1.1115).powf(1.0 / 0.45) },
        8 => |v| v,
        13 => linear_from_srgb,
        _ => return None,
    })
}
