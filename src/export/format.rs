//! The formats of exports.

/// A format of an export.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportFormat {
    /// A table of samples as text.
    Csv,
    /// Arrays of samples for NumPy.
    Npz,
    /// A list of footsteps as JSON.
    Footsteps,
    /// Phases, contacts, centre of mass and wrenches as JSON.
    Contacts,
    /// Keyframes for MuJoCo as XML.
    Keyframes,
    /// A recording of ROS 2 messages.
    Mcap,
}

impl ExportFormat {
    /// The names of all formats.
    pub const NAMES: [&str; 6] = ["csv", "npz", "footsteps", "contacts", "mujoco", "mcap"];
    const ALL: [Self; 6] =
        [Self::Csv, Self::Npz, Self::Footsteps, Self::Contacts, Self::Keyframes, Self::Mcap];

    /// The format with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}
