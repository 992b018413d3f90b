//! A sole that does not lie on its foot everywhere.

use std::fmt;

/// A declared sole of which parts carry nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct HollowSole {
    /// The foot.
    pub foot: String,
    /// The share of the sole that lies on the foot, percent.
    pub percent_on_foot: f64,
    /// The share of the sole between those parts, where the centre of pressure can be, percent.
    pub percent_carrying: f64,
}

impl fmt::Display for HollowSole {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { foot, percent_on_foot, percent_carrying } = self;
        let on_foot = if *percent_on_foot > 0.0 && *percent_on_foot < 1.0 {
            "less than 1".to_owned()
        } else {
            percent_on_foot.floor().to_string()
        };
        write!(
            formatter,
            "{on_foot} % of the {foot} sole lie on the foot, {:.0} % between these parts; the rest \
             carries nothing",
            percent_carrying.floor()
        )
    }
}
