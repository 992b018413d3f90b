//! `surefoot doctor`: whether this machine can run a walk, and what to change if it cannot.

mod finding;
mod machine;
mod round_trip;

use std::num::NonZeroUsize;
use std::path::Path;

use surefoot_controller_sim::{Checker, HollowSole};
use surefoot_planner::Planner;
use surefoot_shared_types::robot::load::impossible_inertias;
use surefoot_shared_types::robot::model::RobotModel;

use crate::cli::arguments::DoctorArguments;
use crate::commands::doctor::finding::Finding;
use crate::input::inputs::{Inputs, Overrides};
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::instance::create_own_instance;
use crate::system::size::mib;
use crate::system::{cores, terminal};

/// Soles of which less than this share can carry are useless, percent.
const CARRYING_MIN: f64 = 10.0;
/// Soles of which this share can carry are good, percent.
const CARRYING_GOOD_MIN: f64 = 90.0;

/// Runs the command.
///
/// # Errors
/// A requirement of every walk is not met.
pub fn run(arguments: &DoctorArguments) -> Result<CommandOutcome, CommandError> {
    let mut missing = 0;
    let mut show = |findings: Vec<Finding>| {
        missing += findings.iter().filter(|finding| finding.is_missing()).count();
        findings.iter().for_each(|finding| terminal::print_result(&finding.line()));
    };
    show(machine::shared_memory());
    show(vec![machine::cores()]);
    show(machine::limits());
    show(transport());
    if let Some(scenario) = &arguments.scenario {
        show(self::scenario(scenario));
    }
    if missing > 0 {
        Err(CommandError::MissingRequirements { missing })
    } else {
        Ok(CommandOutcome::Done)
    }
}

/// Whether chunks travel through a private instance.
fn transport() -> Vec<Finding> {
    let instance = match create_own_instance("doctor") {
        Ok(instance) => instance,
        Err(error) => return vec![Finding::missing(format!("instance: {error}"))],
    };
    let root = Finding::good(format!("instance: {} is private", instance.root().display()));
    let chunks = match round_trip::run(&instance) {
        Ok(round_trip) => Finding::good(format!("iceoryx2: {round_trip}")),
        Err(reason) => Finding::missing(format!("iceoryx2: {reason}")),
    };
    vec![root, chunks]
}

/// Whether the scenario can be loaded, the memory of its planner, and whether its robot can stand
/// on one foot.
fn scenario(path: &Path) -> Vec<Finding> {
    let threads = NonZeroUsize::new(cores::default_threads()).unwrap_or(NonZeroUsize::MIN);
    let inputs = match Inputs::load(path, Overrides::default()) {
        Ok(inputs) => inputs,
        Err(error) => return vec![Finding::missing(format!("scenario: {error}"))],
    };
    let planner = inputs.preparation(false).and_then(|preparation| {
        Ok(Planner::builder(&inputs.model, &inputs.world, &inputs.scenario, preparation)
            .threads(threads)
            .build()?)
    });
    match planner {
        Ok(planner) => {
            let findings = [arenas(&inputs, &planner), on_one_foot(&inputs, &planner)];
            let findings = findings.into_iter().chain(inertias(&inputs.model));
            findings.chain(collision_pairs(&inputs)).collect()
        }
        Err(error) => vec![Finding::missing(format!("scenario: {error}"))],
    }
}

/// What the controller's checks leave out: the pairs of links that may overlap, the links without a
/// shape, and the parts of soles that carry nothing.
fn collision_pairs(inputs: &Inputs) -> Vec<Finding> {
    let Inputs { model, world, scenario, .. } = inputs;
    let checker = match Checker::new(model.clone(), world.clone(), scenario.checker.clone()) {
        Ok(checker) => checker,
        Err(error) => return vec![Finding::missing(format!("controller: {error}"))],
    };
    let overlaps = checker.allowed_overlaps().iter();
    let unshaped = checker.unshaped_links().map(|link| {
        Finding::advice(format!("robot: no collision check covers {link}, which has no shape"))
    });
    let idle = checker.idle_overlaps().iter();
    let idle = idle.map(|line| Finding::advice(format!("robot: {line}; remove it")));
    let overlaps = overlaps.map(|line| Finding::good(format!("robot: {line}")));
    let hollow = checker.hollow_soles().map(|sole| hollow_sole(&sole));
    overlaps.chain(hollow).chain(unshaped).chain(idle).collect()
}

