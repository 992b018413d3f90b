//! What binds a smooth motion: which limit for which share of its time.

use serde::{Deserialize, Serialize};
use surefoot_shared_types::message::LimitKind;

/// Limits that a line of text names at most.
const SHOWN_MAX: usize = 5;
/// Least share of the time of such a limit.
const SHOWN_MIN: f64 = 0.01;

/// A limit that binds a motion for a part of its time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BindingShare {
    /// Its name; `none` where no limit binds: at rests, and where the acceleration changes.
    pub limit: String,
    /// The joint that it concerns.
    pub joint: Option<String>,
    /// Share of the motion's time, 0 to 1.
    pub share: f64,
}

/// The shares of limits, with the joints that they concern, in the sum of their times (s), the
/// longest first. A joint without a name is called by its index.
pub fn shares_of(
    times: impl IntoIterator<Item = (LimitKind, Option<usize>, f64)>,
    joint_name: impl Fn(usize) -> Option<String>,
) -> Vec<BindingShare> {
    let mut times: Vec<_> = times.into_iter().filter(|(.., seconds)| *seconds > 0.0).collect();
    let total: f64 = times.iter().map(|(.., seconds)| seconds).sum();
    times.sort_by(|a, b| b.2.total_cmp(&a.2));
    let name = |joint: usize| joint_name(joint).unwrap_or_else(|| format!("joint {joint}"));
    let share = |(kind, joint, seconds): (LimitKind, Option<usize>, f64)| BindingShare {
        limit: kind.name().to_owned(),
        joint: joint.map(name),
        share: seconds / total,
    };
    times.into_iter().map(share).collect()
}

/// What binds, in one line; empty where nothing is known of it.
pub fn describe(binding: &[BindingShare]) -> String {
    let share = |binding: &BindingShare| {
        let joint = binding.joint.as_ref().map_or(String::new(), |joint| format!(" of {joint}"));
        let name = binding.limit.replace('_', " ");
        format!("{name}{joint} {:.0} %", 100.0 * binding.share)
    };
    let shown = binding.iter().filter(|binding| binding.share >= SHOWN_MIN);
    shown.take(SHOWN_MAX).map(share).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_comes_first_and_joints_have_names() {
        let times = [
            (LimitKind::None, None, 0.5),
            (LimitKind::Torque, Some(0), 1.0),
            (LimitKind::Friction, None, 0.0),
            (LimitKind::Speed, Some(1), 2.5),
        ];
        let names = ["hip"];
        let shares = shares_of(times, |joint| names.get(joint).map(|name| (*name).to_owned()));
        assert_eq!(describe(&shares), "speed of joint 1 62 %, torque of hip 25 %, none 12 %");
        assert_eq!(shares.len(), 3);
        assert_eq!(describe(&shares_of([], |_| None)), "");
    }
}
