//! Each constraint rejects configurations and motions that violate it, and no others.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::Case;
use glam::DVec2;
use surefoot_planner::collision::model::{CollisionModel, FootPhase};
use surefoot_planner::constraints::constraints::Constraints;
use surefoot_planner::constraints::foothold::{double_mode, single_mode};
use surefoot_planner::constraints::mode::Mode;
use surefoot_planner::constraints::mode_state::ModeState;
use surefoot_planner::constraints::rejection::Rejection;
use surefoot_planner::foot_placement::{FootPlacementConfig, Scratch, Surfaces};
use surefoot_planner::geometry::convex_region::ConvexRegion;
use surefoot_planner::motion::cbirrt::SingleModeProblem;
use surefoot_planner::motion::single_mode::solve;
use surefoot_planner::motion::workspace::Workspace;
use surefoot_planner::pipeline::Endpoint;
use surefoot_planner::pipeline::stand_on;
use surefoot_planner::robot::configuration::{Configuration, midway};
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_planner::robot::posture_ik::{Posture, solve_posture};
use surefoot_shared_types::base::spatial::rotation_about;

const STANCE: [FootPhase; 2] = [FootPhase::Stance; 2];

/// A robot at its start stance.
struct Stand {
    case: Case,
    constraints: Constraints,
    end: Endpoint,
    mode: Mode,
}

fn constraints_of(case: &Case) -> Constraints {
    let config = case.scenario.planner.clone();
    let robot = Mechanism::new(&case.model, &config).unwrap();
    let collision = CollisionModel::new(&case.model, &case.world, config.clearance).unwrap();
    Constraints::new(robot, collision, config)
}

fn stand() -> Stand {
    let case = Case::shipped("flat_walk");
    let constraints = constraints_of(&case);
    let placement = FootPlacementConfig::default();
    let mut scratch = Scratch::new(&placement);
    let surfaces = Surfaces::new(&case.world, placement).unwrap();
    let end = stand_on(&constraints, &surfaces, &mut scratch, &case.scenario.start).unwrap();
    let mode = double_mode(&end.footholds[0], &end.footholds[1]);
    Stand { case, constraints, end, mode }
}

impl Stand {
    fn configuration(&self) -> Configuration {
        self.end.state.configuration
    }

    /// The standing configuration with some joints changed, rad.
    fn moved(&self, joints: &[(&str, f64)]) -> Configuration {
        let mut configuration = self.configuration();
        for (name, position) in joints {
            let index =
                self.case.model.joints.iter().position(|joint| joint.name == *name).unwrap();
            configuration.q[index] = *position;
        }
        configuration
    }

    fn kinematic_state(&self, configuration: &Configuration) -> KinematicState {
        KinematicState::new(&self.constraints.robot, configuration)
    }

    fn check(&self, configuration: &Configuration) -> Result<(), Rejection> {
        self.constraints.check(&self.mode, &self.kinematic_state(configuration), STANCE)
    }

    fn check_between(&self, a: &Configuration, b: &Configuration) -> Result<(), Rejection> {
        let kinematic_states = [a, b].map(|configuration| self.kinematic_state(configuration));
        let bound =
            self.constraints.collision.motion_bound(&kinematic_states[0], &kinematic_states[1]);
        self.constraints
            .check_between(&self.mode, [a, b], bound, STANCE, &mut KinematicState::default())
            .map(|_| ())
    }

    fn check_on_curve(&self, configuration: &Configuration) -> Result<(), Rejection> {
        self.constraints.check_on_curve(&self.mode, configuration, &mut KinematicState::default())
    }

    /// A crouch on the same soles.
    fn crouched(&self) -> Configuration {
        let posture = Posture {
            world_from_root: rotation_about(glam::DVec3::Z, self.case.scenario.start.yaw),
            leg_extension: 0.8 * self.constraints.robot.standing_leg_extension,
            com: self.kinematic_state(&self.configuration()).com.truncate(),
        };
        let soles = self.end.state.world_from_soles;
        solve_posture(&self.constraints.robot, &soles, &posture, self.configuration().q).unwrap().0
    }

    /// A query for the motion from the start stance to the crouch.
    fn crouch_problem(&self) -> SingleModeProblem {
        let crouched = ModeState {
            configuration: self.crouched(),
            world_from_soles: self.end.state.world_from_soles,
        };
        SingleModeProblem {
            mode: self.mode.clone(),
            from: self.end.state,
            to: crouched,
            random: (1, 1),
            failures: 0,
        }
    }

    /// Adds a small box at the left hand of a configuration.
    fn with_box_at_hand(mut self, configuration: &Configuration) -> Self {
        let hand = self.case.model.links.iter().position(|link| link.name == "left_hand").unwrap();
        let center =
            self.kinematic_state(configuration).world_from_link(&self.constraints.robot, hand)
                * self.case.model.links[hand].com;
        self.case = self.case.with_box(center.to_array(), [0.02; 3]);
        self.constraints = constraints_of(&self.case);
        self
    }
}

const ARM_FORWARD: [(&str, f64); 1] = [("left_shoulder_pitch", -0.8)];
const ARM_BACK: [(&str, f64); 1] = [("left_shoulder_pitch", 0.4)];

