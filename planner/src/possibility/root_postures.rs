//! Root poses over a pair of soles: heights, pitches and rolls of the root in which the
//! robot stands on both feet and on each of them [Grey 3.2, 4.1.1].
//!
//! They depend on the robot alone. Where no upright root pose leads on, stage P chooses among them,
//! and both its vertices and its edges then have a root pose in SE(3).

use crate::base::arena::reserve;
use crate::possibility::crouch_trial::{CrouchContext, CrouchTrial};
use crate::possibility::root_vertex::RootPosture;
use crate::possibility::tuning::{
    CROUCH_BATCH_MAX, DEEP_LEG_EXTENSIONS, POSTURE_LEG_EXTENSIONS, POSTURE_PITCHES, POSTURE_ROLLS,
    POSTURES_MAX, POSTURES_TRIED,
};
use crate::robot::crouch::Crouch;

/// The root postures of a robot, allocated once and drawn when they are needed.
#[derive(Debug)]
pub(crate) struct RootPostures {
    postures: Vec<RootPosture>,
    /// Number of postures tried.
    tried: u64,
    /// Number of postures to try.
    wanted: u64,
    /// Whether they roll.
    has_roll: bool,
}

impl RootPostures {
    /// No posture. Allocates.
    pub fn new() -> Self {
        Self { postures: reserve(POSTURES_MAX), tried: 0, wanted: 0, has_roll: true }
    }

    /// All postures so far, the upright one first.
    pub fn all(&self) -> &[RootPosture] {
        &self.postures
    }

    /// Leaves out the roll: for measurements.
    pub fn leave_out_roll(&mut self) {
        self.has_roll = false;
    }

    /// Asks for more postures.
    pub fn ask_for_more(&mut self) {
        self.wanted = self.tried + POSTURES_TRIED;
    }

    /// Whether postures that were asked for are not tried yet.
    pub fn is_due(&self) -> bool {
        self.tried < self.wanted && self.postures.len() < POSTURES_MAX
    }

    /// Tries at most `budget` postures, with feet that are at least `stance_width` (m) apart.
    /// Returns their number.
    pub fn advance(&mut self, context: &CrouchContext<'_>, stance_width: f64, budget: u64) -> u64 {
        if self.postures.is_empty() {
            let mid_feet_from_root = context.upper_body.mid_feet_from_root();
            self.postures.push(RootPosture { crouch: Crouch::UPRIGHT, mid_feet_from_root });
        }
        let count = (self.wanted - self.tried).min(budget.max(1)).min(CROUCH_BATCH_MAX as u64);
        let next: heapless::Vec<u64, CROUCH_BATCH_MAX> = (self.tried..self.tried + count).collect();
        let waist = context.constraints.waist_bend_max();
        let tried = context.threads.map(&next, |index| {
            let mut crouch = crouch(index, waist);
            if !self.has_roll {
                crouch.roll = 0.0;
            }
            let trial = CrouchTrial::new(context.constraints, context.upper_body, crouch);
            let mid_feet_from_root = trial.mid_feet_from_root()?;
            trial.may_step(stance_width).then_some(RootPosture { crouch, mid_feet_from_root })
        });
        let left = POSTURES_MAX - self.postures.len();
        self.postures.extend(tried.into_iter().flatten().take(left));
        self.tried += count;
        count
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.postures.capacity() * size_of::<RootPosture>()
    }
}

/// The crouches in the order in which they are tried: the additive recurrence of Roberts (2018),
/// whose points fill the box evenly from the first on. Half of them lean in one direction alone, as
/// most obstacles ask for. In every other four the waist is bent by `waist`, rad.
fn crouch(index: u64, waist: f64) -> Crouch {
    let within = |axis: usize, [lower, upper]: [f64; 2]| {
        let unit = ((index + 1) as f64 * RECURRENCE[axis]).fract();
        lower + unit * (upper - lower)
    };
    let is_deep = waist > 0.0 || index >= POSTURES_TRIED;
    let leg_extensions = if is_deep { DEEP_LEG_EXTENSIONS } else { POSTURE_LEG_EXTENSIONS };
    let waist = if index & 4 == 0 { 0.0 } else { waist };
    let mut crouch = Crouch {
        leg_extension: within(0, leg_extensions),
        pitch: within(1, POSTURE_PITCHES),
        roll: within(2, POSTURE_ROLLS),
        waist,
    };
    match index % 4 {
        0 => crouch.roll = 0.0,
        1 => crouch.pitch = 0.0,
        _ => {}
    }
    crouch
}

/// The powers of the inverse of the root of x^4 = x + 1.
const RECURRENCE: [f64; 3] = [0.8191725133961645, 0.6710436067037893, 0.5497004779019703];
