//! Finds meshes that are too large for their robot: files in millimetres, or with a wrong scale.

use glam::DVec3;

use crate::base::input_error::InputError;
use crate::geometry::shape::Shape;
use crate::mesh::store::extent;

use crate::robot::model::RobotModel;
use crate::robot::tree::TreeLink;
use crate::robot::urdf::Urdf;
use crate::robot::urdf_link::Geometry;

/// A link is at most this many times as long as the robot from frame to frame.
const LENGTH_RATIO_MAX: f64 = 1.5;
/// Meshes this many times as long as the robot are taken for millimetres.
const MILLIMETRES_RATIO_MIN: f64 = 30.0;

/// Refuses links whose meshes are longer than the whole robot, as it stands.
pub(crate) fn check_mesh_sizes(
    robot: &RobotModel,
    urdf: &Urdf,
    tree: &[TreeLink],
) -> Result<(), InputError> {
    let mut complaints = Vec::new();
    let length = skeleton_length(robot);
    for (link, node) in robot.links.iter().zip(tree) {
        let points = |shape: &Shape| match shape {
            Shape::ConvexHull { points, .. } | Shape::Mesh { vertices: points, .. } => {
                extent(points)
            }
            _ => 0.0,
        };
        let longest = link.shapes.iter().map(|part| points(&part.shape)).fold(0.0, f64::max);
        if longest <= LENGTH_RATIO_MAX * length {
            continue;
        }
        let raw = &urdf.links[node.urdf_link];
        let mesh = raw.collisions.iter().find_map(|collision| match &collision.geometry {
            Geometry::Mesh { filename, .. } => Some((&collision.location, filename)),
            _ => None,
        });
        let Some((location, filename)) = mesh else { continue };
        let question = if longest >= MILLIMETRES_RATIO_MIN * length {
            "millimetres? set scale=\"0.001 0.001 0.001\" in its <mesh>"
        } else {
            "is the scale of its <mesh> ten times too large, or its unit centimetres?"
        };
        let message = format!(
            "mesh {filename} is {longest:.1} m long on a robot of {length:.1} m: {question}"
        );
        complaints.push(location.error(format!("link '{}'", link.name), message));
    }
    InputError::all(complaints)
}

/// The longest side of the box around all link frames, centres of mass and soles.
fn skeleton_length(robot: &RobotModel) -> f64 {
    let poses = robot.root_from_links(&robot.standing_q);
    let frames = poses.iter().map(|pose| pose.translation);
    let with_mass = robot.links.iter().zip(&poses).filter(|(link, _)| link.mass > 0.0);
    let centres = with_mass.map(|(link, pose)| *pose * link.com);
    let soles = robot.feet.iter().flat_map(|foot| {
        let root_from_sole = poses[foot.link] * foot.link_from_sole;
        foot.polygon.iter().map(move |corner| root_from_sole * corner.extend(0.0))
    });
    extent(&frames.chain(centres).chain(soles).collect::<Vec<DVec3>>())
}
