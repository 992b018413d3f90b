//! A table of samples as text: one row an instant, one column a number, named in the first row.

use surefoot_shared_types::message::Waypoint;

use crate::export::error::ExportError;
use crate::export::motion::ExportMotion;
use crate::export::quaternion::QuaternionOrder;
use crate::export::sampling::{EffortSource, Efforts, Sample, samples};

/// The table of a plan.
///
/// # Errors
/// Too many samples, or no contact forces hold the robot.
pub fn write(
    motion: &ExportMotion,
    hz: f64,
    joints: &[usize],
    quaternion: QuaternionOrder,
) -> Result<Vec<u8>, ExportError> {
    let mut efforts = Efforts::new(motion)?;
    let names = columns(motion, joints, quaternion);
    let mut table = line(names.iter().map(|name| quoted(name)));
    for sample in samples(motion, hz)? {
        let effort = efforts.of(&sample)?;
        let numbers = row(motion, &sample, joints, quaternion, &effort);
        table.push_str(&line(numbers.iter().map(f64::to_string)));
    }
    Ok(table.into_bytes())
}

/// A record of RFC 4180, with a line feed at its end.
fn line(fields: impl Iterator<Item = String>) -> String {
    let mut line = fields.collect::<Vec<_>>().join(",");
    line.push('\n');
    line
}

/// A field of RFC 4180, in quotes where it needs them.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\r', '\n']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

/// The names of all columns.
fn columns(motion: &ExportMotion, joints: &[usize], quaternion: QuaternionOrder) -> Vec<String> {
    let mut names = vec!["time".to_owned()];
    let mut root = |quantity: &str, axes: &[char]| {
        names.extend(axes.iter().map(|axis| format!("root_{quantity}{axis}")));
    };
    root("", &['x', 'y', 'z']);
    root("q", &quaternion.letters());
    root("v", &['x', 'y', 'z']);
    root("w", &['x', 'y', 'z']);
    root("a", &['x', 'y', 'z']);
    root("alpha_", &['x', 'y', 'z']);
    let effort = match EffortSource::of(motion) {
        EffortSource::Plan => "effort".to_owned(),
        source @ EffortSource::Static => format!("{}_effort", source.name()),
    };
    for quantity in ["position", "velocity", "acceleration", &effort] {
        let joint = |&joint: &usize| format!("{quantity}:{}", motion.model.joints[joint].name);
        names.extend(joints.iter().map(joint));
    }
    names.extend(motion.model.feet.iter().map(|foot| format!("contact:{}", foot.name)));
    names
}

fn row(
    motion: &ExportMotion,
    sample: &Sample,
    joints: &[usize],
    quaternion: QuaternionOrder,
    effort: &[f64],
) -> Vec<f64> {
    let Waypoint { root_position, root_rotation, root_velocity, root_acceleration, .. } =
        sample.waypoint;
    let waypoint = &sample.waypoint;
    let root = root_position.into_iter().chain(quaternion.arrange(root_rotation));
    let rates = root_velocity.into_iter().chain(root_acceleration);
    let of_joints = [&waypoint.q, &waypoint.joint_velocity, &waypoint.joint_acceleration];
    let of_joints = of_joints.map(|numbers| &numbers[..]).into_iter().chain([effort]);
    let of_joints = of_joints.flat_map(|numbers| joints.iter().map(move |&joint| numbers[joint]));
    let feet = 0..motion.model.feet.len();
    let contacts = feet.map(|limb| f64::from(u8::from(sample.is_stance(motion, limb))));
    [sample.time].into_iter().chain(root).chain(rates).chain(of_joints).chain(contacts).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_commas_and_quotes_stay_one_field() {
        assert_eq!(quoted("left \"knee\", inner"), "\"left \"\"knee\"\", inner\"");
        assert_eq!(line(["a", "b"].into_iter().map(quoted)), "a,b\n");
    }
}
