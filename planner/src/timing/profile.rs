//! Time-optimal rates along a path by reachability analysis (TOPP-RA) [Pham, Pham 2018]: backward
//! the largest speed from which the rest of the path can still be walked, forward the largest
//! acceleration that stays below it.
//!
//! Within a cell, from one node to the next, the acceleration is constant. Its rates must be
//! allowed at both nodes.

use glam::DVec2;

use crate::timing::limit::Limit;
use crate::timing::limits::Level;
use crate::timing::rate_set::RateSet;
use crate::timing::zero_moment::{BalanceTerms, GroundLoad};

/// A point of the path within one span. Two spans share a point: it is a node of each.
#[derive(Debug, Clone)]
pub struct Node {
    /// Length of the path up to here, in units of its parameter.
    pub position: f64,
    /// Whether the robot rests here.
    pub rests: bool,
    /// The rates within the limits.
    pub rates: RateSet,
    /// The part of the rates that may be used, 0 to 1.
    pub part: f64,
    /// The factor by which the rates are shrunk, 0 to that part.
    pub factor: f64,
    /// What the rates leave of the limits.
    pub level: Level,
    /// The load on the ground.
    pub balance: BalanceTerms,
    /// The load on the ground by unit of squared speed, at one and at two thirds of the way to the
    /// next node.
    pub inner: [GroundLoad; 2],
}

/// The limit that binds in the cell between two nodes with these squared speeds; `None` where the
/// rates are far from all.
pub fn binding([node, next]: [&Node; 2], [x, next_x]: [f64; 2]) -> Option<Limit> {
    let step = next.position - node.position;
    if step <= 0.0 {
        return None;
    }
    let u = (next_x - x) / (2.0 * step);
    let [begin, end] =
        [(node, x), (next, next_x)].map(|(at, x)| at.allowed().binding_at(DVec2::new(x, u)));
    let (limit, share) = if end.1 > begin.1 { end } else { begin };
    (share >= BINDING_SHARE).then_some(limit)
}

/// Share of a limit from which it binds.
const BINDING_SHARE: f64 = 0.99;

impl Node {
    /// The rates that timing may use.
    fn allowed(&self) -> RateSet {
        self.rates.scaled(self.factor)
    }
}

/// Writes to `ceilings` the largest squared speed at each node from which the rest of the nodes can
/// be walked; the robot rests at the last one. It does not rest at the node before a rest, from
/// which it would not get anywhere.
pub fn controllable(nodes: &[Node], ceilings: &mut [f64]) {
    let mut after: Option<(f64, f64)> = None;
    let mut least = 0.0;
    let mut end = RateSet::default();
    for (node, ceiling) in nodes.iter().zip(ceilings).rev() {
        let allowed = node.allowed();
        let mut set = allowed.clone();
        if let Some((position, ceiling)) = after {
            let step = position - node.position;
            if step > 0.0 {
                set.clip_by_end(&end, step);
            }
            let normal = DVec2::new(1.0, 2.0 * step);
            set.clip(normal, ceiling, Limit::PathRate);
            set.clip(-normal, END_ROUNDING - least, Limit::PathRate);
        }
        let fastest = set.fastest().map_or(0.0, |rate| rate.x.max(0.0));
        *ceiling = if node.rests || after.is_none() { 0.0 } else { fastest };
        least = match after {
            Some((position, _)) if position <= node.position => least.min(*ceiling),
            Some((_, 0.0)) => LEAST_SHARE * *ceiling,
            _ => 0.0,
        };
        after = Some((node.position, *ceiling));
        end = allowed;
    }
}

/// Writes to `speeds` the squared speeds of the fastest motion that begins with `speeds[0]` and
/// stays below `ceilings`. Returns `false` where it cannot, or where it does not get anywhere.
pub fn fastest(nodes: &[Node], ceilings: &[f64], speeds: &mut [f64]) -> bool {
    if speeds.is_empty() {
        return true;
    }
    let mut is_within = speeds[0] <= ceilings[0] + ROUNDING;
    for index in 1..nodes.len() {
        let (node, next) = (&nodes[index - 1], &nodes[index]);
        let step = next.position - node.position;
        let x = speeds[index - 1];
        if step <= 0.0 {
            is_within &= x <= ceilings[index] + ROUNDING * (1.0 + x);
            speeds[index] = x.min(ceilings[index]);
            continue;
        }
        let mut set = node.allowed();
        set.clip_by_end(&next.allowed(), step);
        let normal = DVec2::new(1.0, 2.0 * step);
        set.clip(normal, ceilings[index], Limit::PathRate);
        set.clip(-normal, END_ROUNDING, Limit::PathRate);
        let highest = set.accelerations_at(x).map(|[_, highest]| highest);
        is_within &= highest.is_some();
        let free = (ceilings[index] - x) / (2.0 * step);
        let u = highest.unwrap_or(free);
        speeds[index] = (x + 2.0 * step * u).clamp(0.0, ceilings[index]);
        is_within &= x.max(speeds[index]) > STANDSTILL;
    }
    is_within
}

