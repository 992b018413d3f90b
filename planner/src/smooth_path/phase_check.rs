//! Checks a phase: every configuration and the motions between them satisfy the constraints.

use crate::collision::model::FootPhase;
use crate::constraints::mode::Mode;
use crate::constraints::rejection::Rejection;
use crate::robot::configuration::Configuration;
use crate::robot::kinematic_state::KinematicState;
use crate::smooth_path::key_table::KeySource;
use crate::smooth_path::layout::swing_of;
use crate::smooth_path::phase_grid::{BEYOND, PhaseGrid};
use crate::smooth_path::phase_points::PhasePoints;
use crate::smooth_path::track::Track;
use crate::smooth_path::tuning::{CURVE_PARTS, LIFT_OFF_DISTANCE_MAX};
use crate::timing::timed_path::state_at;

/// Checks one phase after the other, one configuration for each unit of work.
#[derive(Debug)]
pub(crate) struct PhaseCheck {
    /// The phase with its configurations so far.
    pub points: PhasePoints,
    scratch: KinematicState,
}

impl PhaseCheck {
    /// Reserves memory.
    pub fn new() -> Self {
        Self { points: PhasePoints::new(), scratch: KinematicState::default() }
    }

    /// Begins a phase.
    pub fn begin(&mut self, grid: PhaseGrid, rests: [bool; 2]) {
        self.points.begin(grid, rests);
    }

    /// Makes and checks the next configuration. Returns whether the phase is complete.
    ///
    /// # Errors
    /// The constraint that is violated.
    pub fn advance(&mut self, source: &KeySource<'_>, track: Track<'_>) -> Result<bool, Rejection> {
        self.points.advance(source, track)?;
        let index = self.points.configurations.len() - 1;
        if (BEYOND..=BEYOND + self.points.grid.intervals).contains(&index) {
            self.check(source, track, index)?;
        }
        // A point is known once two configurations follow it.
        if index > 2 * BEYOND {
            self.check_curve(source, index - BEYOND)?;
        }
        Ok(self.points.is_complete())
    }

    /// Checks the curve that ends at the point of an index.
    fn check_curve(&mut self, source: &KeySource<'_>, index: usize) -> Result<(), Rejection> {
        let Self { points, scratch } = self;
        let edge = source.plan.edge(source.layout.edges(points.grid.phase).start);
        let mode = source.plan.roadmap.mode(edge);
        let seconds = points.grid.seconds();
        let ends = [points.point(index - 1, 0.0), points.point(index, seconds)];
        for part in 1..CURVE_PARTS {
            let on_curve = state_at(&ends, seconds * part as f64 / CURVE_PARTS as f64);
            let configuration =
                Configuration { world_from_root: on_curve.world_from_root(), q: on_curve.q };
            source.constraints.check_on_curve(&mode, &configuration, scratch)?;
        }
        Ok(())
    }

    /// Checks the configuration of an index, and the motion to it from the one before.
    fn check(
        &mut self,
        source: &KeySource<'_>,
        track: Track<'_>,
        index: usize,
    ) -> Result<(), Rejection> {
        let Self { points, scratch } = self;
        let edge = source.plan.edge(source.layout.edges(points.grid.phase).start);
        let mode = source.plan.roadmap.mode(edge);
        let constraints = source.constraints;
        let [here, before] = [points.current, 1 - points.current];
        let feet = |at: usize, state: usize| {
            feet(source, track, &points.grid, (&mode, &points.kinematic_states[state]), at)
        };
        let feet_here = feet(index, here);
        constraints.check(&mode, &points.kinematic_states[here], feet_here)?;
        if index == BEYOND {
            return Ok(());
        }
        // The foot keeps as much clearance below its sole as at the end where it keeps less.
        let between = feet_here.min(feet(index - 1, before));
        let bound = constraints
            .collision
            .motion_bound(&points.kinematic_states[before], &points.kinematic_states[here]);
        let ends = [&points.configurations[index - 1], &points.configurations[index]];
        constraints.check_between(&mode, ends, bound, between, scratch)?;
        Ok(())
    }
}

/// The phases of the feet at a configuration.
fn feet(
    source: &KeySource<'_>,
    track: Track<'_>,
    grid: &PhaseGrid,
    (mode, state): (&Mode, &KinematicState),
    index: usize,
) -> [FootPhase; 2] {
    if swing_of(grid.phase).is_none() {
        return [FootPhase::Stance; 2];
    }
    let aside = track.distance_aside(source, grid, grid.place(index));
    let edge = source.plan.edge(source.layout.edges(grid.phase).start);
    [0, 1].map(|limb| {
        if mode.is_stance(limb) {
            FootPhase::Stance
        } else if aside > LIFT_OFF_DISTANCE_MAX {
            FootPhase::Swing
        } else {
            let footholds = [edge.from, edge.to]
                .map(|node| source.plan.roadmap.state(node).world_from_soles[limb]);
            let sole = state.world_from_sole(&source.constraints.robot, limb);
            FootPhase::of_leaving(&footholds, &sole)
        }
    })
}
