//! Shortcuts of the motions of a walk: shorter, valid, within their share of the work, independent
//! of threads and budgets [Grey 4.4.6].

#![allow(clippy::unwrap_used, reason = "a test ends where a plan is not found")]

mod common;

use common::{Case, run};
use glam::DVec3;
use surefoot_planner::Outcome;
use surefoot_planner::Planner;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::collision::model::FootPhase;
use surefoot_planner::constraints::constraints::Constraints;
use surefoot_planner::constraints::mode::Mode;
use surefoot_planner::constraints::mode_state::ModeState;
use surefoot_planner::motion::local_planner::{LocalPath, LocalPlanner, Progress, feasible_state};
use surefoot_planner::motion::shortcut::{Pass, Shortcutting, distance, length};
use surefoot_planner::motion::swing_shapes::MotionShape;
use surefoot_planner::motion::workspace::Workspace;
use surefoot_planner::pipeline::{SearchStats, WorkCategory};
use surefoot_planner::plan::self_check::{configuration_of, mode_of, self_check};
use surefoot_planner::robot::configuration::Configuration;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::message::PlanChunk;

const SHORTCUT_WORK: usize = WorkCategory::Shortcuts as usize;

fn case(name: &str, seed: u64, share: f64) -> Case {
    Case::shipped(name).with_seed(seed).configured(|planner| planner.shortcut_work_share = share)
}

fn found(case: &Case, threads: usize, step: u64) -> Planner {
    let mut planner = case.planner(threads);
    assert_eq!(run(&mut planner, step), Outcome::Found, "{}", case.scenario.name);
    planner
}

/// The motions of a plan: consecutive chunks with the same contacts.
fn motions(chunks: &[PlanChunk]) -> Vec<Vec<Configuration>> {
    let mut motions: Vec<Vec<Configuration>> = vec![];
    for (index, chunk) in chunks.iter().enumerate() {
        let goes_on = index > 0
            && chunks[index - 1].contacts() == chunk.contacts()
            && chunks[index - 1].mode == chunk.mode;
        if !goes_on {
            motions.push(vec![]);
        }
        let waypoints = chunk.waypoints().iter().skip(usize::from(goes_on));
        motions.last_mut().unwrap().extend(waypoints.map(configuration_of));
    }
    motions
}

#[test]
fn motions_become_shorter_and_none_longer() {
    for (name, seed) in [("flat_walk", 1), ("ibeam_gap", 2), ("stairs", 3), ("cinder_blocks", 1)] {
        let [before, after] = [0.0, 1.0].map(|share| found(&case(name, seed, share), 1, u64::MAX));
        assert_eq!(before.steps(), after.steps(), "{name}");
        self_check(after.constraints(), after.chunks()).unwrap();
        let [before, after] = [before, after].map(|planner| motions(planner.chunks()));
        assert_eq!(before.len(), after.len(), "{name}");
        for (old, new) in before.iter().zip(&after) {
            assert!(
                length(new) <= length(old) + 1e-9 && new.len() <= old.len(),
                "{name}: a motion is longer than before"
            );
            let ends = [(&old[0], &new[0]), (&old[old.len() - 1], &new[new.len() - 1])];
            assert!(
                ends.iter().all(|(old, new)| distance(old, new) < 1e-12),
                "{name}: a motion has other ends than before"
            );
        }
        let [old, new] = [&before, &after]
            .map(|motions| motions.iter().map(|motion| length(motion)).sum::<f64>());
        assert!(new < 0.95 * old, "{name}: length {old} became {new}");
    }
}

#[test]
fn shortcuts_spend_at_most_their_share_of_the_work() {
    let off = found(&case("ibeam_gap", 1, 0.0), 1, u64::MAX).stats();
    assert_eq!(off.work_by_category[SHORTCUT_WORK], 0);
    let search = off.work - off.work_by_category[WorkCategory::Chunks as usize];
    for share in [0.02, 0.1, 0.5] {
        let on = found(&case("ibeam_gap", 1, share), 1, u64::MAX).stats();
        let spent = on.work_by_category[SHORTCUT_WORK];
        assert!(
            spent > 0 && spent <= (share * search as f64) as u64 + 2,
            "{spent} units of {search}"
        );
        assert_eq!(on.work, search + spent + on.work_by_category[WorkCategory::Chunks as usize]);
    }
}

/// A plan that is found within a work limit without shortcuts is found within it with shortcuts.
#[test]
fn shortcuts_do_not_cost_a_plan() {
    let needed = found(&case("stepping_stones", 1, 0.0), 1, u64::MAX).stats().work;
    for more in [0, 1, 2, 50, 100, 101, 102, 103, 200, 300] {
        let mut planner = case("stepping_stones", 1, 1.0)
            .configured(|planner| planner.work_max = needed + more)
            .planner(1);
        assert_eq!(run(&mut planner, u64::MAX), Outcome::Found, "{more} units more than needed");
    }
}

