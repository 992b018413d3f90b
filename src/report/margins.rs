//! The checks' worst margins, as reports carry them.

use serde::{Deserialize, Serialize};
use surefoot_shared_types::message::Margins;

/// The worst margin of each check; `None` if it was not measured.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct WorstMargins {
    /// To the nearest joint limit, rad or m.
    pub limits: Option<f64>,
    /// Of the stance foot's position tolerance, m.
    pub contact: Option<f64>,
    /// Of the centre of mass in the equilibrium region, m.
    pub balance: Option<f64>,
    /// Between robot and world, m.
    pub collision: Option<f64>,
    /// Between the robot's links, m.
    pub self_collision: Option<f64>,
    /// Share of the effort limit that stays unused.
    pub torque: Option<f64>,
    /// Of the zero-moment point in the equilibrium region, m.
    #[serde(default)]
    pub zero_moment: Option<f64>,
    /// Share of the effort limit that stays unused by the moving robot.
    #[serde(default)]
    pub dynamic_torque: Option<f64>,
}

impl From<&Margins> for WorstMargins {
    fn from(margins: &Margins) -> Self {
        let measured = |margin: f64| Some(margin).filter(|margin| margin.is_finite());
        Self {
            limits: measured(margins.limits),
            contact: measured(margins.contact),
            balance: measured(margins.balance),
            collision: measured(margins.collision),
            self_collision: measured(margins.self_collision),
            torque: measured(margins.torque),
            zero_moment: measured(margins.zero_moment),
            dynamic_torque: measured(margins.dynamic_torque),
        }
    }
}

impl WorstMargins {
    /// One line of text, e.g. `limits 0.012 rad, contact 1.8 mm`.
    pub fn describe(&self) -> String {
        let named = [
            ("limits", self.limits),
            ("contact", self.contact),
            ("balance", self.balance),
            ("collision", self.collision),
            ("self_collision", self.self_collision),
            ("torque", self.torque),
            ("zero_moment", self.zero_moment),
            ("dynamic_torque", self.dynamic_torque),
        ];
        let measured = named
            .into_iter()
            .filter_map(|(check, margin)| Some(format!("{} {}", check, with_unit(check, margin?))));
        measured.collect::<Vec<_>>().join(", ")
    }
}

/// A margin of the check of this name, with its unit.
pub fn with_unit(check: &str, margin: f64) -> String {
    match check {
        "limits" => format!("{margin:.4} rad"),
        "torque" | "dynamic_torque" | "acceleration" => format!("{:.1} %", 100.0 * margin),
        _ => format!("{:.2} mm", 1000.0 * margin),
    }
}
