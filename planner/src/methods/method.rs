//! The methods by name, and their parameters.

/// How a walk is searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// The Randomized Possibility Graph [Grey 3, 4].
    #[default]
    Rpg,
    /// Its simplified form, w-RPG [Grey 5.3].
    WRpg,
    /// w-RPG without stage P: placements are uniform over the world [Grey 5.7].
    Mmprm,
    /// One tree over modes and configurations (Hauser 2010) [Grey 2.3].
    RandomMmp,
    /// A* over a fixed set of steps (Kuffner 2001, Chestnutt 2005).
    Astar,
    /// The same with placements adapted to the ground (Chestnutt 2007).
    AstarAdaptive,
    /// A* over the same steps where C_S holds, with primitives alone [Grey 2.1, 4.1.1].
    BoundingBox,
    /// Reachability-guided: one contact sequence along a guide route, one interpolation, else
    /// another route (Tonneau 2018) [Grey 2.1].
    Reachability,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 8] = [
        Self::Rpg,
        Self::WRpg,
        Self::Mmprm,
        Self::RandomMmp,
        Self::Astar,
        Self::AstarAdaptive,
        Self::BoundingBox,
        Self::Reachability,
    ];

    /// The method's name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rpg => "rpg",
            Self::WRpg => "w-rpg",
            Self::Mmprm => "mmprm",
            Self::RandomMmp => "random-mmp",
            Self::Astar => "astar",
            Self::AstarAdaptive => "astar-adaptive",
            Self::BoundingBox => "bounding-box",
            Self::Reachability => "reachability",
        }
    }

    /// The method of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|method| method.name() == name)
    }
}

/// The parameters of [`Method::WRpg`] and [`Method::Mmprm`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodParameters {
    /// N_P: samples of C_N of one round.
    pub route_samples: u32,
    /// N_sigma: placements of each foot of one round.
    pub placements: u32,
    /// rho / R_max: radius of the discs about the vertices of a route, relative to the longest
    /// level step.
    pub disc_radius_share: f64,
    /// Most rounds; each adds as many samples again. 0: until the work limit.
    pub rounds_max: u32,
}

impl Default for MethodParameters {
    /// R_max as radius; as many samples as find a walk over 3 m of floor in most first rounds.
    fn default() -> Self {
        Self { route_samples: 100, placements: 400, disc_radius_share: 1.0, rounds_max: 0 }
    }
}
