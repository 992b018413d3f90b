//! `surefoot prepare`: prepares a robot once, so that no walk has to wait for it.

use surefoot_planner::preparation::Preparation;
use surefoot_planner::primitives::Gait;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::load::load_robot;

use crate::cli::arguments::PrepareArguments;
use crate::input::preparation_cache::{Origin, Prepared, obtain};
use crate::input::shipped::robot_path;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::size::mib;
use crate::system::terminal;

/// Runs the command.
///
/// # Errors
/// The robot cannot be used.
pub fn run(arguments: &PrepareArguments) -> Result<CommandOutcome, CommandError> {
    let model = load_robot(&robot_path(&arguments.robot)?)?;
    let prepared = obtain(&model, &PlannerConfig::default(), arguments.quiet)?;
    terminal::print_result(&summary(&model.name, &prepared));
    Ok(CommandOutcome::Done)
}

fn summary(robot: &str, prepared: &Prepared) -> String {
    let origin = match &prepared.origin {
        Origin::Cached(path) => format!("read from {}", path.display()),
        Origin::Built { seconds, saved: Some(path) } => {
            format!("made in {seconds:.2} s, kept in {}", path.display())
        }
        Origin::Built { seconds, saved: None } => format!("made in {seconds:.2} s, not kept"),
    };
    let head = format!(
        "{robot}: {origin}\n  size         {:.1} MiB",
        mib(prepared.preparation.bytes().len())
    );
    [head, reach_lines(&prepared.preparation), gait_lines(&prepared.preparation)].join("\n")
}

fn gait_lines(preparation: &Preparation) -> String {
    let gait = preparation.gait();
    let Gait { leg_extension, width, tilt, lift_height, roll, lean } = gait;
    let head = format!(
        "  primitives   leg extension {leg_extension:.3}, width {width:.3} m, lift {lift_height:.3} m, roll {roll:.2} rad, lean {lean:.3} m, \
         soles inclined up to {tilt:.2} rad"
    );
    let line = |limb: usize, name: &str| {
        let (held, all) = preparation.range(limb).cells();
        let extent = preparation.range(limb).extent().map_or_else(
            String::new,
            |[ahead, aside, above, turn]| {
                let range = |[least, greatest]: [f64; 2]| format!("{least:.2} to {greatest:.2}");
                format!(
                    ": ahead {}, aside {}, above {} m, turn {} rad",
                    range(ahead),
                    range(aside),
                    range(above),
                    range(turn)
                )
            },
        );
        format!("  range {name:<6} {held} of {all} cells{extent}")
    };
    [head, line(0, "left"), line(1, "right")].join("\n")
}

fn reach_lines(preparation: &Preparation) -> String {
    let line = |limb: usize, name: &str| {
        let reach = preparation.reach(limb);
        format!(
            "  reach {name:<6} {} voxels, {:.3} m3, {} blocks",
            reach.cubes(),
            reach.volume(),
            reach.blocks().len()
        )
    };
    [line(0, "left"), line(1, "right")].join("\n")
}
