//! Transition priors from inverse kinematics: they raise the cost of a transition and never exclude
//! it [Grey 4.4.2].

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{Case, hubo, preparation_for};
use glam::{DVec2, DVec3};
use surefoot_planner::collision::model::CollisionModel;
use surefoot_planner::constraints::constraints::Constraints;
use surefoot_planner::constraints::foothold::{Foothold, single_mode};
use surefoot_planner::constraints::rejection::Rejection;
use surefoot_planner::foot_placement::{FootPlacementConfig, Scratch, Surfaces};
use surefoot_planner::motion::mode_graph::ModeGraph;
use surefoot_planner::motion::transition::TransitionPrior;
use surefoot_planner::motion::transition_prior::transition_prior;
use surefoot_planner::motion::tuning::ATTEMPTS_MAX;
use surefoot_planner::pipeline::{Endpoint, FootholdSampler, PERTURBATIONS_MAX, stand_on};
use surefoot_planner::primitives::FAR_REACHING_POSTURES;
use surefoot_planner::primitives::transition_configuration::{
    first_valid_posture, is_reached, sample,
};
use surefoot_planner::primitives::transition_pair::TransitionPair;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::Pose;

struct Stand {
    constraints: Constraints,
    surfaces: Surfaces,
    scratch: Scratch,
    end: Endpoint,
}

fn stand() -> Stand {
    let case = Case::shipped("flat_walk");
    let config = case.scenario.planner.clone();
    let robot = Mechanism::new(&case.model, &config).unwrap();
    let collision = CollisionModel::new(&case.model, &case.world, config.clearance).unwrap();
    let constraints = Constraints::new(robot, collision, config);
    let placement = FootPlacementConfig::default();
    let mut scratch = Scratch::new(&placement);
    let surfaces = Surfaces::new(&case.world, placement).unwrap();
    let end = stand_on(&constraints, &surfaces, &mut scratch, &case.scenario.start).unwrap();
    Stand { constraints, surfaces, scratch, end }
}

impl Stand {
    /// The right foothold, displaced by a vector, m.
    fn right(&self, by: DVec3) -> Foothold {
        let foothold = &self.end.footholds[1];
        let pose = foothold.world_from_sole;
        Foothold::new(
            1,
            Pose::from_parts(pose.translation + by, pose.rotation),
            foothold.support.clone(),
        )
    }

    fn is_reached(&self, other: &Foothold) -> bool {
        let stance = &self.end.footholds[0];
        is_reached(&self.constraints, &single_mode(stance), TransitionPair { stance, other })
    }

    /// The prior of the transition from the left stance foothold.
    fn prior(&self, other: &Foothold) -> TransitionPrior {
        self.prior_where(other, false)
    }

    /// The same, where partial support may be allowed.
    fn prior_where(&self, other: &Foothold, may_be_partial: bool) -> TransitionPrior {
        let mut graph = ModeGraph::new(2, 2, 1, 1.0);
        let [left, right] = [&self.end.footholds[0], other]
            .map(|foothold| graph.add_foothold(foothold.clone()).unwrap());
        graph.connect(left, right).unwrap();
        transition_prior(
            &self.constraints,
            graph.find(left, right).unwrap(),
            &graph,
            may_be_partial,
        )
    }
}

#[test]
fn a_transition_that_no_posture_reaches_costs_more_and_stays_possible() {
    let stand = stand();
    let (near, far) =
        (stand.right(DVec3::new(0.25, 0.0, 0.0)), stand.right(DVec3::new(0.85, 0.0, 0.0)));
    assert!(stand.is_reached(&near) && !stand.is_reached(&far));
    let (near, far) = (stand.prior(&near), stand.prior(&far));
    assert_eq!(near, TransitionPrior::default());
    assert!(
        far.attempts == ATTEMPTS_MAX && far.extra_attempts > ATTEMPTS_MAX,
        "its cost counts more attempts than sampling skips: {far:?}"
    );
}

#[test]
fn crossed_feet_are_less_likely_than_the_same_step_uncrossed() {
    let stand = stand();
    let width = stand.end.footholds[0].distance(&stand.end.footholds[1]);
    let [uncrossed, crossed] =
        [0.97, 1.03].map(|share| stand.prior(&stand.right(DVec3::new(0.3, share * width, 0.0))));
    assert_eq!(uncrossed.attempts, crossed.attempts, "the postures tolerate a few millimetres");
    assert!(crossed.extra_attempts > uncrossed.extra_attempts);
}

