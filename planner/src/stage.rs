//! The stages of a search by name, for whoever measures where its work goes.

/// A stage of the search; `rpg` shows what each does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Stage {
    /// The robot is stood on the start and the goal.
    Ends,
    /// A guide route is sought and cut into segments.
    Route,
    /// Placements are sampled along the guide route.
    Seed,
    /// Placements are joined by transitions.
    Connect,
    /// The cheapest sequence of transitions is sought.
    Sequence,
    /// Transitions get configurations.
    Sample,
    /// Hops get motions.
    Move,
    /// The motions are shortened.
    Polish,
    /// The plan's chunks are put together.
    Assemble,
    /// The search is over.
    Over,
}

impl Stage {
    /// How many stages do work.
    pub const COUNT: usize = 9;
    /// Their names in reports, by discriminant.
    pub const NAMES: [&'static str; Self::COUNT] = [
        "endpoints",
        "route",
        "footholds",
        "transitions",
        "sequence",
        "configurations",
        "motions",
        "shortcuts",
        "chunks",
    ];
}
