//! The kinds of changes.

use super::subject::Subject;
use super::{contact_changes, motion_changes, rate_changes, torque_changes, world_changes};

/// A kind of changes.
pub(super) struct Kind {
    /// Its name in reports.
    pub(super) name: &'static str,
    /// The unit of its size.
    pub(super) unit: &'static str,
    /// The smallest and the largest size; sizes are spread evenly over their logarithm.
    pub(super) sizes: [f64; 2],
    /// The size from which every change must be refused, if there is one. A change may miss the
    /// robot and its way, or leave it as good as before.
    pub(super) refused_from: f64,
    /// Makes a change of a size; false where the plan has nothing to change.
    pub(super) change: fn(&mut Subject, f64) -> bool,
}

/// No size must be refused.
const NEVER: f64 = f64::INFINITY;

const fn kind(
    (name, unit): (&'static str, &'static str),
    sizes: [f64; 2],
    refused_from: f64,
    change: fn(&mut Subject, f64) -> bool,
) -> Kind {
    Kind { name, unit, sizes, refused_from, change }
}

/// All kinds.
pub(super) const KINDS: [Kind; 28] = [
    kind(("bend", "rad"), [0.005, 2.0], NEVER, motion_changes::bend),
    kind(("offset", "rad"), [0.002, 1.0], NEVER, motion_changes::offset),
    kind(("sway", "m"), [0.0005, 0.3], 0.01, motion_changes::sway),
    kind(("lean", "rad"), [0.001, 0.5], 0.05, motion_changes::lean),
    kind(("twitch", "rad"), [0.002, 0.5], 0.21, motion_changes::twitch),
    kind(("shift", "m"), [0.0005, 0.2], NEVER, motion_changes::shift),
    kind(("leave out", "waypoints"), [1.0, 60.0], NEVER, motion_changes::leave_out),
    kind(("hurry", "times"), [1.02, 10.0], 3.0, rate_changes::hurry),
    kind(("hurry phase", "times"), [1.02, 10.0], NEVER, rate_changes::hurry_phase),
    kind(("velocity", "rad/s"), [0.01, 20.0], NEVER, rate_changes::velocity),
    kind(("acceleration", "rad/s2"), [0.5, 2000.0], NEVER, rate_changes::acceleration),
    kind(("brake", "times"), [1.05, 50.0], NEVER, rate_changes::brake),
    kind(("torque", "N m"), [0.05, 500.0], NEVER, torque_changes::torque),
    kind(("rest torque", "N m"), [0.05, 500.0], NEVER, torque_changes::rest_torque),
    kind(("stop torque", "N m s"), [0.02, 200.0], NEVER, torque_changes::stop_torque),
    kind(("all torques", "times"), [1.01, 10.0], 5.0, torque_changes::all_torques),
    kind(("executed", "times"), [1.01, 10.0], 5.0, torque_changes::executed),
    kind(("move contact", "m"), [0.0005, 0.1], 0.004, contact_changes::move_contact),
    kind(("turn contact", "rad"), [0.0005, 0.2], 0.01, contact_changes::turn_contact),
    kind(("move phase", "waypoints"), [1.0, 30.0], NEVER, contact_changes::move_phase),
    kind(("larger soles", "times"), [1.002, 2.0], 1.1, contact_changes::larger_soles),
    kind(("move shape", "m"), [0.0005, 0.5], NEVER, world_changes::move_shape),
    kind(("turn shape", "rad"), [0.001, 0.5], NEVER, world_changes::turn_shape),
    kind(("shrink shape", "times"), [1.01, 10.0], NEVER, world_changes::shrink_shape),
    kind(("remove shape", ""), [1.0, 1.0], NEVER, world_changes::remove_shape),
    kind(("slippery", "times"), [1.05, 100.0], 50.0, world_changes::slippery),
    kind(("obstacle", "m"), [0.002, 0.2], NEVER, world_changes::obstacle),
    kind(("weaken", "times"), [1.05, 30.0], 10.0, world_changes::weaken),
];
