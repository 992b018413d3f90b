//! Kinematics and torques of Hubo as Pinocchio computes them.

use serde_json::Value;

/// The reference data.
pub fn reference() -> Value {
    let path = crate::common::repository().join("tests/data/pinocchio_hubo.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// A list of numbers.
pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}
