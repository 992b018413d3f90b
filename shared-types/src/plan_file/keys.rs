//! Keys of a plan file that are nearly known ones. Other programs may add keys of their own, but a
//! mistyped one of ours must not be passed over: without its effort limits a robot is stronger.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, Visitor};

use crate::base::closest::closest;

/// The keys of a plan file.
const OF_PLAN: [&str; 12] = [
    "schema",
    "robot",
    "scene",
    "joint_names",
    "waypoints",
    "phases",
    "chunks",
    "start",
    "goal",
    "origin",
    "disturb_seed",
    "executed",
];
/// The keys of its robot.
const OF_ROBOT: [&str; 9] = [
    "urdf",
    "robot_file",
    "feet",
    "locked_joints",
    "exact_meshes",
    "effort_limits",
    "acceleration_limits",
    "effort_scale",
    "urdf_additions",
];

type Keys = BTreeMap<String, IgnoredAny>;

/// The keys of a plan file and of its robot, found in one pass.
#[derive(Default)]
struct PlanKeys {
    plan: Keys,
    robot: Keys,
}

impl<'de> Deserialize<'de> for PlanKeys {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Self::default())
    }
}

impl<'de> Visitor<'de> for PlanKeys {
    type Value = Self;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a plan")
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut map: A) -> Result<Self, A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            if key == "robot" {
                self.robot = map.next_value()?;
            } else {
                map.next_value::<IgnoredAny>()?;
            }
            self.plan.insert(key, IgnoredAny);
        }
        Ok(self)
    }
}

/// Checks the keys of a plan file that can be read.
///
/// # Errors
/// The element that has a key which is nearly a known one, and both.
pub(crate) fn check_keys(text: &str) -> Result<(), (String, String)> {
    let keys: PlanKeys = serde_json::from_str(text).unwrap_or_default();
    check("plan", &keys.plan, &OF_PLAN)?;
    check("robot", &keys.robot, &OF_ROBOT)
}

fn check(element: &str, keys: &Keys, known: &[&str]) -> Result<(), (String, String)> {
    let unknown = keys.keys().filter(|key| !known.contains(&key.as_str()));
    let mut nearly = unknown.filter_map(|key| Some((key, closest(key, known.iter().copied())?)));
    nearly.next().map_or(Ok(()), |(key, meant)| {
        Err((element.to_owned(), format!("the key '{key}' is unknown; is '{meant}' meant?")))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_known_keys_are_those_of_the_schema() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/schemas/biped-plan-1.schema.json");
        let text = std::fs::read_to_string(path).unwrap();
        let schema: serde_json::Value = serde_json::from_str(&text).unwrap();
        let keys = |pointer: &str| -> Vec<String> {
            let properties = schema.pointer(pointer).and_then(|found| found.as_object());
            properties.unwrap().keys().cloned().collect()
        };
        let sorted = |known: &[&str]| {
            let mut known: Vec<String> = known.iter().map(|key| (*key).to_owned()).collect();
            known.sort();
            known
        };
        assert_eq!(keys("/properties"), sorted(&OF_PLAN));
        assert_eq!(keys("/$defs/RobotBlock/properties"), sorted(&OF_ROBOT));
    }
}
