//! The methods by name, and their parameters.

/// How a walk is searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// The Randomized Possibility Graph [Grey 3, 4].
    #[default]
    Rpg,
    /// As `Rpg`, but stage M samples placements uniformly in discs about the route, without any
    /// ideals: rho as a parameter of the full planner [Grey 5.7.2].
    RpgDiscs,
    /// The simplified form of `Rpg`, w-RPG [Grey 5.3].
    WRpg,
    /// w-RPG without stage P: placements are uniform over the world [Grey 5.7].
    Mmprm,
    /// One tree over modes and configurations (Hauser 2010) [Grey 2.3].
    RandomMmp,
    /// A* over a fixed set of steps (Kuffner 2001, Chestnutt 2005).
    Astar,
    /// As `Astar`, with placements adapted to the ground (Chestnutt 2007).
    AstarAdaptive,
    /// A* over the same steps where C_S holds, with primitives alone [Grey 2.1, 4.1.1].
    BoundingBox,
    /// Reachability-guided: one contact sequence along a guide route, one interpolation, else
    /// another route (Tonneau 2018) [Grey 2.1].
    Reachability,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 9] = [
        Self::Rpg,
        Self::RpgDiscs,
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
            Self::RpgDiscs => "rpg-discs",
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

/// rho / R_max at which discs grow no more: the least radius of the proof [Grey 5.8].
const GROWN_SHARE_MAX: f64 = 2.0;
/// Rounds after which a radius counts as full-grown.
const GROWING_ROUNDS_MAX: u64 = 1_000;

/// The parameters of [`Method::WRpg`], [`Method::Mmprm`] and [`Method::RpgDiscs`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodParameters {
    /// N_P: samples of C_N of one round.
    pub route_samples: u32,
    /// N_sigma: placements of each foot of one round.
    pub placements: u32,
    /// rho_0 / R_max: radius of the discs of the first round about the vertices of a route,
    /// relative to the longest level step.
    pub disc_radius_share: f64,
    /// g: the radius of each further round relative to the one before; 1 keeps it.
    pub disc_radius_growth: f64,
    /// Most rounds; each adds as many samples again. 0: until the work limit.
    pub rounds_max: u32,
}

impl Default for MethodParameters {
    /// R_max as radius; as many samples as find a walk over 3 m of floor in most first rounds.
    fn default() -> Self {
        Self {
            route_samples: 100,
            placements: 400,
            disc_radius_share: 1.0,
            disc_radius_growth: 1.0,
            rounds_max: 0,
        }
    }
}

impl MethodParameters {
    /// rho / R_max of a round, counted from 1: min(2, rho_0 g^(round - 1)), and never less than at
    /// first [Grey 5.7.2].
    pub fn disc_radius_share_of(&self, round: u64) -> f64 {
        let first = self.disc_radius_share;
        let rounds = round.saturating_sub(1).min(GROWING_ROUNDS_MAX);
        let grown = first * libm::pow(self.disc_radius_growth, rounds as f64);
        grown.min(GROWN_SHARE_MAX).max(first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discs_grow_up_to_twice_the_longest_step_and_never_shrink() {
        let shares = |disc_radius_share, disc_radius_growth| {
            let parameters = MethodParameters {
                disc_radius_share,
                disc_radius_growth,
                ..MethodParameters::default()
            };
            [1, 2, 3, 4, u64::MAX].map(|round| parameters.disc_radius_share_of(round))
        };
        assert_eq!(shares(0.5, 2.0), [0.5, 1.0, 2.0, 2.0, 2.0]);
        assert_eq!(shares(0.5, 1.0), [0.5; 5]);
        assert_eq!(shares(3.0, 2.0), [3.0; 5]);
        assert_eq!(shares(f64::INFINITY, 1.0), [f64::INFINITY; 5]);
    }
}
