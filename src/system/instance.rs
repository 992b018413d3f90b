//! Enters the shared-memory instance of a planner and a controller.

use surefoot_shared_types::instance::error::InstanceError;
use surefoot_shared_types::instance::instance::Instance;

/// Attempts to enter an instance that another process creates or leaves at the same time.
const ENTER_ATTEMPTS_MAX: usize = 5;

/// Enters an instance. Creates it if it does not exist.
pub(crate) fn enter_instance(name: &str) -> Result<Instance, InstanceError> {
    let mut attempts = 0;
    loop {
        attempts += 1;
        let entered = match Instance::attach(name) {
            Err(InstanceError::Missing { .. }) => Instance::create(name),
            entered => entered,
        };
        match entered {
            Err(InstanceError::InUse { .. }) if attempts < ENTER_ATTEMPTS_MAX => {}
            entered => return entered,
        }
    }
}
