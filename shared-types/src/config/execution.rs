//! The parameters of the motion that the robot executes.

/// How a plan moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionKind {
    /// In straight lines at slow speeds, with a rest at the end of every chunk.
    QuasiStatic,
    /// With continuous accelerations, as fast as the limits allow; a chunk may end in motion.
    #[default]
    Smooth,
}

impl MotionKind {
    /// The names of all motions.
    pub const NAMES: [&'static str; 2] = ["quasi_static", "smooth"];

    /// Its name in scenarios and reports.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// The motion with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::QuasiStatic, Self::Smooth].into_iter().find(|motion| motion.name() == name)
    }
}

/// The parameters of the motion: a scenario's `[execution]` table, in which every field is
/// optional.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ExecutionConfig {
    /// How the plan moves.
    pub motion: MotionKind,
    /// Largest share of the limits of joint speed and effort that a smooth motion uses, 0 to 1.
    pub share: f64,
    /// Shortest time in which a robot brakes to a rest, or goes on from one, s.
    pub ramp_seconds_min: f64,
}

impl Default for ExecutionConfig {
    fn default() -> Self {
        Self { motion: MotionKind::default(), share: 0.8, ramp_seconds_min: 0.5 }
    }
}
