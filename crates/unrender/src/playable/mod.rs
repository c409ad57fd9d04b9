//! A result that one can play with: what each lamp and the colour of each group do to the picture, as pictures.
//!
//! Light transport is linear in the brightness `s_l` of the lamps and, to first order, in the colours of the groups.
//! With `L_l` the picture by lamp `l` alone at its full brightness, `L` the sum of these and `J_g` the derivative of the
//! photograph's light by the colour `c_g` of group `g`, through all interreflections,
//!
//! ```text
//! picture = L * S * Q,   S = sum over l of s_l (L_l / L),   Q = 1 + sum over g of (J_g / L_now) (c_g - c_g,0)
//! ```
//!
//! where `L_now` is the light of the photograph. `S` is exact. `Q` has two approximations, whose errors are measured
//! (`approximation`): it is of first order in the colours, and takes the share of a group in the light to be the same
//! under other lamps. Numerator and denominator of a ratio come from the same paths (`separated`), so that most of the
//! noise cancels. The photograph itself can take the place of `L`, as `S / S_now` and `Q` are ratios [Liu et al. 2001].
//!
//! `coded` packs the pictures for the page, which `crate::report` writes.

mod approximation;
mod coded;
mod play;
mod separated;

pub(crate) use approximation::Errors;
pub(crate) use coded::{Code, Coded, Curve, coded, packed};
pub(crate) use play::{NO_GROUP, Play, play};
pub(crate) use separated::{Colour, ColourOf};
