//! The damages, each with the reason for which the plan must be refused.

use glam::DVec3;
use surefoot_shared_types::message::Check;
use surefoot_shared_types::plan_format::blocks::{EndBlock, ShapeBlock};

use super::Reason;
use super::Reason::{File, Goal, Start, Violates};
use super::damage::{DamagedPlan, cube_obj, push, turn};

type Damage = (&'static str, Reason, fn(&mut DamagedPlan));

pub fn all() -> Vec<Damage> {
    [files(), motions(), contacts(), forces(), collisions(), ends()].concat()
}

fn files() -> Vec<Damage> {
    vec![
        ("another schema", File("schema"), |damaged| damaged.plan.schema = "biped-plan/2".into()),
        ("time runs backwards", File("waypoint"), |damaged| damaged.plan.waypoints[100].t = 0.0),
        ("a position is not a number", File("plan.json"), |damaged| {
            damaged.plan.waypoints[100].q[0] = f64::NAN
        }),
        ("a position is huge", File("waypoint"), |damaged| damaged.plan.waypoints[100].q[0] = 1e9),
        ("a rotation is not one", File("waypoint"), |damaged| {
            damaged.plan.waypoints[100].root_quat_xyzw = [0.0, 0.0, 0.0, 1.1]
        }),
        ("the phases leave a gap", File("phase"), |damaged| drop(damaged.plan.phases.remove(7))),
        ("a phase ends past the plan", File("phase"), |damaged| {
            damaged.plan.phases.last_mut().unwrap().last += 1
        }),
        ("an unknown joint", File("joint_names"), |damaged| {
            damaged.plan.joint_names[3] = "tail".into()
        }),
        ("a joint is missing", File("waypoint"), |damaged| {
            damaged.plan.waypoints.iter_mut().for_each(|waypoint| waypoint.q.truncate(5))
        }),
        ("an unknown mode", File("phase"), |damaged| damaged.plan.phases[4].mode = "hands".into()),
        ("the contacts of another mode", File("phase"), |damaged| {
            let phase = damaged.middle_phase("double");
            damaged.plan.phases[phase].contacts.truncate(1);
        }),
        ("soles larger than the feet", File("sole"), |damaged| {
            damaged
                .sole_polygons()
                .flatten()
                .for_each(|corner| *corner = corner.map(|value| 1.3 * value));
        }),
        ("friction below nothing", File("mu"), |damaged| damaged.plan.scene.mu = -0.1),
    ]
}

fn motions() -> Vec<Damage> {
    vec![
        ("an arm jumps", Violates(Check::Spacing, "left_elbow"), |damaged| {
            damaged.bend("left_elbow", -0.3, [damaged.mid_step()])
        }),
        ("the root jumps", Violates(Check::Spacing, "root moves"), |damaged| {
            damaged.push_root(0.2 * DVec3::X, [damaged.mid_step()])
        }),
        ("the root spins", Violates(Check::Spacing, "root turns"), |damaged| {
            let at = damaged.mid_step();
            let [x, y, z, w] = damaged.plan.waypoints[at].root_quat_xyzw;
            damaged.plan.waypoints[at].root_quat_xyzw = [w, z, -y, -x];
        }),
        ("waypoints are left out", Violates(Check::Spacing, "to the next waypoint"), |damaged| {
            damaged.thin(damaged.middle_phase("right"), 30)
        }),
        ("the walk is hurried", Violates(Check::Acceleration, "has to accelerate"), |damaged| {
            damaged.plan.waypoints.iter_mut().for_each(|waypoint| waypoint.t *= 0.7);
        }),
        ("the walk is rushed", Violates(Check::ZeroMoment, "too fast"), |damaged| {
            damaged.plan.waypoints.iter_mut().for_each(|waypoint| waypoint.t *= 0.2);
        }),
        ("a step stops at once", Violates(Check::Acceleration, "has to accelerate"), |damaged| {
            let last = *damaged.waypoints_of(damaged.middle_phase("right")).end();
            let late = 0.9 * (damaged.plan.waypoints[last].t - damaged.plan.waypoints[last - 1].t);
            damaged.plan.waypoints[last..].iter_mut().for_each(|waypoint| waypoint.t -= late);
        }),
        ("an arm twitches", Violates(Check::Acceleration, "left_elbow"), |damaged| {
            damaged.bend("left_elbow", -0.15, [damaged.mid_step()])
        }),
        ("an elbow bends too far", Violates(Check::Limits, "left_elbow"), |damaged| {
            damaged.bend("left_elbow", -3.0, damaged.everywhere())
        }),
        ("a wrist turns too far", Violates(Check::Limits, "right_wrist_yaw"), |damaged| {
            damaged.bend("right_wrist_yaw", 3.5, damaged.everywhere());
        }),
        ("a knee bends backwards", Violates(Check::Limits, "left_knee"), |damaged| {
            damaged.bend("left_knee", -3.0, damaged.everywhere())
        }),
    ]
}

fn contacts() -> Vec<Damage> {
    vec![
        ("a stance foot slides 5 mm", Violates(Check::Contact, "right sole is"), |damaged| {
            let waypoints = damaged.waypoints_of(damaged.middle_phase("right"));
            let count = (waypoints.end() - waypoints.start()) as f64;
            for (index, waypoint) in waypoints.enumerate() {
                damaged.push_root(5e-3 * index as f64 / count * DVec3::X, [waypoint]);
            }
        }),
        ("a foot is declared 5 mm aside", Violates(Check::Contact, "declared place"), |damaged| {
            damaged.redeclare(|pose| push(&mut pose.xyz, 5e-3 * DVec3::Y));
        }),
        (
            "a foot is declared a degree turned",
            Violates(Check::Contact, "declared pose"),
            |damaged| {
                damaged.redeclare(|pose| turn(pose, DVec3::Z, 1.0));
            },
        ),
        ("an ankle tips the sole", Violates(Check::Contact, "right sole is turned"), |damaged| {
            damaged.bend(
                "right_ankle_roll",
                0.02,
                damaged.waypoints_of(damaged.middle_phase("right")),
            );
        }),
        (
            "the robot walks 10 mm above the ground",
            Violates(Check::Contact, "off the ground"),
            |damaged| damaged.push_all(0.01 * DVec3::Z),
        ),
        ("the robot walks 6 mm below the ground", Violates(Check::Contact, "deep"), |damaged| {
            damaged.push_all(-0.006 * DVec3::Z)
        }),
        (
            "the ground is missing",
            Violates(Check::Contact, "supported over"),
            DamagedPlan::remove_stones,
        ),
        ("the ground is aside", Violates(Check::Contact, "supported over"), |damaged| {
            damaged.stones().for_each(|stone| push(&mut stone.pose.xyz, 2.0 * DVec3::Y));
        }),
        ("the ground is 10 mm lower", Violates(Check::Contact, "off the ground"), |damaged| {
            damaged.stones().for_each(|stone| push(&mut stone.pose.xyz, -0.01 * DVec3::Z));
        }),
        (
            "only the outer edge of a sole is on its stone",
            Violates(Check::Balance, "centre of mass"),
            |damaged| push(&mut damaged.stone().pose.xyz, -0.1 * DVec3::Y),
        ),
        ("a stone stands 10 mm higher", Violates(Check::Contact, "deep"), |damaged| {
            push(&mut damaged.stone().pose.xyz, 0.01 * DVec3::Z)
        }),
        ("a stone is tilted", Violates(Check::Contact, "right sole"), |damaged| {
            turn(&mut damaged.stone().pose, DVec3::X, 8.0)
        }),
        ("a kept foot is declared elsewhere", Violates(Check::Continuity, "foot"), |damaged| {
            let phase = damaged.middle_phase("right");
            push(&mut damaged.plan.phases[phase].contacts[0].sole_pose.xyz, 1e-4 * DVec3::X);
        }),
        ("both feet change at once", Violates(Check::Continuity, "without both feet"), |damaged| {
            let phase = damaged.middle_phase("double");
            let mode = damaged.plan.phases[phase - 1].mode.clone();
            let contacts = damaged.plan.phases[phase - 1].contacts.clone();
            (damaged.plan.phases[phase].mode, damaged.plan.phases[phase].contacts) =
                (mode, contacts);
        }),
    ]
}

fn forces() -> Vec<Damage> {
    vec![
        (
            "one foot alone while the weight shifts",
            Violates(Check::Balance, "centre of mass"),
            |damaged| {
                let phase = damaged.middle_phase("double");
                let mode = damaged.plan.phases[phase - 1].mode.clone();
                let contacts = damaged.plan.phases[phase - 1].contacts.clone();
                (damaged.plan.phases[phase].mode, damaged.plan.phases[phase].contacts) =
                    (mode, contacts);
            },
        ),
        ("only the heel carries", Violates(Check::Balance, "centre of mass"), |damaged| {
            damaged.sole_polygons().flatten().for_each(|corner| corner[0] = corner[0].min(-0.03));
        }),
        ("a strip of the sole carries", Violates(Check::Balance, "centre of mass"), |damaged| {
            damaged.sole_polygons().flatten().for_each(|corner| corner[1] = corner[1].max(0.05));
        }),
        ("all motors are weak", Violates(Check::Torque, "needs"), |damaged| {
            damaged.plan.robot.effort_scale = Some(0.2)
        }),
        ("a knee is weak", Violates(Check::Torque, "left_knee"), |damaged| {
            damaged.plan.robot.effort_limits.insert("left_knee".into(), 15.0);
        }),
        ("a shoulder is weak", Violates(Check::Torque, "right_shoulder_roll"), |damaged| {
            damaged.plan.robot.effort_limits.insert("right_shoulder_roll".into(), 0.1);
        }),
    ]
}

fn collisions() -> Vec<Damage> {
    vec![
        ("a beam at the height of the chest", Violates(Check::Collision, "intruder"), |damaged| {
            damaged.add_box(damaged.root(damaged.mid_step()) + 0.3 * DVec3::Z, [0.02, 2.0, 0.02]);
        }),
        (
            "a ball in the way of the swinging foot",
            Violates(Check::Collision, "intruder"),
            |damaged| {
                let sole = DVec3::from(damaged.stance().sole_pose.xyz);
                damaged.add(sole + DVec3::new(0.0, 0.2, 0.04), ShapeBlock::Sphere { radius: 0.02 });
            },
        ),
        ("a plate thinner than any step", Violates(Check::Collision, "intruder"), |damaged| {
            damaged.add_box(
                damaged.root(damaged.mid_step()) + DVec3::new(0.013, 0.0, 0.1),
                [2e-3, 0.02, 0.02],
            );
        }),
        ("a wire between the legs", Violates(Check::Collision, "intruder"), |damaged| {
            let at = damaged.root(damaged.mid_step());
            damaged.add(at, ShapeBlock::Capsule { radius: 3e-3, length: 0.4 });
        }),
        ("a mesh in the way", Violates(Check::Collision, "intruder"), |damaged| {
            std::fs::write(damaged.folder.join("cube.obj"), cube_obj(0.05)).unwrap();
            let at = damaged.root(damaged.mid_step());
            damaged.add(
                at + 0.2 * DVec3::Z,
                ShapeBlock::Mesh { path: "cube.obj".into(), scale: None },
            );
        }),
        ("the robot is inside a closed mesh", Violates(Check::Collision, "intruder"), |damaged| {
            std::fs::write(damaged.folder.join("rock.obj"), cube_obj(20.0)).unwrap();
            damaged.add(DVec3::ZERO, ShapeBlock::Mesh { path: "rock.obj".into(), scale: None });
        }),
        ("an arm reaches into the trunk", Violates(Check::SelfCollision, "overlaps"), |damaged| {
            damaged.bend("left_shoulder_roll", -0.5, damaged.everywhere());
        }),
        ("the legs collide", Violates(Check::SelfCollision, "overlaps"), |damaged| {
            damaged.bend("left_hip_roll", -0.35, damaged.everywhere())
        }),
    ]
}

fn ends() -> Vec<Damage> {
    vec![
        ("the start stance is elsewhere", Start, |damaged| {
            move_soles(&mut damaged.plan.start, 0.01)
        }),
        ("the goal stance is elsewhere", Goal, |damaged| move_soles(&mut damaged.plan.goal, 0.2)),
        ("the walk ends halfway", Goal, |damaged| {
            damaged.cut_after(damaged.middle_phase("double"))
        }),
        ("the walk begins halfway", Start, |damaged| {
            damaged.cut_before(damaged.middle_phase("double"))
        }),
    ]
}

fn move_soles(end: &mut EndBlock, change: f64) {
    if let EndBlock::Feet { soles, .. } = end {
        soles.values_mut().for_each(|sole| push(&mut sole.xyz, change * DVec3::X));
    }
}
