//! A primitive trajectory, sampled waypoint by waypoint.

use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::Foothold;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::primitives::gait::Gait;
use crate::primitives::step_path::{HalfSwing, LANDING, SECTIONS, configuration, shift_at};
use crate::primitives::step_state::{foot_phase, with_legs};
use crate::primitives::tuning::{SECTION_STEP_FIRST, STEP_AIM, WAYPOINT_DISTANCE_MAX};

/// The smallest step along a section, as a share of it. A smaller one means that a joint jumps.
const SECTION_STEP_MIN: f64 = 1.0 / 4096.0;
/// Length up to which a section is empty, m.
const SECTION_LENGTH_MIN: f64 = 1e-6;

/// The trajectory of one primitive. Adjoining trajectories share the same end configuration.
#[derive(Debug, Clone)]
pub struct PrimitiveTrajectory {
    kind: TrajectoryKind,
    ends: [ModeState; 2],
    /// The state of the last waypoint.
    here: ModeState,
    /// The index of the section that contains the next waypoint.
    section: usize,
    /// The completed fraction of the section.
    done: f64,
    /// The step to try next, as a fraction of the section.
    step: f64,
}

#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate during the search")]
enum TrajectoryKind {
    /// A half swing backwards, then a half swing.
    Swing { lift_off_half: HalfSwing, landing_half: HalfSwing },
    /// From one end to the other, both feet in contact.
    Shift,
}

impl PrimitiveTrajectory {
    /// The swing over `stance` from the primitive configuration on `from` to the one on `to`.
    ///
    /// # Errors
    /// A leg does not reach. This cannot happen where C_S holds.
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
            Self { kind, here: ends[0], ends, section: 0, done: 0.0, step: SECTION_STEP_FIRST };
        trajectory.skip_empty();
        trajectory
    }

    /// The configurations at both ends.
    pub fn ends(&self) -> &[ModeState; 2] {
        &self.ends
    }

    /// Whether the last waypoint is sampled.
    pub fn is_over(&self) -> bool {
        self.section == self.sections_count()
    }

    /// Tries one step. Returns the next waypoint and the swing foot's phase between the last
    /// waypoint and it, or `None` if the step was too long: the next call tries a shorter one. Must
    /// not be called after the last waypoint.
    ///
    /// # Errors
    /// A leg does not reach, or jumps. This cannot happen where C_S holds.
    pub fn advance(
        &mut self,
        constraints: &Constraints,
    ) -> Result<Option<(&ModeState, FootPhase)>, Rejection> {
        if self.step < SECTION_STEP_MIN {
            return Err(Rejection::Discontinuous);
        }
        let ahead = if self.done + self.step > 1.0 - SECTION_STEP_MIN {
            1.0
        } else {
            self.done + self.step
        };
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
            (self.section, self.done, self.step) = (self.section + 1, 0.0, SECTION_STEP_FIRST);
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

    /// Advances to the next section that is not empty.
    fn skip_empty(&mut self) {
        while let TrajectoryKind::Swing { lift_off_half, landing_half } = &self.kind
            && self.section < 2 * SECTIONS
            && length(lift_off_half, landing_half, self.section) <= SECTION_LENGTH_MIN
        {
            self.section += 1;
        }
    }

    /// The state at the fraction `t` of the section, before the legs are solved for its soles, and
    /// the swing foot's phase.
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

    /// The state at the end of the section, if it is known exactly.
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

/// The distance that the swing sole moves in a section of a swing, m.
fn length(lift_off_half: &HalfSwing, landing_half: &HalfSwing, section: usize) -> f64 {
    if section < SECTIONS {
        lift_off_half.length(SECTIONS - 1 - section)
    } else {
        landing_half.length(section - SECTIONS)
    }
}

/// The step between two states as a share of the step limits: joint step, distance of root and
/// soles.
fn step_use(constraints: &Constraints, a: &ModeState, b: &ModeState) -> f64 {
    let joints = a.configuration.q.iter().zip(&b.configuration.q);
    let joint_step = joints.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    let [from, to] = [a, b].map(|state| state.configuration.world_from_root.translation);
    let soles = a.world_from_soles.iter().zip(&b.world_from_soles);
    let distance =
        soles.map(|(x, y)| x.translation.distance(y.translation)).fold(from.distance(to), f64::max);
    (joint_step / constraints.config.waypoint_joint_step).max(distance / WAYPOINT_DISTANCE_MAX)
}
