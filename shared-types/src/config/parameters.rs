//! The settable parameters: the fields of [`PlannerConfig`], [`CheckerConfig`] and
//! [`ExecutionConfig`] with unit, effect, range and source. `docs/PARAMETERS.md` and
//! `surefoot config show` are made from this table, and the loader of scenarios enforces its
//! ranges.
//!
//! [`PlannerConfig`]: crate::config::planner::PlannerConfig
//! [`CheckerConfig`]: crate::config::planner::CheckerConfig
//! [`ExecutionConfig`]: crate::config::execution::ExecutionConfig

use std::ops::Bound::{self, Excluded, Included};

use crate::base::text_file::NUMBER_MAX;
use crate::config::execution::MotionKind;
use crate::config::parameter::{Parameter, Range, Value};
use crate::config::planner::{CONTACT_GAP_MAX, CONTACT_TILT_MAX, FOOT_DRIFT_MAX, FOOT_TURN_MAX};

/// Smallest `waypoint_joint_step` and `collision_step`, rad or m. Smaller steps add work without
/// use.
const STEP_MIN: f64 = 1e-3;
/// Positive and finite.
const POSITIVE: Range = reals(Excluded(0.0), Included(NUMBER_MAX));

const fn counts(least: u64, most: u64) -> Range {
    Range::Counts { least, most }
}

const fn reals(low: Bound<f64>, high: Bound<f64>) -> Range {
    Range::Reals { low, high }
}

