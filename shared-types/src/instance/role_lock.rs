//! The lock of a role: one process of an instance holds it at a time. The kernel frees it with its
//! holder.

use std::fs::File;

use crate::instance::error::InstanceError;
use crate::instance::instance::Instance;
use crate::instance::tuning::{ROLE_ATTEMPTS_MAX, ROLE_PAUSE};

/// Locks the file `name` in the root of an instance; `None` if another process holds it. Waits
/// shortly for a killed predecessor that is being reaped.
///
/// # Errors
/// The file is no regular file of this user, or the file system fails.
pub fn acquire(instance: &Instance, name: &str) -> Result<Option<File>, InstanceError> {
    let file = instance.open_file(name)?;
    for _ in 0..ROLE_ATTEMPTS_MAX {
        if file.try_lock().is_ok() {
            return Ok(Some(file));
        }
        std::thread::sleep(ROLE_PAUSE);
    }
    Ok(None)
}
