//! Every outcome of a search, and every robot and world for which no planner is built.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use bytemuck::Zeroable;
use common::{Case, chain_robot, hinge, preparation_for, run};
use glam::DVec3;
use surefoot_planner::base::capacity::ArenaFull;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::collision::model::Hit;
use surefoot_planner::constraints::rejection::Rejection;
use surefoot_planner::foot_placement::sole_support::{NoSupport, SurfacesError};
use surefoot_planner::kinematics::leg::LegError;
use surefoot_planner::pipeline::outcome::{Bound, EndpointError};
use surefoot_planner::relaxation::{Blockage, Obstruction};
use surefoot_planner::robot::mechanism::{LINKS_MAX, MechanismError};
use surefoot_planner::{Outcome, Planner, PlannerError, Status};
use surefoot_shared_types::base::spatial::yaw_of;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::config::scenario::StancePose;
use surefoot_shared_types::message::{Contact, RestState, SupportMode, Waypoint};
use surefoot_shared_types::robot::model::{Foot, Link};
use surefoot_shared_types::{Pose, Shape};

const STEP: u64 = 20_000;

fn outcome_of(case: &Case) -> Outcome {
    let mut planner = case.planner(2);
    let outcome = run(&mut planner, STEP);
    assert_eq!(planner.step(STEP), Status::Done(outcome), "an outcome is final");
    let found = outcome == Outcome::Found;
    assert_eq!(found, !planner.chunks().is_empty(), "chunks if and only if a plan was found");
    assert_eq!(found, planner.digest() != Default::default());
    outcome
}

fn flat_walk() -> Case {
    Case::shipped("flat_walk")
}

#[test]
fn a_walk_on_the_floor_is_found() {
    assert_eq!(outcome_of(&flat_walk()), Outcome::Found);
}

#[test]
fn steep_stairs_are_climbed_without_a_straight_forward_sole() {
    for seed in 1..=3 {
        let mut planner = Case::shipped("stairs_steep").with_seed(seed).planner(1);
        assert_eq!(run(&mut planner, u64::MAX), Outcome::Found, "seed {seed}");
        let contacts = planner.chunks().iter().flat_map(|chunk| chunk.contacts());
        let is_on_a_tread = |pose: &Pose| (0.1..1.5).contains(&pose.translation.z);
        let treads = contacts.map(|contact| contact.world_from_sole()).filter(is_on_a_tread);
        let headings = treads.map(|pose| yaw_of(pose.rotation).abs());
        let straightest = headings.fold(f64::INFINITY, f64::min);
        assert!(straightest.is_finite() && straightest > 15f64.to_radians(), "{straightest} rad");
    }
}

#[test]
fn no_plan_leads_through_a_wall() {
    for name in ["no_way_island", "no_way_wall"] {
        assert_eq!(outcome_of(&Case::shipped(name)).name(), "impossible", "{name}");
    }
    let case = Case::shipped("no_way_ceiling");
    assert_eq!(outcome_of(&case), Outcome::BudgetExhausted(Bound::Work));
}

#[test]
fn no_plan_leads_anywhere_without_friction() {
    for case in [flat_walk(), Case::smooth("stairs")] {
        let mut planner = without_friction(case).planner(1);
        let outcome = run(&mut planner, STEP);
        assert_eq!(outcome, Outcome::Impossible(Obstruction::NoFriction));
        assert_eq!(planner.stats().work, 1);
        assert!(planner.describe(&outcome).contains("no friction (mu = 0)"));
    }
    // A robot that stands in its goal stays there.
    let mut arrived = without_friction(flat_walk());
    arrived.scenario.goal = arrived.scenario.start;
    assert_eq!(run(&mut arrived.planner(1), STEP), Outcome::Found);
}

fn without_friction(mut case: Case) -> Case {
    case.world.mu = 0.0;
    case
}

#[test]
fn a_search_ends_with_the_step_that_exhausts_its_budget() {
    const WORK_MAX: u64 = 2_000;
    let mut planner = flat_walk().configured(|planner| planner.work_max = WORK_MAX).planner(1);
    let mut before = 0;
    while planner.step(1) == Status::Working {
        before = planner.stats().work;
    }
    assert_eq!(planner.step(1), Status::Done(Outcome::BudgetExhausted(Bound::Work)));
    assert!(before < WORK_MAX && planner.stats().work >= WORK_MAX && planner.chunks().is_empty());
}

