//! Numbers on the command line.

use surefoot_shared_types::NUMBER_MAX;

/// A whole number.
pub fn whole_number<N: TryFrom<u64>>(text: &str) -> Result<N, String> {
    let number = text.parse::<u64>().ok().and_then(|number| N::try_from(number).ok());
    number.ok_or_else(|| "a whole number is needed, 0 or more".to_owned())
}

/// A whole number between two others, both of which count.
pub fn whole_number_between<N: TryFrom<u64>>(
    least: u64,
    most: u64,
) -> impl Fn(&str) -> Result<N, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse().ok().filter(|number| (least..=most).contains(number));
        let number = number.and_then(|number| N::try_from(number).ok());
        number.ok_or_else(|| format!("a whole number from {least} to {most} is needed"))
    }
}

/// A positive number.
pub fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0 && *number <= NUMBER_MAX);
    number.ok_or_else(|| format!("a positive number of at most {NUMBER_MAX:e} is needed"))
}

/// A number of 0 or more.
pub fn not_negative(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| (0.0..=NUMBER_MAX).contains(number));
    number.ok_or_else(|| format!("a number from 0 to {NUMBER_MAX:e} is needed"))
}