/// Rounding of squared speeds.
const ROUNDING: f64 = 1e-7;
/// How far below 0 the squared speed at the end of a cell may be before it counts as 0.
const END_ROUNDING: f64 = 1e-8;
/// Share of the largest squared speed at the node before a rest that the robot has there at least.
const LEAST_SHARE: f64 = 0.01;
/// Squared speed at both ends of a cell that does not get anywhere.
const STANDSTILL: f64 = 1e-10;

#[cfg(test)]
mod tests {
    use super::*;

    fn nodes(count: usize, length: f64, set: impl Fn(f64) -> RateSet) -> Vec<Node> {
        let node = |index: usize| {
            let position = length * index as f64 / (count - 1) as f64;
            Node {
                position,
                rests: index == 0,
                rates: set(position),
                part: 1.0,
                factor: 1.0,
                level: Level::Full,
                balance: BalanceTerms::default(),
                inner: Default::default(),
            }
        };
        (0..count).map(node).collect()
    }

    fn duration(nodes: &[Node]) -> f64 {
        let (mut ceilings, mut speeds) = (vec![0.0; nodes.len()], vec![0.0; nodes.len()]);
        controllable(nodes, &mut ceilings);
        assert!(fastest(nodes, &ceilings, &mut speeds));
        let times = nodes.windows(2).zip(speeds.windows(2)).map(|(nodes, speeds)| {
            2.0 * (nodes[1].position - nodes[0].position) / (speeds[0].sqrt() + speeds[1].sqrt())
        });
        times.sum()
    }

    #[test]
    fn a_double_integrator_takes_its_shortest_time() {
        // 1 rad with at most 2 rad/s2: accelerate and brake for 2 sqrt(d / a).
        let plain = nodes(201, 1.0, |_| RateSet::within(100.0, 2.0));
        assert!((duration(&plain) - 2.0 * (1.0_f64 / 2.0).sqrt()).abs() < 1e-6);
        // With at most 0.5 rad/s: 0.25 s up, 0.25 s down, the rest of the way at full speed.
        let slow = nodes(201, 1.0, |_| RateSet::within(0.25, 2.0));
        let expected = 0.5 + (1.0 - 2.0 * 0.0625) / 0.5;
        assert!((duration(&slow) - expected).abs() < 2e-3, "{} {expected}", duration(&slow));
    }

    #[test]
    fn a_joint_against_gravity_keeps_its_torque() {
        // inertia 1, torque at most 12, gravity 9.81 cos(s): u = torque - gravity.
        let set = |s: f64| {
            let gravity = 9.81 * libm::cos(s);
            let mut set = RateSet::within(400.0, 40.0);
            set.clip(DVec2::Y, 12.0 - gravity, Limit::Torque(0));
            set.clip(-DVec2::Y, 12.0 + gravity, Limit::Torque(0));
            set
        };
        let grid = nodes(1001, 1.5, set);
        // Energy gives the switch: full torque up, full torque down.
        let x_up = |s: f64| 2.0 * (12.0 * s - 9.81 * libm::sin(s));
        let x_down = |s: f64| 2.0 * (12.0 * (1.5 - s) + 9.81 * (libm::sin(1.5) - libm::sin(s)));
        let count = 1_000_000;
        let expected: f64 = (0..count)
            .map(|index| 1.5 * (f64::from(index) + 0.5) / f64::from(count))
            .map(|s| 1.5 / f64::from(count) / x_up(s).min(x_down(s)).sqrt())
            .sum();
        assert!((duration(&grid) / expected - 1.0).abs() < 5e-3, "{} {expected}", duration(&grid));
    }

    #[test]
    fn a_rest_in_between_is_kept() {
        let mut grid = nodes(101, 1.0, |_| RateSet::within(100.0, 2.0));
        grid[50].rests = true;
        assert!((duration(&grid) - 2.0).abs() < 1e-6, "{}", duration(&grid));
    }

    #[test]
    fn the_fastest_approach_of_a_rest_does_not_stand_still_before_it() {
        // The faster the robot comes to the fourth place, the harder it must brake there, so that
        // the fastest rate at it ends with a standstill at the fifth one.
        let bounds = [[4.0, 370.0, 1.1, 15.0], [3.3, 137.0, 0.7, 14.0], [2.7, 79.0, 0.4, 13.0]];
        let mut grid = nodes(6, 0.0885, |_| RateSet::within(1.0, 10.0));
        for (node, [up, up_less, down, down_more]) in grid[3..].iter_mut().zip(bounds) {
            node.rates.clip(DVec2::new(up_less, 1.0), up, Limit::PathRate);
            node.rates.clip(DVec2::new(-down_more, -1.0), down, Limit::PathRate);
        }
        assert!(duration(&grid).is_finite());
    }
}