/// All parameters, in the order of the fields. Relations between two parameters narrow the ranges
/// further.
pub static PARAMETERS: [Parameter; 30] = [
    Parameter {
        name: "planner.work_max",
        unit: "work units",
        effect: "Most work of the whole search; a unit takes about 10 µs (`surefoot bench \
            steps`).",
        range: counts(1, u64::MAX),
        relation: "",
        source: "chosen by measurement; no record",
        value: |planner, _, _| Value::Count(planner.work_max),
    },
    Parameter {
        name: "planner.tree_vertices_max",
        unit: "",
        effect: "Most vertices in each tree of stage P; memory is reserved for all.",
        range: counts(2, 1 << 18),
        relation: "",
        source: "chosen by measurement; no record. Range: the arena fits into a few GiB",
        value: |planner, _, _| Value::Count(planner.tree_vertices_max.into()),
    },
    Parameter {
        name: "planner.footholds_max",
        unit: "",
        effect: "Most footholds of stage M; memory is reserved for all.",
        range: counts(2, 1 << 20),
        relation: "",
        source: "chosen by measurement; no record. Range: the arena fits into a few GiB",
        value: |planner, _, _| Value::Count(planner.footholds_max.into()),
    },
    Parameter {
        name: "planner.transitions_max",
        unit: "",
        effect: "Most transitions of stage M; memory is reserved for all.",
        range: counts(2, 1 << 24),
        relation: "",
        source: "chosen by measurement; no record. Range: the arena fits into a few GiB",
        value: |planner, _, _| Value::Count(planner.transitions_max.into()),
    },
    Parameter {
        name: "planner.configurations_max",
        unit: "",
        effect: "Most transition configurations; the roadmap holds up to four times as many \
            motions between them.",
        range: counts(2, 1 << 20),
        relation: "",
        source: "chosen by measurement; no record. Range: the arena fits into a few GiB",
        value: |planner, _, _| Value::Count(planner.configurations_max.into()),
    },
    Parameter {
        name: "planner.waypoints_max",
        unit: "",
        effect: "Most waypoints of a plan; a waypoint shared by two chunks counts once.",
        range: counts(2, 1 << 21),
        relation: "",
        source: "chosen by measurement; no record. Range: the arena fits into a few GiB",
        value: |planner, _, _| Value::Count(planner.waypoints_max.into()),
    },
    Parameter {
        name: "planner.step_removal_rounds_max",
        unit: "",
        effect: "Most sequences tried to remove steps from a complete route segment; 0 removes no \
            steps.",
        range: counts(0, u32::MAX as u64),
        relation: "",
        source: "method: Grey 4.4.6; value: chosen by measurement; no record",
        value: |planner, _, _| Value::Count(planner.step_removal_rounds_max.into()),
    },
    Parameter {
        name: "planner.shortcut_work_share",
        unit: "",
        effect: "Work of path shortcutting as a share of the work before it; 0 disables \
            shortcutting.",
        range: reals(Included(0.0), Included(NUMBER_MAX)),
        relation: "",
        source: "method: Grey 4.4.6; value: chosen by measurement; no record",
        value: |planner, _, _| Value::Real(planner.shortcut_work_share),
    },
    Parameter {
        name: "planner.clearance",
        unit: "m",
        effect: "Smallest distance between the robot and the world, and between links, at every \
            sampled configuration.",
        range: reals(Excluded(0.5 * STEP_MIN), Included(NUMBER_MAX)),
        relation: "above half of planner.collision_step",
        source: "decision 0003: at most 5 mm from a sample, so 6 mm there leave 1 mm between two \
            samples",
        value: |planner, _, _| Value::Real(planner.clearance),
    },
    Parameter {
        name: "planner.com_margin",
        unit: "m",
        effect: "Smallest distance of the centre of mass from the edge of the support polygon; \
            for a small polygon at most 60 % of its depth.",
        range: POSITIVE,
        relation: "above checker.com_margin",
        source: "decision 0003: a robot with compliant joints sways by about 1 cm",
        value: |planner, _, _| Value::Real(planner.com_margin),
    },
    Parameter {
        name: "planner.effort_share",
        unit: "",
        effect: "Largest share of a joint's effort limit in use.",
        range: reals(Excluded(0.0), Excluded(1.0)),
        relation: "below checker.effort_share",
        source: "decision 0003: a fifth is reserved for effects outside the quasi-static model",
        value: |planner, _, _| Value::Real(planner.effort_share),
    },
    Parameter {
        name: "planner.joint_margin",
        unit: "rad or m",
        effect: "Smallest distance of a joint from its position limits.",
        range: reals(Included(0.0), Included(0.5)),
        relation: "",
        source: "decision 0003 lists the value without a reason; chosen by measurement",
        value: |planner, _, _| Value::Real(planner.joint_margin),
    },
    Parameter {
        name: "planner.waypoint_joint_step",
        unit: "rad",
        effect: "Largest joint motion between two waypoints.",
        range: reals(Included(STEP_MIN), Excluded(NUMBER_MAX)),
        relation: "below checker.joint_step_max",
        source: "decision 0003 lists the value without a reason; chosen by measurement",
        value: |planner, _, _| Value::Real(planner.waypoint_joint_step),
    },
    Parameter {
        name: "planner.collision_step",
        unit: "m",
        effect: "Largest motion of any point of the robot between two collision checks.",
        range: reals(Included(STEP_MIN), Included(NUMBER_MAX)),
        relation: "below twice planner.clearance",
        source: "decision 0003, with `planner.clearance`",
        value: |planner, _, _| Value::Real(planner.collision_step),
    },
    Parameter {
        name: "planner.support_area_min",
        unit: "m2",
        effect: "Smallest support area of a foot placement; for a small sole at most 26 % of its \
            area, but at least 1.2 times `checker.support_area_min`.",
        range: reals(Included(1e-6), Included(NUMBER_MAX)),
        relation: "above checker.support_area_min",
        source: "a lower bound: Grey 4.1.2; value: decision 0003, a quarter of the reference \
            robot's sole",
        value: |planner, _, _| Value::Real(planner.support_area_min),
    },
    Parameter {
        name: "planner.route_vertex_spacing",
        unit: "m",
        effect: "Distance between the guide-route vertices at which footholds are sampled; at \
            most 42 % of the reach of a leg.",
        range: reals(Included(0.02), Included(NUMBER_MAX)),
        relation: "",
        source: "method: Grey 4.4.4; value: chosen by measurement; no record",
        value: |planner, _, _| Value::Real(planner.route_vertex_spacing),
    },
    Parameter {
        name: "planner.live_routes",
        unit: "",
        effect: "Guide routes that are alive at once: stage M works on them in turn, while stage \
            P grows further ones; with 1 stage P waits for stage M. Memory is reserved for each.",
        range: counts(1, 8),
        relation: "",
        source: "method: Grey 3.2, figure 3.6; value: 1 is the fastest where the first route is \
            no dead end",
        value: |planner, _, _| Value::Count(planner.live_routes.into()),
    },
    Parameter {
        name: "checker.foot_position_max",
        unit: "m",
        effect: "Largest distance of a stance sole from its declared position.",
        range: reals(Excluded(FOOT_DRIFT_MAX), Included(NUMBER_MAX)),
        relation: "above the tolerance of the planner",
        source: "decision 0003: twice the drift that the planner allows",
        value: |_, checker, _| Value::Real(checker.foot_position_max),
    },
    Parameter {
        name: "checker.foot_rotation_max",
        unit: "rad",
        effect: "Largest rotation of a stance sole from its declared pose.",
        range: reals(Excluded(FOOT_TURN_MAX), Included(NUMBER_MAX)),
        relation: "above the tolerance of the planner",
        source: "decision 0003: about twice the rotation that the planner allows",
        value: |_, checker, _| Value::Real(checker.foot_rotation_max),
    },
    Parameter {
        name: "checker.contact_gap_max",
        unit: "m",
        effect: "Largest distance between a supported point of a sole and the surface; also the \
            largest penetration of a stance foot.",
        range: reals(Excluded(CONTACT_GAP_MAX), Included(NUMBER_MAX)),
        relation: "above the tolerance of the planner",
        source: "docs/CHECKER.md lists the value without a reason",
        value: |_, checker, _| Value::Real(checker.contact_gap_max),
    },
    Parameter {
        name: "checker.contact_tilt_max",
        unit: "rad",
        effect: "Largest angle between the normals of a supporting surface and the sole.",
        range: reals(Excluded(CONTACT_TILT_MAX), Included(NUMBER_MAX)),
        relation: "above the tolerance of the planner",
        source: "docs/CHECKER.md lists the value without a reason",
        value: |_, checker, _| Value::Real(checker.contact_tilt_max),
    },
    Parameter {
        name: "checker.support_area_min",
        unit: "m2",
        effect: "Smallest support area of a stance sole.",
        range: reals(Included(0.0), Excluded(NUMBER_MAX)),
        relation: "below planner.support_area_min",
        source: "decision 0003 lists the value without a reason; chosen by measurement",
        value: |_, checker, _| Value::Real(checker.support_area_min),
    },
    Parameter {
        name: "checker.penetration_max",
        unit: "m",
        effect: "Largest overlap of two links, and of a foot and the world, that is not yet a collision.",
        range: reals(Included(0.0), Included(NUMBER_MAX)),
        relation: "",
        source: "decision 0003, with `planner.clearance`, lists the value without a reason",
        value: |_, checker, _| Value::Real(checker.penetration_max),
    },
    Parameter {
        name: "checker.com_margin",
        unit: "m",
        effect: "Smallest distance of the centre of mass from the edge of the equilibrium region.",
        range: reals(Included(0.0), Excluded(NUMBER_MAX)),
        relation: "below planner.com_margin",
        source: "ours: half of the sway of a robot with compliant joints",
        value: |_, checker, _| Value::Real(checker.com_margin),
    },
    Parameter {
        name: "checker.effort_share",
        unit: "",
        effect: "Largest share of a joint's effort limit in use.",
        range: reals(Excluded(0.0), Included(1.0)),
        relation: "above planner.effort_share",
        source: "ours: a twentieth is reserved for errors of the robot's masses",
        value: |_, checker, _| Value::Real(checker.effort_share),
    },
    Parameter {
        name: "checker.joint_step_max",
        unit: "rad",
        effect: "Largest joint motion between two waypoints.",
        range: reals(Excluded(STEP_MIN), Included(NUMBER_MAX)),
        relation: "above planner.waypoint_joint_step",
        source: "decision 0003 lists the value without a reason; chosen by measurement",
        value: |_, checker, _| Value::Real(checker.joint_step_max),
    },
    Parameter {
        name: "checker.root_step_max",
        unit: "m",
        effect: "Largest root motion between two waypoints.",
        range: POSITIVE,
        relation: "",
        source: "docs/CHECKER.md lists the value without a reason",
        value: |_, checker, _| Value::Real(checker.root_step_max),
    },
    Parameter {
        name: "execution.motion",
        unit: "",
        effect: "How the plan moves: `smooth` along splines, as fast as the limits allow; \
            `quasi_static` in straight lines at slow speeds, with a rest at the end of every \
            chunk.",
        range: Range::Names(&MotionKind::NAMES),
        relation: "",
        source: "decisions 0020 and 0021",
        value: |_, _, execution| Value::Name(execution.motion.name()),
    },
    Parameter {
        name: "execution.share",
        unit: "",
        effect: "Largest share of the limits of joint speed and effort that a smooth motion uses.",
        range: reals(Excluded(0.0), Included(1.0)),
        relation: "",
        source: "replays in MuJoCo: at 0.8 a PD controller with feed-forward keeps the robot \
            standing",
        value: |_, _, execution| Value::Real(execution.share),
    },
    Parameter {
        name: "execution.ramp_seconds_min",
        unit: "s",
        effect: "Shortest time in which a robot brakes to a rest, or goes on from one.",
        range: reals(Included(0.1), Included(2.0)),
        relation: "",
        source: "replays in MuJoCo of walks with ten stops each: at 0.2 s a robot on stiff joints \
            sways and may fall, at 0.5 s it stands",
        value: |_, _, execution| Value::Real(execution.ramp_seconds_min),
    },
];
