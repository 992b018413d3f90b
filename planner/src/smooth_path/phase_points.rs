//! The configurations of a phase at even places of the curve, with two more on either side for the
//! derivatives.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::base::spatial::scaled_axis_from_rotation;

use crate::base::arena::reserve;
use crate::constraints::rejection::Rejection;
use crate::robot::configuration::Configuration;
use crate::robot::kinematic_state::KinematicState;
use crate::smooth_path::key_table::KeySource;
use crate::smooth_path::phase_grid::{BEYOND, PhaseGrid};
use crate::smooth_path::posture_solver::PostureSolver;
use crate::smooth_path::track::Track;
use crate::smooth_path::tuning::{INTERVALS_MAX, JOINT_STEP_MAX, REST_DIFFERENCE_MAX};
use crate::timing::path_point::{PathPoint, VELOCITY_MAX};

/// Weights of five even points for the first derivative, and for the second.
const DIFFERENCES: [[f64; 5]; 2] = [
    [1.0 / 12.0, -8.0 / 12.0, 0.0, 8.0 / 12.0, -1.0 / 12.0],
    [-1.0 / 12.0, 16.0 / 12.0, -30.0 / 12.0, 16.0 / 12.0, -1.0 / 12.0],
];

/// The configurations of one phase after the other.
#[derive(Debug)]
pub(crate) struct PhasePoints {
    /// The phase.
    pub grid: PhaseGrid,
    /// Its configurations so far.
    pub configurations: Vec<Configuration>,
    /// Kinematic states of the last two configurations, the later one at `current`.
    pub kinematic_states: [KinematicState; 2],
    /// Index of the state of the last configuration.
    pub current: usize,
    /// Whether the robot rests at the beginning and at the end.
    rests: [bool; 2],
    solver: PostureSolver,
}

impl PhasePoints {
    /// Reserves memory.
    pub fn new() -> Self {
        Self {
            grid: PhaseGrid::default(),
            configurations: reserve(INTERVALS_MAX + 1 + 2 * BEYOND),
            kinematic_states: Default::default(),
            current: 0,
            rests: [false; 2],
            solver: PostureSolver::default(),
        }
    }

    /// Begins a phase.
    pub fn begin(&mut self, grid: PhaseGrid, rests: [bool; 2]) {
        (self.grid, self.rests) = (grid, rests);
        self.configurations.clear();
        self.solver = PostureSolver::default();
    }

    /// Whether all configurations of the phase are made.
    pub fn is_complete(&self) -> bool {
        self.configurations.len() == self.grid.len()
    }

    /// Makes the next configuration. Those beyond a rest are mirror images of those before it, so
    /// that the second derivatives are zero there.
    ///
    /// # Errors
    /// The constraint that it violates.
    pub fn advance(&mut self, source: &KeySource<'_>, track: Track<'_>) -> Result<(), Rejection> {
        let index = self.configurations.len();
        let last = BEYOND + self.grid.intervals;
        if index < BEYOND && self.rests[0] {
            let first = self.guess(source);
            self.configurations.push(first);
            return Ok(());
        }
        if index > last && self.rests[1] {
            let image =
                mirrored(&self.configurations[last], &self.configurations[2 * last - index]);
            self.configurations.push(image);
            return Ok(());
        }
        let place = self.grid.place(index);
        let mut configuration = self.guess(source);
        let next = 1 - self.current;
        let Self { grid, solver, kinematic_states, .. } = self;
        let state = &mut kinematic_states[next];
        track.configure(source, (&*grid, place), solver, &mut configuration, state)?;
        self.current = next;
        if let Some(last) = self.configurations.last()
            && largest_difference(last, &configuration) > JOINT_STEP_MAX
        {
            return Err(Rejection::Discontinuous);
        }
        self.check_rest(source, index, &mut configuration)?;
        self.configurations.push(configuration);
        if index == 2 * BEYOND && self.rests[0] {
            for beyond in 1..=BEYOND {
                self.configurations[BEYOND - beyond] =
                    mirrored(&self.configurations[BEYOND], &self.configurations[BEYOND + beyond]);
            }
        }
        Ok(())
    }

