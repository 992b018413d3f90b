//! Why the checker cannot be built for a robot or a world.

/// A robot or a world that cannot be checked.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CheckerError {
    /// The robot has more moving joints than a message holds.
    #[error(
        "the robot has {joints} moving joints; at most {max} fit a message: lock some in the robot \
         file"
    )]
    TooManyJoints {
        /// The robot's moving joints.
        joints: usize,
        /// The most that a message holds.
        max: usize,
    },
    /// The robot is not a biped.
    #[error(
        "the robot has {feet} feet; the checker supports bipeds only: name a left and a right foot \
         in the robot file"
    )]
    NotABiped {
        /// The robot's feet.
        feet: usize,
    },
    /// A shape that the geometry code cannot represent.
    #[error("unusable shape: {0}")]
    Shape(String),
    /// A declared sole that does not lie on the foot's own shapes.
    #[error(
        "the sole of foot '{foot}' has a vertex {millimetres} mm off the foot's collision shapes: \
         correct the sole in the robot file"
    )]
    SoleOffFoot {
        /// The foot.
        foot: String,
        /// The distance, rounded up, mm.
        millimetres: u64,
    },
    /// A foot that reaches below its declared sole.
    #[error(
        "foot '{foot}' reaches {millimetres} mm below its sole: correct the sole in the robot file"
    )]
    FootBelowSole {
        /// The foot.
        foot: String,
        /// The distance, rounded up, mm.
        millimetres: u64,
    },
}
