//! Tables 4.1 and 4.2 as printed [Grey 4.5].

/// A row of the thesis: 100 trials, a timeout of one hour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Published {
    /// The table.
    pub table: &'static str,
    /// The row's name there.
    pub name: &'static str,
    /// Our reconstruction of its world.
    pub scenario: &'static str,
    /// Mean time, s.
    pub mean_seconds: f64,
    /// Standard deviation, s.
    pub std_seconds: f64,
    /// Trials of 100 that found a plan.
    pub found_of_100: u32,
}

const fn row(
    table: &'static str,
    name: &'static str,
    scenario: &'static str,
    mean_seconds: f64,
    std_seconds: f64,
    found_of_100: u32,
) -> Published {
    Published { table, name, scenario, mean_seconds, std_seconds, found_of_100 }
}

/// All rows, in the thesis's order.
pub const PUBLISHED: [Published; 9] = [
    row("4.1", "I-Beam Hallway", "ibeam_hallway", 30.59, 64.91, 100),
    row("4.1", "Cinder Blocks", "cinder_blocks", 148.74, 375.90, 99),
    row("4.1", "Full Jungle Gym", "jungle_gym_full", 1444.89, 813.77, 95),
    row("4.1", "Spiral Route", "jungle_gym_spiral_route", 992.70, 685.02, 96),
    row("4.1", "Stair Route", "jungle_gym_stair_route", 2031.50, 917.95, 89),
    row("4.2", "I-Beam", "beam", 255.71, 135.84, 100),
    row("4.2", "Stairs", "stairs", 602.16, 498.21, 99),
    row("4.2", "Monkey Bars", "monkey_bars", 803.69, 558.24, 97),
    row("4.2", "Spiral Steps", "spiral_steps", 832.30, 677.08, 95),
];

/// The row that a scenario reconstructs, if one.
pub fn of_scenario(scenario: &str) -> Option<&'static Published> {
    PUBLISHED.iter().find(|row| row.scenario == scenario)
}
