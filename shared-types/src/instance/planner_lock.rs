//! The planner's lock, which names the publisher of its chunks.
//!
//! Any process of the user may publish chunks. A reader knows from which publisher a chunk comes,
//! whatever the chunk contains: iceoryx2 makes one connection for each. That distinguishes the
//! planner's chunks from those of a process that does not hold the lock.

use std::fs::File;
use std::os::unix::fs::FileExt;

use crate::instance::error::{InstanceError, io_error};
use crate::instance::instance::Instance;
use crate::instance::role_lock;

/// The lock file's name in the instance's folder. It contains the publisher's id.
const FILE: &str = "planner";

/// The lock, held as long as a planner may send chunks.
#[derive(Debug)]
pub struct PlannerLock {
    file: File,
    instance: Instance,
}

impl PlannerLock {
    /// Takes the lock; `None` if another planner holds it.
    ///
    /// # Errors
    /// The file is no regular file of this user, or the file system fails.
    pub fn acquire(instance: &Instance) -> Result<Option<Self>, InstanceError> {
        let file = role_lock::acquire(instance, FILE)?;
        Ok(file.map(|file| Self { file, instance: instance.clone() }))
    }

    /// Names the publisher of this planner's chunks. Call it before the first one is sent.
    ///
    /// # Errors
    /// The file system fails.
    pub fn name_publisher(&self, id: u128) -> Result<(), InstanceError> {
        let written = self.file.write_all_at(&id.to_le_bytes(), 0);
        written.map_err(|error| io_error(&self.instance.root().join(FILE), error))
    }
}

/// Distinguishes the planner's chunks from those of other publishers.
#[derive(Debug)]
pub struct PlannerPublisher {
    file: File,
    /// The publisher that the lock named last.
    id: Option<u128>,
}

impl PlannerPublisher {
    /// The publisher that planners of this instance name, from now on.
    ///
    /// # Errors
    /// The lock is no regular file of this user, or the file system fails.
    pub fn open(instance: &Instance) -> Result<Self, InstanceError> {
        Ok(Self { file: instance.open_file(FILE)?, id: None })
    }

    /// Whether the planner sent the chunk of the publisher `id`. The last planner remains the one
    /// until another holds the lock. As long as none ever held it, all publishers count.
    pub fn is(&mut self, id: u128) -> bool {
        if self.id == Some(id) {
            return true;
        }
        self.id = self.named();
        self.id.is_none_or(|named| named == id)
    }

    fn named(&self) -> Option<u128> {
        let mut id = [0; size_of::<u128>()];
        self.file.read_exact_at(&mut id, 0).ok()?;
        Some(u128::from_le_bytes(id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_publisher_of_the_last_planner_is_the_one() {
        let base = tempfile::tempdir_in("/dev/shm").unwrap();
        let instance = Instance::create_in(&base.path().join("base"), "planner").unwrap();
        let mut planner = PlannerPublisher::open(&instance).unwrap();
        assert!([1, 2].into_iter().all(|id| planner.is(id)), "no planner was there");
        let lock = PlannerLock::acquire(&instance).unwrap().unwrap();
        lock.name_publisher(1).unwrap();
        assert_eq!([1, 2, 1].map(|id| planner.is(id)), [true, false, true]);
        drop(lock);
        assert_eq!([2, 1].map(|id| planner.is(id)), [false, true], "what it left still counts");
        let lock = PlannerLock::acquire(&instance).unwrap().unwrap();
        lock.name_publisher(2).unwrap();
        assert_eq!([2, 1].map(|id| planner.is(id)), [true, false]);
    }
}
