//! The sampled table.

use surefoot::export::joint_selection::Selection;
use surefoot::export::quaternion::QuaternionOrder;
use surefoot::export::sampling::{Sample, samples};
use surefoot::export::{ExportFormat, ExportOptions};

use crate::plan::{MOTION, exported, options};

const HZ: f64 = 5.0;

/// The names of the columns and the rows of a table.
fn table(joints: Selection, quaternion: QuaternionOrder) -> (Vec<String>, Vec<Vec<f64>>) {
    let bytes = exported(&ExportOptions {
        hz: Some(HZ),
        joints: Some(joints),
        quaternion: Some(quaternion),
        ..options(ExportFormat::Csv)
    });
    let text = String::from_utf8(bytes).unwrap();
    let mut lines = text.lines();
    let names = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let numbers = |line: &str| line.split(',').map(|number| number.parse().unwrap()).collect();
    (names, lines.map(numbers).collect())
}

fn column(names: &[String], name: &str) -> usize {
    names.iter().position(|other| other == name).unwrap_or_else(|| panic!("no {name}: {names:?}"))
}

#[test]
fn samples_are_equally_spaced_and_reach_both_ends() {
    let (names, rows) = table(Selection::Surefoot, QuaternionOrder::Xyzw);
    let (begin, end) = MOTION.span();
    assert_eq!(rows.len(), libm::ceil((end - begin) * HZ - 1e-9) as usize + 1);
    for (index, row) in rows.iter().enumerate() {
        assert!((row[0] - index as f64 / HZ).abs() < 1e-12 && row.len() == names.len());
    }
    let first_joint = column(&names, &format!("position:{}", MOTION.model.joints[0].name));
    for (row, waypoint) in [(0, 0), (rows.len() - 1, MOTION.waypoints.len() - 1)] {
        let waypoint = &MOTION.waypoints[waypoint];
        assert_eq!(rows[row][1..4], waypoint.root_position);
        let joints = MOTION.model.joints.len();
        assert_eq!(rows[row][first_joint..first_joint + joints], waypoint.q[..joints]);
    }
}

#[test]
fn velocities_are_the_differences_of_positions() {
    let joints = MOTION.model.joints.len();
    let hz = 200.0;
    let all: Vec<Sample> = samples(&MOTION, hz).unwrap().collect();
    let begin = MOTION.span().0;
    let mut compared = 0;
    for pair in all.windows(2) {
        let [from, to] = [&pair[0], &pair[1]];
        let next = MOTION.waypoints.iter().find(|waypoint| waypoint.time > begin + from.time);
        if next.is_none_or(|next| next.time < begin + to.time) {
            continue;
        }
        for joint in 0..joints {
            let difference = hz * (to.waypoint.q[joint] - from.waypoint.q[joint]);
            assert!((difference - from.waypoint.joint_velocity[joint]).abs() < 1e-6);
            compared += 1;
        }
    }
    assert!(compared > 1000 * joints, "{compared}");
}

#[test]
fn the_order_of_joints_and_quaternions_is_the_one_asked_for() {
    let (names, rows) = table(Selection::Surefoot, QuaternionOrder::Xyzw);
    let chosen = [&MOTION.model.joints[3].name, &MOTION.model.joints[1].name].map(Clone::clone);
    let (other_names, others) = table(Selection::Names(chosen.to_vec()), QuaternionOrder::Wxyz);
    let place = column(&other_names, &format!("position:{}", chosen[0]));
    assert_eq!(other_names[place + 1], format!("position:{}", chosen[1]));
    assert_eq!(other_names[place + 2], format!("velocity:{}", chosen[0]));
    assert_eq!(other_names[4..8], ["root_qw", "root_qx", "root_qy", "root_qz"]);
    for (row, other) in rows.iter().zip(&others) {
        let of_all = |name: &String| row[column(&names, name)];
        let same: Vec<f64> = other_names.iter().map(of_all).collect();
        assert_eq!(&same, other);
    }
    let (urdf_names, _) = table(Selection::Urdf, QuaternionOrder::Xyzw);
    let sorted = |names: &[String]| {
        let mut sorted = names.to_vec();
        sorted.sort();
        sorted
    };
    assert_ne!(urdf_names, names, "Hubo's URDF lists its joints in another order");
    assert_eq!(sorted(&urdf_names), sorted(&names));
}

#[test]
fn efforts_say_that_they_are_static_and_carry_the_weight() {
    let (names, rows) = table(Selection::Surefoot, QuaternionOrder::Xyzw);
    let effort = column(&names, &format!("static_effort:{}", MOTION.model.joints[0].name));
    let limits = MOTION.model.joints.iter().map(|joint| joint.effort);
    for row in &rows {
        let efforts = &row[effort..effort + MOTION.model.joints.len()];
        assert!(efforts.iter().zip(limits.clone()).all(|(effort, limit)| effort.abs() <= limit));
        assert!(efforts.iter().any(|effort| effort.abs() > 1.0), "{efforts:?}");
        let feet = [column(&names, "contact:left"), column(&names, "contact:right")];
        assert!(feet.iter().any(|&foot| row[foot] == 1.0));
    }
    let lifted = |foot: &str| rows.iter().any(|row| row[column(&names, foot)] == 0.0);
    assert!(lifted("contact:left") && lifted("contact:right"));
}