fn feet_too_far_apart() -> Result<(), Rejection> {
    let stand = stand();
    let mut soles = stand.end.state.world_from_soles;
    soles[0].translation.y += 1.5;
    let posture = Posture {
        world_from_root: soles[1].rotation,
        leg_extension: 0.9,
        com: soles[1].translation.truncate(),
    };
    let q = stand.configuration().q;
    solve_posture(&stand.constraints.robot, &soles, &posture, q)?;
    Ok(())
}

fn centre_of_mass_beside_the_only_foot() -> Result<(), Rejection> {
    let mut stand = stand();
    stand.mode = single_mode(&stand.end.footholds[0]);
    stand.check(&stand.configuration())
}

fn centre_of_mass_leaves_between_waypoints() -> Result<(), Rejection> {
    let mut stand = stand();
    let (a, b) = (stand.moved(&ARM_FORWARD), stand.moved(&ARM_BACK));
    let away = stand.kinematic_state(&midway(&a, &b, 0.5)).com.truncate() + DVec2::new(0.2, 0.0);
    let corners = [(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)];
    stand.mode.region = ConvexRegion::hull(corners.map(|corner| away + DVec2::from(corner)));
    stand.check_between(&a, &b)
}

fn weak_motors() -> Result<(), Rejection> {
    let mut stand = stand();
    stand.case = stand.case.configured(|planner| planner.effort_share = 1e-2);
    stand.constraints = constraints_of(&stand.case);
    stand.check(&stand.configuration())
}

fn hand_in_a_box() -> Result<(), Rejection> {
    let stand = stand();
    let configuration = stand.configuration();
    let stand = stand.with_box_at_hand(&configuration);
    stand.check(&configuration)
}

fn hand_through_a_box() -> Result<(), Rejection> {
    let stand = stand();
    let (a, b) = (stand.moved(&ARM_FORWARD), stand.moved(&ARM_BACK));
    let stand = stand.with_box_at_hand(&midway(&a, &b, 0.5));
    assert_eq!([&a, &b].map(|end| stand.check(end)), [Ok(()); 2], "both ends are free");
    stand.check_between(&a, &b)
}

fn legs_crossed() -> Result<(), Rejection> {
    let stand = stand();
    stand.check(&stand.moved(&[("left_hip_roll", -0.3), ("right_hip_roll", 0.3)]))
}

fn crouch_in_one_step() -> Result<(), Rejection> {
    let stand = stand();
    stand.check_between(&stand.configuration(), &stand.crouched())
}

fn more_waypoints_than_the_workspace_holds() -> Result<(), Rejection> {
    let stand = stand();
    solve(&stand.constraints, &stand.crouch_problem(), &mut Workspace::new(2, 8)).map(drop)
}

type Violate = fn() -> Result<(), Rejection>;

/// Violations and the rejection of each.
const CASES: [(Violate, Rejection); 9] = [
    (feet_too_far_apart, Rejection::Unreachable),
    (centre_of_mass_beside_the_only_foot, Rejection::Balance),
    (centre_of_mass_leaves_between_waypoints, Rejection::Balance),
    (weak_motors, Rejection::Torque),
    (hand_in_a_box, Rejection::Collision),
    (hand_through_a_box, Rejection::Collision),
    (legs_crossed, Rejection::SelfCollision),
    (crouch_in_one_step, Rejection::FootDrift),
    (more_waypoints_than_the_workspace_holds, Rejection::Discontinuous),
];

#[test]
fn each_violation_has_its_own_rejection() {
    for (index, (violate, rejection)) in CASES.iter().enumerate() {
        assert_eq!(violate(), Err(*rejection), "case {index}");
    }
}

#[test]
fn every_rejection_is_tested() {
    let tested = |kind: &usize| CASES.iter().any(|(_, rejection)| *rejection as usize == *kind);
    let untested: Vec<&str> = (0..Rejection::COUNT)
        .filter(|kind| !tested(kind))
        .map(|kind| Rejection::NAMES[kind])
        .collect();
    assert!(untested.is_empty(), "{untested:?}");
}

#[test]
fn valid_configurations_and_motions_are_not_rejected() {
    let stand = stand();
    assert_eq!(stand.check(&stand.configuration()), Ok(()));
    assert_eq!(stand.check(&stand.crouched()), Ok(()));
    assert_eq!(stand.check_between(&stand.moved(&ARM_FORWARD), &stand.moved(&ARM_BACK)), Ok(()));
    assert!(
        solve(&stand.constraints, &stand.crouch_problem(), &mut Workspace::new(1024, 64)).is_ok()
    );
}

#[test]
fn a_curve_uses_half_of_the_joints_margin_and_keeps_the_soles() {
    let stand = stand();
    let elbow = stand.case.model.joints.iter().find(|joint| joint.name == "left_elbow").unwrap();
    let margin = stand.constraints.config.joint_margin;
    assert_eq!(stand.check_on_curve(&stand.configuration()), Ok(()));
    let at = |share: f64| stand.moved(&[("left_elbow", elbow.lower + share * margin)]);
    assert_eq!(stand.check_on_curve(&at(0.6)), Ok(()));
    assert_eq!(stand.check_on_curve(&at(0.4)), Err(Rejection::Unreachable));
    let mut drifted = stand.configuration();
    drifted.world_from_root.translation.x += 0.9e-3;
    assert_eq!(stand.check_on_curve(&drifted), Ok(()));
    drifted.world_from_root.translation.x += 0.2e-3;
    assert_eq!(stand.check_on_curve(&drifted), Err(Rejection::FootDrift));
}
