//! One settable parameter: its range, its unit, its effect and the source of its default.

use std::fmt;
use std::ops::Bound::{self, Excluded, Included, Unbounded};

use crate::config::execution::ExecutionConfig;
use crate::config::planner::{CheckerConfig, PlannerConfig};

/// A parameter of a scenario's `[planner]`, `[checker]` or `[execution]` table.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// The table and the key, such as `planner.work_max`.
    pub name: &'static str,
    /// The unit; empty for a share or a plain number.
    pub unit: &'static str,
    /// What the parameter bounds or shapes.
    pub effect: &'static str,
    /// The values that a scenario may give it.
    pub range: Range,
    /// The relation to another parameter, which also bounds it; empty if there is none.
    pub relation: &'static str,
    /// Where the default comes from.
    pub source: &'static str,
    /// Reads the parameter out of its table.
    pub value: fn(&PlannerConfig, &CheckerConfig, &ExecutionConfig) -> Value,
}

impl Parameter {
    /// The default.
    pub fn default_value(&self) -> Value {
        let (planner, checker, execution) = Default::default();
        (self.value)(&planner, &checker, &execution)
    }
}

/// The value of a parameter, in the parameter's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// A whole number.
    Count(u64),
    /// A real number.
    Real(f64),
    /// One of several names.
    Name(&'static str),
}

impl Value {
    /// The value with at most six significant digits, for people.
    #[must_use]
    pub fn rounded(self) -> Self {
        match self {
            Self::Real(number) => Self::Real(format!("{number:.5e}").parse().unwrap_or(number)),
            Self::Count(_) | Self::Name(_) => self,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(count) => count.fmt(formatter),
            Self::Real(number) => number.fmt(formatter),
            Self::Name(name) => name.fmt(formatter),
        }
    }
}

/// The values that a parameter may have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// Whole numbers, both ends included.
    Counts {
        /// The smallest.
        least: u64,
        /// The largest; `u64::MAX` if only the type of the field bounds it.
        most: u64,
    },
    /// Real numbers; each end is included or excluded.
    Reals {
        /// The lower end.
        low: Bound<f64>,
        /// The upper end.
        high: Bound<f64>,
    },
    /// One of these names.
    Names(&'static [&'static str]),
}

impl Range {
    /// Whether the range holds the value. No range holds a NaN.
    pub fn contains(&self, value: Value) -> bool {
        match (*self, value) {
            (Self::Counts { least, most }, Value::Count(count)) => (least..=most).contains(&count),
            (Self::Reals { low, high }, Value::Real(number)) => {
                std::ops::RangeBounds::contains(&(low, high), &number)
            }
            (Self::Names(names), Value::Name(name)) => names.contains(&name),
            _ => false,
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rounded = |end: f64| Value::Real(end).rounded();
        let (low, high) = match *self {
            Self::Counts { least, most: u64::MAX } => return write!(formatter, "at least {least}"),
            Self::Counts { least, most } => return write!(formatter, "between {least} and {most}"),
            Self::Reals { low, high } => (low.map(rounded), high.map(rounded)),
            Self::Names(names) => return write!(formatter, "{}", names.join(" or ")),
        };
        match (low, high) {
            (Included(low), Included(high)) => write!(formatter, "between {low} and {high}"),
            (Included(low), Excluded(high)) => write!(formatter, "at least {low} and below {high}"),
            (Excluded(low), Included(high)) => write!(formatter, "above {low} and at most {high}"),
            (Excluded(low), Excluded(high)) => write!(formatter, "above {low} and below {high}"),
            (Unbounded, _) | (_, Unbounded) => write!(formatter, "any number"),
        }
    }
}
