//! The native part of the Python package `surefoot`: thin classes around the library's, with
//! numbers as numpy arrays. `package/surefoot` holds what a user sees.

mod arrays;
mod checker;
mod errors;
mod parameters;
mod plan;
mod planning;
mod robot;
mod scenario;
mod shipped;
mod world;

/// The extension module `surefoot._native`.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use crate::checker::Checker;
    #[pymodule_export]
    use crate::parameters::Parameters;
    #[pymodule_export]
    use crate::plan::Plan;
    #[pymodule_export]
    use crate::planning::plan;
    #[pymodule_export]
    use crate::robot::Robot;
    #[pymodule_export]
    use crate::scenario::load_scenario;
    #[pymodule_export]
    use crate::shipped::{resolve, shipped};
    #[pymodule_export]
    use crate::world::{World, WorldBuilder};
}