    /// Where the solution of the next configuration begins: the plan's own configuration at first,
    /// then as the last two lead on.
    fn guess(&self, source: &KeySource<'_>) -> Configuration {
        match self.configurations.as_slice() {
            [] => {
                let edges = source.layout.edges(self.grid.phase);
                source.plan.roadmap.state(source.plan.nodes[edges.start]).configuration
            }
            [only] => *only,
            [.., before, last] => {
                let mut next = *last;
                let shift = last.world_from_root.translation - before.world_from_root.translation;
                next.world_from_root.translation += shift;
                for (q, before) in next.q.iter_mut().zip(&before.q) {
                    *q += *q - before;
                }
                next
            }
        }
    }

    /// Where the robot rests at an end of the phase, the configuration is the plan's own.
    fn check_rest(
        &self,
        source: &KeySource<'_>,
        index: usize,
        configuration: &mut Configuration,
    ) -> Result<(), Rejection> {
        let [first, last] = source.layout.end_keys(self.grid.phase);
        let key = match index {
            BEYOND => first,
            index if index == BEYOND + self.grid.intervals => last,
            _ => return Ok(()),
        };
        if !self.rests[usize::from(index > BEYOND)] {
            return Ok(());
        }
        let planned = source.plan.roadmap.state(source.rest_node(key)).configuration;
        let distance =
            planned.world_from_root.translation.distance(configuration.world_from_root.translation);
        if largest_difference(&planned, configuration).max(distance) > REST_DIFFERENCE_MAX {
            return Err(Rejection::Discontinuous);
        }
        *configuration = planned;
        Ok(())
    }

    /// The point of an index of a complete phase, at a value of the path's parameter (s).
    pub fn point(&self, index: usize, parameter: f64) -> PathPoint {
        let around = &self.configurations[index - BEYOND..=index + BEYOND];
        let here = &around[BEYOND];
        let step = self.grid.seconds();
        let [mut first, mut second] = [[0.0; VELOCITY_MAX]; 2];
        let here_rotation = here.world_from_root.rotation;
        for (at, other) in around.iter().enumerate() {
            let weights = [DIFFERENCES[0][at] / step, DIFFERENCES[1][at] / (step * step)];
            let mut difference = [0.0; VELOCITY_MAX];
            let shift = other.world_from_root.translation - here.world_from_root.translation;
            let turn: DVec3 = scaled_axis_from_rotation(
                other.world_from_root.rotation * here_rotation.conjugate(),
            );
            difference[..3].copy_from_slice(&shift.to_array());
            difference[3..6].copy_from_slice(&turn.to_array());
            for joint in 0..JOINTS_MAX {
                difference[6 + joint] = other.q[joint] - here.q[joint];
            }
            for (index, difference) in difference.iter().enumerate() {
                first[index] += weights[0] * difference;
                second[index] += weights[1] * difference;
            }
        }
        PathPoint { parameter, world_from_root: here.world_from_root, q: here.q, first, second }
    }
}

/// The mirror image of a configuration at another one.
fn mirrored(at: &Configuration, other: &Configuration) -> Configuration {
    let [center, root] = [&at.world_from_root, &other.world_from_root];
    let rotation = center.rotation * root.rotation.conjugate() * center.rotation;
    Configuration {
        world_from_root: Pose::from_parts(2.0 * center.translation - root.translation, rotation),
        q: std::array::from_fn(|joint| 2.0 * at.q[joint] - other.q[joint]),
    }
}

/// The largest difference of a joint between two configurations, rad or m.
fn largest_difference(a: &Configuration, b: &Configuration) -> f64 {
    a.q.iter().zip(&b.q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
