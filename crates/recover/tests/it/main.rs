//! Tests of the recovery: every rung in closed form, rooms by the path tracer, standard deviations, and the same
//! bits wherever it is cut off.

mod brushed_room;
mod stripes;

mod empty;
mod error_bars;
mod facing;
mod ggx;
mod ladder;
mod registration;
mod sharp_lobes;
mod verified;