#[test]
fn partial_support_costs_more_unless_it_is_allowed() {
    let stand = stand();
    let whole = stand.right(DVec3::new(0.2, 0.0, 0.0));
    let half = Foothold::new(
        1,
        whole.world_from_sole,
        whole.support.iter().map(|corner| DVec2::new(corner.x.max(0.02), corner.y)).collect(),
    );
    assert_eq!(stand.prior(&whole).extra_attempts, 0);
    assert!(stand.prior(&half).extra_attempts > 0);
    assert_eq!(stand.prior_where(&half, true).extra_attempts, 0);
}

#[test]
fn a_step_that_is_too_long_is_perturbed_until_it_is_reached() {
    let mut stand = stand();
    let (left, far) = (stand.end.footholds[0].clone(), stand.right(DVec3::new(0.8, 0.0, 0.0)));
    assert!(!stand.is_reached(&far));
    let mut graph = ModeGraph::new(4, 2, 1, 1.0);
    let [a, b] = [left, far].map(|foothold| graph.add_foothold(foothold).unwrap());
    graph.connect(a, b).unwrap();
    let preparation = preparation_for(&hubo(), &stand.constraints.config);
    let steps = preparation.step_limits();
    let sampler = FootholdSampler {
        constraints: &stand.constraints,
        surfaces: &stand.surfaces,
        steps,
        seed: 1,
    };
    let mut perturb =
        |tried| sampler.perturbation(0, (tried as u64, 0), &graph, &mut stand.scratch);
    let [stance, other] = &(0..PERTURBATIONS_MAX).find_map(&mut perturb).unwrap();
    assert!(is_reached(&stand.constraints, &single_mode(stance), TransitionPair { stance, other }));
    assert!(
        stance.distance(&graph.footholds()[0]) < 0.3 && other.distance(&graph.footholds()[1]) < 0.3,
        "the perturbed footholds are near the original ones"
    );
}

#[test]
fn crossed_legs_cost_as_much_as_unreachable_footholds() {
    let stand = stand();
    let (stance, width) = (&stand.end.footholds[0], 0.35);
    let other = stand.right(DVec3::new(0.3, width, 0.0));
    let (mode, pair) = (single_mode(stance), TransitionPair { stance, other: &other });
    assert!(is_reached(&stand.constraints, &mode, pair), "each leg by itself reaches its foothold");
    assert_eq!(
        first_valid_posture(&stand.constraints, &mode, pair),
        None,
        "the right foot is left of the left one"
    );
    let side_by_side = TransitionPair { stance, other: &stand.end.footholds[1] };
    assert_eq!(first_valid_posture(&stand.constraints, &mode, side_by_side), Some(0));
    let holds =
        |attempt: u64| sample(&stand.constraints, &mode, side_by_side, (1, 0), attempt).is_ok();
    assert!(
        FAR_REACHING_POSTURES.into_iter().all(holds),
        "the far-reaching postures are valid, too"
    );
}

#[test]
fn unreached_footholds_fail_in_the_far_reaching_postures() {
    let stand = stand();
    let (stance, mut unreached) = (&stand.end.footholds[0], 0);
    let mode = single_mode(stance);
    for index in 0..400 {
        let by = DVec3::new(
            -0.9 + 0.1 * f64::from(index % 19),
            -0.4 + 0.1 * f64::from(index % 7),
            -0.2 + 0.1 * f64::from(index % 5),
        );
        let other = stand.right(by);
        if stand.is_reached(&other) {
            continue;
        }
        unreached += 1;
        let pair = TransitionPair { stance, other: &other };
        for attempt in FAR_REACHING_POSTURES {
            let found = sample(&stand.constraints, &mode, pair, (1, 0), attempt).map(|_| ());
            assert!(
                matches!(found, Err(Rejection::Unreachable | Rejection::Balance)),
                "{by}: {found:?}"
            );
        }
    }
    assert!((50..350).contains(&unreached), "{unreached} of 400 pairs are not reached");
}
