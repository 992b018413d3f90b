//! The lists as JSON: footsteps and contact sequence.

use glam::DVec3;
use surefoot::export::contact_sequence::ContactSequence;
use surefoot::export::footsteps::FootstepList;
use surefoot::export::{ExportFormat, ExportOptions};

use crate::plan::{MOTION, exported, options};

#[test]
fn footsteps_alternate_and_swings_join_them() {
    let list: FootstepList =
        serde_json::from_slice(&exported(&options(ExportFormat::Footsteps))).unwrap();
    let steps = &list.footsteps;
    assert!(steps.len() > 4 && steps[0].swing.is_none() && steps[1].swing.is_none());
    assert_ne!(steps[0].foot, steps[1].foot);
    assert!(steps.is_sorted_by(|a, b| a.touch_down <= b.touch_down));
    for (at, step) in steps.iter().enumerate().skip(2) {
        let swing = step.swing.as_ref().unwrap();
        let before = steps[..at].iter().rev().find(|other| other.foot == step.foot).unwrap();
        let (first, last) = (&swing.waypoints[0], swing.waypoints.last().unwrap());
        let apart = |a: [f64; 3], b: [f64; 3]| DVec3::from(a).distance(b.into());
        assert!(apart(first.sole_pose.xyz, before.sole_pose.xyz) < 2e-3, "step {at}");
        assert!(apart(last.sole_pose.xyz, step.sole_pose.xyz) < 2e-3, "step {at}");
        assert!(swing.lift_off == first.t && last.t == step.touch_down && first.t < last.t);
        assert!(swing.lift_off >= before.touch_down);
    }
    assert_eq!((list.begin, list.end), MOTION.span());
}

#[test]
fn wrenches_hold_the_robot_in_each_knot() {
    let hz = Some(2.0);
    let bytes = exported(&ExportOptions { hz, ..options(ExportFormat::Contacts) });
    let sequence: ContactSequence = serde_json::from_slice(&bytes).unwrap();
    let weight = sequence.robot.mass * sequence.gravity;
    assert!(sequence.knots.len() > 50);
    for knot in &sequence.knots {
        let contacts = &sequence.phases[knot.phase].contacts;
        let (mut force, mut moment) = (DVec3::ZERO, DVec3::ZERO);
        for wrench in &knot.wrenches {
            let contact = contacts.iter().find(|contact| contact.foot == wrench.foot).unwrap();
            let at = DVec3::from(contact.sole_pose.xyz) - DVec3::from(knot.com);
            force += DVec3::from(wrench.force);
            moment += DVec3::from(wrench.moment) + at.cross(wrench.force.into());
        }
        assert!((force - weight * DVec3::Z).length() < 1e-3 * weight, "{} s: {force}", knot.t);
        assert!(moment.length() < 1e-3 * weight, "{} s: {moment}", knot.t);
    }
    let spans = sequence.phases.windows(2).all(|pair| pair[0].end == pair[1].begin);
    assert!(spans && sequence.phases[0].begin == MOTION.span().0);
}
