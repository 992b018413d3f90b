//! Numbers: comparisons that NaN fails, linear equations, random numbers.

pub(crate) mod comparison;
pub(crate) mod linear_solve;
pub(crate) mod random;