/// What a sole that its foot does not fill means for walks: the planner trusts the declared sole.
fn hollow_sole(sole: &HollowSole) -> Finding {
    if sole.percent_carrying < CARRYING_MIN {
        return Finding::missing(format!(
            "robot: {sole}: the controller refuses walks on it; declare a smaller sole where the foot \
             is flat ('surefoot robot add' finds soles), or correct the shapes of the foot"
        ));
    }
    if sole.percent_carrying < CARRYING_GOOD_MIN {
        return Finding::advice(format!(
            "robot: {sole}: the controller refuses walks that lean on the rest; declare a smaller sole"
        ));
    }
    Finding::good(format!("robot: {sole}"))
}

/// The links whose inertias no body has, in one line; nothing if there are none.
fn inertias(model: &RobotModel) -> Option<Finding> {
    let links = match impossible_inertias(model) {
        Ok(links) => links,
        Err(error) => return Some(Finding::missing(format!("robot: {error}"))),
    };
    let link = |(name, line): &(String, usize)| format!("'{name}' (line {line})");
    let named = links.iter().map(link).collect::<Vec<_>>().join(", ");
    (!links.is_empty()).then(|| {
        Finding::advice(format!(
            "robot: {}: a moment of inertia exceeds the sum of the other two, which no body has: \
             {named}; torques of fast motions are a little off, and Drake and MuJoCo refuse the file",
            model.urdf_path.display(),
        ))
    })
}

fn arenas(inputs: &Inputs, planner: &Planner) -> Finding {
    let arenas = planner.arena_bytes();
    let total: usize = arenas.iter().map(|(_, bytes)| bytes).sum();
    let parts: Vec<String> =
        arenas.iter().map(|(name, bytes)| format!("{name} {:.1}", mib(*bytes))).collect();
    Finding::good(format!(
        "scenario: '{}' needs {:.1} MiB of arenas: {}",
        inputs.scenario.name,
        mib(total),
        parts.join(", ")
    ))
}

/// The largest share of a joint's effort limit in single support on the worse foot.
fn on_one_foot(inputs: &Inputs, planner: &Planner) -> Finding {
    let postures = planner.constraints().single_support_postures;
    let [left, right] = postures.each_ref().map(|posture| posture.effort_use);
    let limb = usize::from(right > left);
    let (robot, foot) = (&inputs.model.name, &inputs.model.feet[limb].name);
    let Some(joint) = postures[limb].most_strained else {
        return Finding::advice(format!(
            "robot: '{robot}' has no posture on '{foot}' alone near the one in [standing]"
        ));
    };
    let (joint, percent) = (&inputs.model.joints[joint].name, 100.0 * postures[limb].effort_use);
    let asked = format!(
        "robot: '{robot}' on '{foot}' alone needs {percent:.0} % of the effort limit of '{joint}'"
    );
    if percent <= 100.0 {
        return Finding::good(asked);
    }
    let share = inputs.scenario.planner.effort_share;
    Finding::advice(format!(
        "{asked}: few walks can be found; planner.effort_share allows {share} of the URDF's limit"
    ))
}

#[cfg(test)]
mod tests {
    use surefoot_shared_types::robot::load::load_robot;

    use super::*;

    #[test]
    fn links_whose_inertia_no_body_has_are_one_line() {
        let hubo = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/robots/hubo/robot.toml");
        let mut model = load_robot(Path::new(hubo)).unwrap();
        assert_eq!(inertias(&model), None);
        let urdf = std::fs::read_to_string(&model.urdf_path).unwrap();
        let (folder, large) = (tempfile::tempdir().unwrap(), "izz=\"9.9\"");
        let moment = |at: usize| urdf[at..].find("izz=\"").map(|from| at + from);
        let first = moment(0).unwrap();
        let second = moment(first + 1).unwrap();
        let end = |at: usize| at + 5 + urdf[at + 5..].find('"').unwrap() + 1;
        let between = &urdf[end(first)..second];
        let text = [&urdf[..first], large, between, large, &urdf[end(second)..]].concat();
        model.urdf_path = folder.path().join("odd.urdf");
        std::fs::write(&model.urdf_path, text).unwrap();
        let line = inertias(&model).unwrap().line();
        assert!(line.starts_with("advice   robot: /"), "{line}");
        assert!(line.contains("/odd.urdf: ") && !line.contains('\n'), "{line}");
        assert_eq!(line.matches(" (line ").count(), 2, "{line}");
    }
}