#[test]
fn a_full_arena_is_named_by_its_parameter() {
    type Shrink = fn(&mut PlannerConfig);
    let cases: [(Shrink, ArenaFull); 5] = [
        (|planner| planner.footholds_max = 3, ArenaFull::Footholds),
        (|planner| planner.footholds_max = 20, ArenaFull::Footholds),
        (|planner| planner.transitions_max = 4, ArenaFull::Transitions),
        (|planner| planner.waypoints_max = 64, ArenaFull::Waypoints),
        (|planner| planner.tree_vertices_max = 2, ArenaFull::TreeVertices),
    ];
    let parameters = serde_json::to_value(PlannerConfig::default()).unwrap();
    for (shrink, full) in cases {
        let outcome = outcome_of(&flat_walk().configured(shrink));
        assert_eq!(outcome, Outcome::ArenaFull(full));
        let bound = outcome.bound().unwrap();
        assert!(outcome.describe().contains(bound), "{}", outcome.describe());
        assert!(parameters.get(bound).is_some(), "planner.{bound} is not a parameter");
    }
}

#[test]
fn a_plan_has_at_most_waypoints_max_waypoints() {
    let mut planner = flat_walk().planner(1);
    assert_eq!(run(&mut planner, STEP), Outcome::Found);
    let waypoints = planner.waypoints() as u32;
    let with_capacity_for = |waypoints_max| {
        outcome_of(&flat_walk().configured(|planner| planner.waypoints_max = waypoints_max))
    };
    assert_eq!(with_capacity_for(waypoints), Outcome::Found);
    assert_eq!(with_capacity_for(waypoints - 1), Outcome::ArenaFull(ArenaFull::Waypoints));
}

#[test]
fn soles_find_the_ground_near_their_ideal_poses() {
    let mut case = flat_walk();
    let left = case.scenario.start.world_from_soles()[0].translation;
    case.world.shapes.clear();
    let case = case
        .with_box([5.0, 0.0, -0.23], [6.0, 1.0, 0.25])
        .with_box([left.x, left.y, 0.0], [0.2, 0.08, 0.07]);
    let mut planner = case.planner(1);
    assert_eq!(run(&mut planner, STEP), Outcome::Found);
    let heights = planner.chunks()[0]
        .contacts()
        .iter()
        .map(|contact| contact.position[2])
        .collect::<Vec<_>>();
    assert!((heights[0] - 0.07).abs() < 1e-3 && (heights[1] - 0.02).abs() < 1e-3, "{heights:?}");
}

type Change = fn(Case, &StancePose) -> Case;
type IsExpected = fn(&EndpointError) -> bool;

/// Changes that make a stance on the floor invalid, and the expected error.
const INVALID_STANCES: [(&str, Change, IsExpected); 5] = [
    ("the hole", without_floor, |fault| {
        matches!(fault, EndpointError::Unsupported { limb: 0, reason: NoSupport::NothingBelow })
    }),
    ("the block at the sole", block_under_left_sole, |fault| {
        matches!(fault, EndpointError::Unsupported { limb: 0, reason: NoSupport::Penetrates })
    }),
    ("the bar above the right toes", bar_over_right_toes, |fault| {
        *fault == EndpointError::FootCollides { limb: 1 }
    }),
    ("the wall through the robot", wall_through_body, |fault| {
        matches!(
            fault,
            EndpointError::NoPosture {
                rejection: Rejection::Collision,
                hit: Some(Hit::World { shape: 1 | 2, .. })
            }
        )
    }),
    ("weak motors", weak_motors, |fault| {
        *fault == EndpointError::NoPosture { rejection: Rejection::Torque, hit: None }
    }),
];

fn without_floor(mut case: Case, _: &StancePose) -> Case {
    case.world.shapes.clear();
    case.with_box([5.0, 50.0, -0.25], [1.0, 1.0, 0.25])
}

fn block_under_left_sole(case: Case, stance: &StancePose) -> Case {
    let left = stance.world_from_soles()[0].translation;
    case.with_box([left.x, left.y, 0.005], [0.02, 0.02, 0.005])
}

fn bar_over_right_toes(case: Case, stance: &StancePose) -> Case {
    let right = stance.world_from_soles()[1].translation;
    case.with_box([right.x + 0.1, right.y, 0.045], [0.02, 0.02, 0.015])
}

fn wall_through_body(case: Case, stance: &StancePose) -> Case {
    case.with_box([stance.position.x, stance.position.y, 1.0], [0.3, 1.0, 0.4])
}

fn weak_motors(case: Case, _: &StancePose) -> Case {
    case.configured(|planner| planner.effort_share = 1e-3)
}

/// Separate floors under start and goal, so that a change of one does not affect the other.
fn two_floors() -> Case {
    let mut case = flat_walk();
    case.world.shapes.clear();
    case.with_box([0.0, 0.0, -0.25], [2.5, 1.0, 0.25])
        .with_box([10.0, 0.0, -0.25], [2.5, 1.0, 0.25])
}

