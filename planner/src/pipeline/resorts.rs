//! The last resorts of the search, as docs/COMPLETENESS.md names them.

/// What the search does only after it has failed again and again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Resort {
    /// A region of stage P that grows to the whole world, where it holds no route.
    WiderRegion,
    /// Root poses of any height and lean in stage P, where no upright route is free.
    LeaningRoot,
    /// C_N alone decides about vertices of stage P, where no route meets its other conditions.
    NecessaryCondition,
    /// Further configurations of Q(T) replace those between which no motion is found.
    Alternatives,
    /// Rounds of footholds that are uniform over position and heading.
    UniformRounds,
    /// Other postures at the goal replace the first one.
    GoalPostures,
    /// Margins that are little larger than those of the checker.
    LeastMargins,
}

impl Resort {
    /// All of them, in the order of docs/COMPLETENESS.md.
    pub const ALL: [Self; 7] = [
        Self::WiderRegion,
        Self::LeaningRoot,
        Self::NecessaryCondition,
        Self::Alternatives,
        Self::UniformRounds,
        Self::GoalPostures,
        Self::LeastMargins,
    ];

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::WiderRegion => "wider_region",
            Self::LeaningRoot => "leaning_root",
            Self::NecessaryCondition => "necessary_condition",
            Self::Alternatives => "alternatives",
            Self::UniformRounds => "uniform_rounds",
            Self::GoalPostures => "goal_postures",
            Self::LeastMargins => "least_margins",
        }
    }
}

/// The last resorts that a search may use: all, unless a measurement leaves some out.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Resorts {
    /// One bit for each that is left out.
    left_out: u8,
}

impl Resorts {
    /// Leaves one out.
    pub fn leave_out(&mut self, resort: Resort) {
        self.left_out |= 1 << resort as u8;
    }

    /// Whether the search may use one.
    pub fn has(self, resort: Resort) -> bool {
        self.left_out & 1 << resort as u8 == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_one_that_is_left_out_is_missing() {
        for left_out in Resort::ALL {
            let mut resorts = Resorts::default();
            resorts.leave_out(left_out);
            assert!(Resort::ALL.iter().all(|&resort| resorts.has(resort) == (resort != left_out)));
        }
    }
}
