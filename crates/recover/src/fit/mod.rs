//! Solvers: the reflectances by linear least squares, the roughness by downhill simplex.

pub mod linear;
pub mod simplex;