#[test]
fn a_sole_that_does_not_quite_fit_is_moved_aside() {
    for is_goal in [false, true] {
        let mut case = two_floors();
        case.scenario.start.position.x = 0.5;
        case.scenario.goal.position = case.scenario.start.position + DVec3::X;
        let stance = if is_goal { case.scenario.goal } else { case.scenario.start };
        let soles = stance.world_from_soles().map(|sole| sole.translation);
        // A bump under the left heel.
        let case = case.with_box([soles[0].x - 0.1, soles[0].y, 0.005], [0.02, 0.05, 0.005]);
        let mut planner = case.planner(1);
        assert_eq!(run(&mut planner, STEP), Outcome::Found, "goal {is_goal}");
        let chunk = if is_goal { planner.chunks().last() } else { planner.chunks().first() };
        for contact in chunk.unwrap().contacts() {
            let limb = contact.limb as usize;
            let moved = (DVec3::from(contact.position) - soles[limb]).truncate();
            assert!(moved.length() < 0.0301, "goal {is_goal}, limb {limb}: {moved}");
            assert!(limb == 1 || moved.length() > 0.005, "goal {is_goal}: {moved}");
        }
    }
}

#[test]
fn an_invalid_start_names_its_error() {
    for (what, change, expected) in INVALID_STANCES {
        let case = flat_walk();
        let stance = case.scenario.start;
        match outcome_of(&change(case, &stance)) {
            Outcome::StartInvalid(fault) if expected(&fault) => {}
            other => panic!("{what}: {other:?}"),
        }
    }
}

#[test]
fn a_start_with_the_feet_too_far_apart_is_out_of_reach() {
    let mut case = flat_walk();
    case.scenario.start.stance_width = 1.7;
    assert_eq!(
        outcome_of(&case),
        Outcome::StartInvalid(EndpointError::NoPosture {
            rejection: Rejection::Unreachable,
            hit: None
        })
    );
}

#[test]
fn a_start_with_one_foot_through_the_other_collides_with_itself() {
    let mut case = flat_walk();
    case.scenario.start.stance_width = 0.1;
    let mut planner = case.planner(1);
    let outcome = run(&mut planner, STEP);
    let named = planner.describe(&outcome);
    assert_eq!(outcome.name(), "start_invalid");
    assert!(named.ends_with(": link 'left_shin' collides with link 'right_shin'"), "{named}");
}

#[test]
fn a_start_in_the_air_is_unsupported() {
    let mut case = flat_walk();
    case.scenario.start.position.z = 0.4;
    let fault = EndpointError::Unsupported { limb: 0, reason: NoSupport::NothingBelow };
    assert_eq!(outcome_of(&case), Outcome::StartInvalid(fault));
}

#[test]
fn a_start_on_ground_too_rough_to_carry_says_how_uneven_it_is() {
    const SIDE: u32 = 60;
    let mut case = flat_walk();
    let mut random = Random::new(3, Stream::Preparation, 0, 0);
    let corner = case.scenario.start.position - DVec3::new(0.6, 0.6, 0.0);
    let mut vertex = |k: u32| {
        let [row, column] = [k / (SIDE + 1), k % (SIDE + 1)].map(|step| 0.02 * f64::from(step));
        corner + DVec3::new(row, column, random.uniform(-4e-3, 4e-3))
    };
    let cells = (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| row * (SIDE + 1) + column));
    let ground = Shape::Mesh {
        vertices: (0..(SIDE + 1) * (SIDE + 1)).map(&mut vertex).collect(),
        triangles: cells
            .flat_map(|a| [[a, a + SIDE + 1, a + SIDE + 2], [a, a + SIDE + 2, a + 1]])
            .collect(),
        source: None,
    };
    case.world.shapes[0].shape = ground;
    case.world.shapes[0].world_from_shape = Pose::IDENTITY;
    let mut planner = case.planner(1);
    let outcome = run(&mut planner, STEP);
    let named = planner.describe(&outcome);
    assert!(matches!(
        outcome,
        Outcome::StartInvalid(EndpointError::Unsupported {
            reason: NoSupport::AreaTooSmall | NoSupport::CentroidNearEdge,
            ..
        })
    ));
    let uneven = named.split_once("the ground under the sole is uneven by at least ").unwrap().1;
    let height: f64 = uneven.strip_suffix(" mm").unwrap().parse().unwrap();
    assert!((2.0..=8.0).contains(&height), "{named}");
}

#[test]
fn a_contact_of_an_unknown_limb_is_an_unknown_stance() {
    let case = flat_walk();
    let contact = |limb| Contact { limb, rotation: [0.0, 0.0, 0.0, 1.0], ..Contact::zeroed() };
    let standing = RestState::zeroed().after(
        SupportMode::Double as u32,
        &[contact(0), contact(7)],
        &Waypoint::zeroed(),
    );
    let preparation = preparation_for(&case.model, &case.scenario.planner);
    let mut planner = Planner::builder(&case.model, &case.world, &case.scenario, preparation)
        .start_in(&standing)
        .build()
        .unwrap();
    assert_eq!(run(&mut planner, STEP), Outcome::StartInvalid(EndpointError::UnknownStance));
}

