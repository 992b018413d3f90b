//! Creates and enters the shared-memory instance of a planner and a controller.

use surefoot_shared_types::instance::error::InstanceError;
use surefoot_shared_types::instance::instance::Instance;

/// Attempts to enter an instance that another process creates or leaves at the same time.
const ENTER_ATTEMPTS_MAX: usize = 5;

/// Most instances of processes with one number: a number names a process within its container only.
const NUMBERED_MAX: usize = 64;

/// Creates an instance of this process, `PREFIX-PID`. A process of another container may have the
/// same number and name; then a number follows.
pub fn create_own_instance(prefix: &str) -> Result<Instance, InstanceError> {
    let name = format!("{prefix}-{}", std::process::id());
    let mut created = Instance::create(&name);
    for number in 2..=NUMBERED_MAX {
        if !matches!(created, Err(InstanceError::InUse { .. })) {
            break;
        }
        created = Instance::create(&format!("{name}-{number}"));
    }
    created
}

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
