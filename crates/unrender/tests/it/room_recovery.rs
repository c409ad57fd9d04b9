//! The furnished room of `examples/room` from its photograph.

use crate::kit::example::{Limits, beside_crates, recovers};

#[test]
#[ignore = "slow: 480 x 360 pixels of 14 groups"]
fn the_furnished_room_is_recovered() {
    let limits = Limits { rho: 0.02, alpha_percent: 2.0, degrees: 0.3 };
    recovers(&beside_crates("examples/room"), "room.toml", &[], &limits);
}