#[test]
fn threads_and_budgets_do_not_change_the_shortcuts() {
    let plan = |threads, step| -> (Digest, SearchStats) {
        let planner = found(&case("ibeam_gap", 1, 1.0), threads, step);
        (planner.digest(), planner.stats())
    };
    let alone = plan(1, u64::MAX);
    assert!(alone.1.work_by_category[SHORTCUT_WORK] > 0);
    for (threads, step) in [(2, u64::MAX), (3, 1_000), (4, 7), (1, 1)] {
        assert_eq!(plan(threads, step), alone, "{threads} threads, {step} work units per step");
    }
}

#[test]
fn a_step_never_exceeds_its_work() {
    let mut planner = case("ibeam_gap", 1, 1.0).planner(1);
    for work in [1, 2, 3, 100].into_iter().cycle() {
        let before = planner.stats();
        planner.step(work);
        let after = planner.stats();
        assert!(after.work - before.work <= work);
        if after.work_by_category[WorkCategory::Chunks as usize] > 0 {
            break;
        }
    }
    assert!(planner.stats().work_by_category[SHORTCUT_WORK] > 0);
}

/// The mode and the state at the start of a walk.
fn standing(planner: &Planner) -> (Mode, ModeState) {
    let chunk = &planner.chunks()[0];
    let mode = mode_of(chunk).unwrap();
    let configuration = configuration_of(&chunk.waypoints()[0]);
    let state = ModeState { configuration, world_from_soles: mode.world_from_soles };
    (mode, state)
}

/// A state with its root displaced by a vector, m.
fn moved(constraints: &Constraints, mode: &Mode, state: &ModeState, by: DVec3) -> ModeState {
    let mut desired = *state;
    desired.configuration.world_from_root.translation += by;
    feasible_state(constraints, mode, &desired).unwrap()
}

/// A motion through the given states, its first one included.
fn path_over(constraints: &Constraints, mode: &Mode, states: &[ModeState]) -> Vec<Configuration> {
    let mut path = vec![states[0].configuration];
    for pair in states.windows(2) {
        let local_path = LocalPath {
            from: pair[0],
            to: pair[1],
            exact: true,
            shape: MotionShape::STRAIGHT,
            swing_foot: FootPhase::Swing,
        };
        let mut local_planner = LocalPlanner::default();
        local_planner.begin(constraints, &local_path);
        loop {
            let progress = local_planner.advance(constraints, mode).unwrap();
            if progress != Progress::ShorterStep {
                path.push(local_planner.state().configuration);
            }
            if progress == Progress::Reached {
                break;
            }
        }
    }
    path
}

fn shortened(
    constraints: &Constraints,
    mode: &Mode,
    path: &[Configuration],
    pass: Pass,
    work: u64,
) -> Vec<Configuration> {
    let mut workspace = Workspace::new(1024, 2);
    workspace.path.extend_from_slice(path);
    let mut search =
        Shortcutting::new(pass, mode.clone(), Random::new(1, Stream::Shortcut, 0, 0), work);
    while !search.has_ended() {
        search.advance(constraints, &mut workspace);
    }
    workspace.path
}

#[test]
fn a_detour_is_removed_and_corners_are_cut() {
    let planner = found(&case("flat_walk", 1, 0.0), 1, u64::MAX);
    let constraints = planner.constraints();
    let (mode, here) = standing(&planner);
    let at = |x: f64, z: f64| moved(constraints, &mode, &here, DVec3::new(x, 0.0, z));
    let (low, back, ahead) = (at(0.0, -0.02), at(-0.03, -0.1), at(0.03, -0.02));
    let [straight, detour] = [vec![low, ahead], vec![low, back, ahead]]
        .map(|states| path_over(constraints, &mode, &states));
    assert!(length(&detour) > 1.5 * length(&straight));

    let cut = shortened(constraints, &mode, &detour, Pass::Shortcuts, 10_000);
    assert!(
        length(&cut) < 1.01 * length(&straight),
        "{} against {}",
        length(&cut),
        length(&straight)
    );
    assert!(
        distance(&cut[0], &detour[0]) < 1e-12
            && distance(cut.last().unwrap(), detour.last().unwrap()) < 1e-12
    );

    let rounded = shortened(constraints, &mode, &detour, Pass::Corners, 10_000);
    assert!(length(&rounded) < length(&detour) && rounded.len() <= detour.len());

    let unchanged = shortened(constraints, &mode, &detour, Pass::Shortcuts, 0);
    assert_eq!(unchanged.len(), detour.len());
}
