//! The order of a quaternion's numbers.

/// The order of a quaternion's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QuaternionOrder {
    /// x, y, z, w: ROS, Eigen's memory, SciPy.
    Xyzw,
    /// w, x, y, z: MuJoCo, Isaac Lab.
    Wxyz,
}

impl QuaternionOrder {
    /// The names of all orders.
    pub const NAMES: [&str; 2] = ["xyzw", "wxyz"];

    /// The order with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Xyzw, Self::Wxyz].into_iter().find(|order| order.name() == name)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// The names of the numbers in this order.
    pub fn letters(self) -> [char; 4] {
        match self {
            Self::Xyzw => ['x', 'y', 'z', 'w'],
            Self::Wxyz => ['w', 'x', 'y', 'z'],
        }
    }

    /// A quaternion x, y, z, w in this order.
    pub fn arrange(self, [x, y, z, w]: [f64; 4]) -> [f64; 4] {
        match self {
            Self::Xyzw => [x, y, z, w],
            Self::Wxyz => [w, x, y, z],
        }
    }
}
