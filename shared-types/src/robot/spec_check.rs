//! Whether what a robot file says fits the URDF that it names.

use std::collections::BTreeMap;
use std::path::Path;

use crate::base::closest::closest;
use crate::base::input_error::InputError;
use crate::base::text_file::FileLocation;
use crate::plan_format::blocks::UrdfAdditions;
use crate::robot::joints::{check_names, no_such_joint};
use crate::robot::model::AllowedOverlap;
use crate::robot::spec::RobotSpec;
use crate::robot::tree::TreeLink;
use crate::robot::urdf::Urdf;
use crate::robot::urdf_joint::UrdfJoint;
use crate::robot::urdf_link::{Collision, Geometry, UrdfLink};

/// Refuses names of joints and links that the URDF does not have, and additions to it that do not
/// fit.
pub(crate) fn check_spec(urdf: &Urdf, spec: &RobotSpec, complaints: &mut Vec<InputError>) {
    check_names(urdf, "[standing]", &spec.standing, complaints);
    check_names(urdf, "[locked]", &spec.locked, complaints);
    check_names(urdf, "[effort_limits]", &spec.effort_limits, complaints);
    check_names(urdf, "[accelerations]", &spec.accelerations, complaints);
    check_link_names(urdf, "exact_meshes", &spec.exact_meshes, complaints);
    check_additions(urdf, &spec.additions, &spec.additions_location, complaints);
}

/// Refuses another root than that of the URDF.
pub(crate) fn check_root(
    urdf: &Urdf,
    tree: &[TreeLink],
    spec: &RobotSpec,
    complaints: &mut Vec<InputError>,
) {
    let root = &urdf.links[tree[0].urdf_link].name;
    if let Some((stated, location)) = spec.root.as_ref().filter(|(stated, _)| stated != root) {
        let message = format!("is '{stated}', but the URDF's root link is '{root}'; write that");
        complaints.push(location.error("root", message));
    }
}

/// Refuses names in a list that are not links of the URDF.
fn check_link_names(
    urdf: &Urdf,
    list: &str,
    names: &[(String, FileLocation)],
    complaints: &mut Vec<InputError>,
) {
    for (name, location) in names {
        if !urdf.links.iter().any(|link| link.name == *name) {
            complaints.push(location.error(list, no_such_link(urdf, name)));
        }
    }
}

/// The links that may overlap; refuses names that are not links of the URDF.
pub(crate) fn allowed_overlaps(
    spec: &RobotSpec,
    urdf: &Urdf,
    complaints: &mut Vec<InputError>,
) -> Vec<AllowedOverlap> {
    let known = |name: &String| urdf.links.iter().any(|link| link.name == *name);
    for (at, (allowed, location)) in spec.allowed_overlaps.iter().enumerate() {
        let [a, b] = &allowed.links;
        let is_same = |(other, _): &(AllowedOverlap, FileLocation)| {
            other.links.contains(a) && other.links.contains(b)
        };
        if a == b {
            let message = format!("names '{a}' twice; name two links");
            complaints.push(location.error("allowed_overlaps", message));
        } else if spec.allowed_overlaps[..at].iter().any(is_same) {
            let message = format!("'{a}' and '{b}' stand there twice; remove one entry");
            complaints.push(location.error("allowed_overlaps", message));
        }
        let unknown = allowed.links.iter().filter(|name| !known(name));
        complaints.extend(
            unknown.map(|name| location.error("allowed_overlaps", no_such_link(urdf, name))),
        );
    }
    spec.allowed_overlaps.iter().map(|(allowed, _)| allowed.clone()).collect()
}

/// Refuses additions to links and joints that the URDF does not have.
fn check_additions(
    urdf: &Urdf,
    additions: &UrdfAdditions,
    location: &FileLocation,
    complaints: &mut Vec<InputError>,
) {
    let shapes = additions.visual_shapes.iter().map(|name| ("visual_shapes", name));
    let missing = additions.missing_meshes.iter().map(|name| ("missing_meshes", name));
    let inertias = additions.inertias.keys().map(|name| ("[inertias]", name));
    for (element, name) in shapes.chain(missing).chain(inertias) {
        match urdf.links.iter().find(|link| link.name == *name) {
            None => complaints.push(location.error(element, no_such_link(urdf, name))),
            Some(link) if element == "visual_shapes" && !has_looks(link) => {
                let message = format!("link '{name}' has no <visual> that can be read");
                complaints.push(location.error(element, message));
            }
            Some(_) => {}
        }
    }
    for (name, folder) in &additions.packages {
        if !Path::new(folder).is_dir() {
            let message = format!("is '{folder}', which is no folder");
            complaints.push(location.error(format!("[packages] '{name}'"), message));
        }
    }
    for (name, moments) in &additions.inertias {
        let message = format!("the moments of '{name}' must be positive");
        if !moments.iter().all(|moment| moment.is_finite() && *moment > 0.0) {
            complaints.push(location.error("[inertias]", message));
        }
    }
    let unknown = additions.position_limits.keys().filter(|name| !has_joint(urdf, name));
    complaints.extend(unknown.map(|name| {
        location.error(format!("[position_limits] '{name}'"), no_such_joint(urdf, name))
    }));
    check_velocity_limits(urdf, &additions.velocity_limits, location, complaints);
}

/// Refuses limits of joints that the URDF does not have, and those above the URDF's.
fn check_velocity_limits(
    urdf: &Urdf,
    limits: &BTreeMap<String, f64>,
    location: &FileLocation,
    complaints: &mut Vec<InputError>,
) {
    for (name, velocity) in limits {
        let joint = urdf.joints.iter().find(|joint| joint.name == *name);
        let is_tighter =
            |stated: f64| *velocity > 0.0 && velocity.is_finite() && *velocity <= stated;
        let message = match joint.map(stated_velocity) {
            Some(stated) if is_tighter(stated) => continue,
            Some(stated) => {
                format!("is {velocity}; it must be positive and at most the URDF's {stated}")
            }
            None => no_such_joint(urdf, name),
        };
        complaints.push(location.error(format!("[velocity_limits] '{name}'"), message));
    }
}

/// Whether a link has looks, or nothing but balls that stand for contact points in simulators and
/// are not part of its surface.
fn has_looks(link: &UrdfLink) -> bool {
    let is_ball = |part: &Collision| matches!(part.geometry, Geometry::Sphere(_));
    let has_balls = !link.collisions.is_empty() && link.collisions.iter().all(is_ball);
    !link.visuals.is_empty() || has_balls
}

/// A joint's velocity limit in the URDF; infinite where it states none, or 0 for an unknown one.
fn stated_velocity(joint: &UrdfJoint) -> f64 {
    let velocity = joint.limit.as_ref().and_then(|limit| limit.velocity);
    velocity.filter(|velocity| *velocity > 0.0).unwrap_or(f64::INFINITY)
}

fn has_joint(urdf: &Urdf, name: &str) -> bool {
    urdf.joints.iter().any(|joint| joint.name == name)
}

fn no_such_link(urdf: &Urdf, name: &str) -> String {
    let known = urdf.links.iter().map(|link| link.name.as_str());
    let meant = closest(name, known).map(|meant| format!("; did you mean '{meant}'?"));
    format!("the URDF has no link '{name}'{}", meant.unwrap_or_default())
}