#[test]
fn an_invalid_goal_names_its_error() {
    let applicable = INVALID_STANCES.into_iter().filter(|(what, ..)| {
        what.starts_with("the block") || what.contains("bar") || what.contains("wall")
    });
    for (what, change, expected) in applicable {
        let case = two_floors();
        let stance = case.scenario.goal;
        match outcome_of(&change(case, &stance)) {
            Outcome::GoalInvalid(fault) if expected(&fault) => {}
            other => panic!("{what}: {other:?}"),
        }
    }
    let mut floating = flat_walk();
    floating.scenario.goal.position.z = 0.4;
    let fault = EndpointError::Unsupported { limb: 0, reason: NoSupport::NothingBelow };
    assert_eq!(outcome_of(&floating), Outcome::GoalInvalid(fault));
}

#[test]
fn every_outcome_has_its_own_message() {
    let fault = EndpointError::FootCollides { limb: 1 };
    let outcomes = [
        Outcome::Found,
        Outcome::BudgetExhausted(Bound::Work),
        Outcome::ArenaFull(ArenaFull::Footholds),
        Outcome::Impossible(Obstruction::Blockage(Blockage {
            shape: 0,
            at: Default::default(),
            radius: 0.1,
            reach: 1.0,
        })),
        Outcome::StartInvalid(fault),
        Outcome::GoalInvalid(fault),
    ];
    for (index, outcome) in outcomes.iter().enumerate() {
        assert!(
            outcomes[..index]
                .iter()
                .all(|other| other.name() != outcome.name()
                    && other.describe() != outcome.describe())
        );
    }
    assert!(Outcome::StartInvalid(fault).describe().contains("right foot"));
}

fn refusal(case: &Case) -> PlannerError {
    case.try_planner(1).unwrap_err()
}

#[test]
fn robots_that_are_not_bipeds_are_refused() {
    let mut hopper = flat_walk();
    hopper.model.feet.pop();
    assert!(matches!(
        refusal(&hopper),
        PlannerError::Mechanism(MechanismError::FeetCount { feet: 1 })
    ));

    let mut tripod = flat_walk();
    tripod.model.feet.push(tripod.model.feet[0].clone());
    assert!(matches!(
        refusal(&tripod),
        PlannerError::Mechanism(MechanismError::FeetCount { feet: 3 })
    ));

    let mut stiff = flat_walk();
    let hinges: Vec<_> =
        (0..5).map(|_| hinge([0.0, 0.0, -0.1], [0.0, 1.0, 0.0], [-1.0, 1.0])).collect();
    stiff.model = chain_robot(&hinges, [0.0; 3]);
    stiff.model.feet.push(Foot { link: 0, ..stiff.model.feet[0].clone() });
    assert!(matches!(
        refusal(&stiff),
        PlannerError::Mechanism(MechanismError::Leg(LegError::JointCount { joints: 5, .. }))
    ));
}

#[test]
fn a_robot_of_too_many_links_is_refused() {
    let mut case = flat_walk();
    let bolt =
        Link { name: "bolt".into(), mass: 0.0, shapes: vec![], ..case.model.links[1].clone() };
    case.model.links.resize(LINKS_MAX + 1, bolt);
    assert!(matches!(
        refusal(&case),
        PlannerError::Mechanism(MechanismError::TooManyLinks { links }) if links == LINKS_MAX + 1
    ));
}

#[test]
fn a_clearance_that_is_not_a_number_is_refused() {
    let case = flat_walk().configured(|planner| planner.clearance = f64::NAN);
    assert!(matches!(refusal(&case), PlannerError::Collision(_)));
}

#[test]
fn a_support_area_out_of_range_is_refused() {
    let case = flat_walk().configured(|planner| planner.support_area_min = 0.0);
    assert!(matches!(
        refusal(&case),
        PlannerError::Surfaces(SurfacesError::Config { field: "support_area_min", .. })
    ));
}

#[test]
fn an_invalid_shape_is_refused_by_its_name() {
    let mut case = flat_walk();
    case.world.shapes[0].shape = Shape::Sphere { radius: -1.0 };
    let message = refusal(&case).to_string();
    assert!(message.contains("floor"), "{message}");
}

#[test]
fn a_planner_is_made_on_a_small_stack() {
    let made = || drop(Case::smooth("flat_walk").planner(1));
    let thread = std::thread::Builder::new().stack_size(512 << 10).spawn(made).unwrap();
    thread.join().unwrap();
}
