//! A primitive as it is sampled, waypoint by waypoint.

use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::Foothold;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::primitives::gait::Gait;
use crate::primitives::step_path::{HalfSwing, LANDING, SECTIONS, configuration, shift_at};
use crate::primitives::step_state::{foot_phase, with_legs};

/// The first step along a section that is tried, as a share of it.
const STEP_FIRST: f64 = 0.25;
/// The smallest step along a section, as a share of it: less means that a joint would jump.
const STEP_MIN: f64 = 1.0 / 4096.0;
/// The longest way of root or sole between two waypoints, m.
const TRAVEL_MAX: f64 = 0.04;
/// The share of the step limits that the next step is aimed at.
const STEP_AIM: f64 = 0.95;
/// A section shorter than this (m) is none.
const LENGTH_MIN: f64 = 1e-6;

/// The trajectory of one primitive. Ends that are joined hold the very same configurations.
#[derive(Debug, Clone)]
pub struct PrimitiveTrajectory {
    kind: TrajectoryKind,
    ends: [ModeState; 2],
    here: ModeState,
    /// The section that is followed, of all that the course has.
    section: usize,
    /// The share of it that is done, and the step to try next.
    done: f64,
    step: f64,
}

#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate during the search")]
enum TrajectoryKind {
    /// A place backwards, then a place.
    Swing { lift_off_half: HalfSwing, landing_half: HalfSwing },
    /// From one end to the other.
    Shift,
}

impl PrimitiveTrajectory {
    /// The swing over `stance` from the primitive configuration on `from` to the one on `to`.
    ///
    /// # Errors
    /// A leg does not reach: not where C_S holds.
    pub fn swing(
        constraints: &Constraints,
        gait: &Gait,
        stance: &Foothold,
        [from, to]: [&Foothold; 2],
    ) -> Result<Self, Rejection> {
        let lift_off_half = HalfSwing::new(&constraints.robot, gait, stance, from)?;
        let landing_half = lift_off_half.onto(&constraints.robot, gait, stance, to)?;
        let ends = [lift_off_half.placed, landing_half.placed];
        Ok(Self::begin(TrajectoryKind::Swing { lift_off_half, landing_half }, ends))
    }

    /// The shift of all weight from `from` to `to` between their two primitive configurations.
    ///
    /// # Errors
    /// As [`PrimitiveTrajectory::swing`].
    pub fn shift(
        constraints: &Constraints,
        gait: &Gait,
        [from, to]: [&Foothold; 2],
    ) -> Result<Self, Rejection> {
        let first = configuration(&constraints.robot, gait, from, to)?;
        let last = configuration(&constraints.robot, gait, to, from)?;
        Ok(Self::begin(TrajectoryKind::Shift, [first, last]))
    }

    fn begin(kind: TrajectoryKind, ends: [ModeState; 2]) -> Self {
        let mut trajectory =
            Self { kind, here: ends[0], ends, section: 0, done: 0.0, step: STEP_FIRST };
        trajectory.skip_empty();
        trajectory
    }

    /// The configurations at both ends.
    pub fn ends(&self) -> &[ModeState; 2] {
        &self.ends
    }

    /// Whether the last waypoint was sampled.
    pub fn is_over(&self) -> bool {
        self.section == self.sections_count()
    }

    /// Tries one step; answers the next waypoint and what the swing foot does on the way to it, or
    /// `None` where the step was too long and a shorter one is to be tried. To be called until it
    /// is over.
    ///
    /// # Errors
    /// A leg does not reach or would jump: not where C_S holds.
    pub fn advance(
        &mut self,
        constraints: &Constraints,
    ) -> Result<Option<(&ModeState, FootPhase)>, Rejection> {
        if self.step < STEP_MIN {
            return Err(Rejection::Discontinuous);
        }
        let ahead =
            if self.done + self.step > 1.0 - STEP_MIN { 1.0 } else { self.done + self.step };
        let (desired, foot) = self.at(ahead);
        let next = match self.exact_end() {
            Some(end) if ahead >= 1.0 => *end,
            _ => with_legs(&constraints.robot, desired)?,
        };
        let used = step_use(constraints, &self.here, &next);
        self.step *= (STEP_AIM / used.max(1e-3)).clamp(0.1, 2.0);
        if used > 1.0 {
            return Ok(None);
        }
        (self.here, self.done) = (next, ahead);
        if ahead >= 1.0 {
            (self.section, self.done, self.step) = (self.section + 1, 0.0, STEP_FIRST);
            self.skip_empty();
        }
        Ok(Some((&self.here, foot)))
    }

    fn sections_count(&self) -> usize {
        match self.kind {
            TrajectoryKind::Swing { .. } => 2 * SECTIONS,
            TrajectoryKind::Shift => 1,
        }
    }

    fn skip_empty(&mut self) {
        while let TrajectoryKind::Swing { lift_off_half, landing_half } = &self.kind
            && self.section < 2 * SECTIONS
            && length(lift_off_half, landing_half, self.section) <= LENGTH_MIN
        {
            self.section += 1;
        }
    }

    /// The state a share of the way along the section, legs not yet brought to their soles, and
    /// what the swing foot does.
    fn at(&self, t: f64) -> (ModeState, FootPhase) {
        match &self.kind {
            TrajectoryKind::Shift => (
                shift_at(&self.ends[0].configuration, &self.ends[1].configuration, t, &self.here),
                FootPhase::Stance,
            ),
            TrajectoryKind::Swing { lift_off_half, .. } if self.section < SECTIONS => {
                let section = SECTIONS - 1 - self.section;
                (lift_off_half.at(section, 1.0 - t, &self.here), foot_phase(section))
            }
            TrajectoryKind::Swing { landing_half, .. } => {
                let section = self.section - SECTIONS;
                (landing_half.at(section, t, &self.here), foot_phase(section))
            }
        }
    }

    /// The configuration with which the section ends, where it is a known one.
    fn exact_end(&self) -> Option<&ModeState> {
        match &self.kind {
            TrajectoryKind::Shift => Some(&self.ends[1]),
            TrajectoryKind::Swing { lift_off_half, .. } if self.section == SECTIONS - 1 => {
                Some(&lift_off_half.neutral)
            }
            TrajectoryKind::Swing { .. } => {
                (self.section == SECTIONS + LANDING).then_some(&self.ends[1])
            }
        }
    }
}

/// How far the swing sole travels in a section of a swing, m.
fn length(lift_off_half: &HalfSwing, landing_half: &HalfSwing, section: usize) -> f64 {
    if section < SECTIONS {
        lift_off_half.length(SECTIONS - 1 - section)
    } else {
        landing_half.length(section - SECTIONS)
    }
}

/// The largest share of a step limit between two states.
fn step_use(constraints: &Constraints, a: &ModeState, b: &ModeState) -> f64 {
    let joints = a.configuration.q.iter().zip(&b.configuration.q);
    let joint_step = joints.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    let [from, to] = [a, b].map(|state| state.configuration.world_from_root.translation);
    let soles = a.world_from_soles.iter().zip(&b.world_from_soles);
    let travel =
        soles.map(|(x, y)| x.translation.distance(y.translation)).fold(from.distance(to), f64::max);
    (joint_step / constraints.config.waypoint_joint_step).max(travel / TRAVEL_MAX)
}
