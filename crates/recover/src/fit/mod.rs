//! Solvers: the reflectances by linear least squares, the roughness by downhill simplex, steps
//! within bounds by a quadratic program.

pub mod linear;
pub mod quadratic;
pub mod simplex;
