//! The folder of all instances of this user.
//!
//! It is `/dev/shm/surefoot-UID`. Where another user has taken that name, it is
//! `surefoot-UID-TOKEN` with a random token, which the other processes of this user find by its
//! owner.

use std::path::{Path, PathBuf};

use crate::base::user::effective_uid;
use crate::instance::directory;
use crate::instance::error::{InstanceError, SHARED_MEMORY, io_error};
use crate::instance::private;
use crate::instance::token::Token;
use crate::instance::tuning::{BASE_ATTEMPTS_MAX, BASE_LOCK_ATTEMPTS_MAX, BASE_LOCK_PAUSE};

/// The base folder; created if there is none.
pub(crate) fn ensure() -> Result<PathBuf, InstanceError> {
    match ensure_in(Path::new(SHARED_MEMORY)) {
        Err(InstanceError::Io { source, .. }) => Err(InstanceError::NoSharedMemory { source }),
        found => found,
    }
}

/// The base folder's usual path.
pub(crate) fn plain() -> PathBuf {
    Path::new(SHARED_MEMORY).join(plain_name())
}

/// The existing base folders of this user.
///
/// # Errors
/// A folder of this user may be entered by other users.
pub(crate) fn existing() -> Result<Vec<PathBuf>, InstanceError> {
    existing_in(Path::new(SHARED_MEMORY))
}

/// As [`ensure`], in the folder `parent`.
pub(crate) fn ensure_in(parent: &Path) -> Result<PathBuf, InstanceError> {
    let plain = parent.join(plain_name());
    match private::ensure_folder(&plain) {
        Err(InstanceError::NotPrivate { .. }) if is_foreign(&plain) => ensure_beside(parent),
        ensured => ensured.map(|_| plain),
    }
}

/// As [`existing`], in the folder `parent`.
pub(crate) fn existing_in(parent: &Path) -> Result<Vec<PathBuf>, InstanceError> {
    let plain = parent.join(plain_name());
    let mut found = match private::is_ours(&plain) {
        Ok(true) => vec![plain],
        Err(InstanceError::NotPrivate { .. }) if is_foreign(&plain) => vec![],
        Err(error @ InstanceError::NotPrivate { .. }) => return Err(error),
        Ok(false) | Err(_) => vec![],
    };
    found.extend(with_token(parent)?);
    Ok(found)
}

/// The folder with a token; created if there is none. Processes that do so at once take turns by a
/// lock on `parent`. Any user may hold that lock, so after a while it is ignored.
fn ensure_beside(parent: &Path) -> Result<PathBuf, InstanceError> {
    let lock = std::fs::File::open(parent).map_err(|error| io_error(parent, error))?;
    for _ in 0..BASE_LOCK_ATTEMPTS_MAX {
        if lock.try_lock().is_ok() {
            break;
        }
        std::thread::sleep(BASE_LOCK_PAUSE);
    }
    let mut attempts = 0;
    loop {
        attempts += 1;
        if let Some(first) = with_token(parent)?.into_iter().next() {
            return Ok(first);
        }
        let created = parent.join(format!("{}-{}", plain_name(), Token::random()));
        match private::ensure_folder(&created) {
            Err(error) if attempts == BASE_ATTEMPTS_MAX => return Err(error),
            Err(_) => {}
            Ok(_) => return Ok(created),
        }
    }
}

/// The private folders of this user in `parent` whose names end with a token, sorted.
fn with_token(parent: &Path) -> Result<Vec<PathBuf>, InstanceError> {
    let prefix = format!("{}-", plain_name());
    let is_candidate = |name: &String| name.strip_prefix(&prefix).is_some_and(Token::is_token);
    Ok(directory::child_names(parent)?
        .into_iter()
        .filter(is_candidate)
        .map(|name| parent.join(name))
        .filter(|path| matches!(private::is_ours(path), Ok(true)))
        .collect())
}

/// Whether another user made `path`, or it is not a folder.
fn is_foreign(path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    path.symlink_metadata()
        .is_ok_and(|metadata| !metadata.is_dir() || metadata.uid() != effective_uid())
}

fn plain_name() -> String {
    format!("surefoot-{}", effective_uid())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_is_taken_is_evaded_and_the_evasion_is_found() {
        let parent = tempfile::tempdir().unwrap();
        assert!(existing_in(parent.path()).unwrap().is_empty());
        std::fs::write(parent.path().join(plain_name()), "taken").unwrap();
        let first = ensure_in(parent.path()).unwrap();
        assert_ne!(first, parent.path().join(plain_name()));
        assert_eq!(ensure_in(parent.path()).unwrap(), first);
        assert_eq!(existing_in(parent.path()).unwrap(), [first]);
    }

    #[test]
    fn processes_that_evade_at_once_meet() {
        for _ in 0..20 {
            let parent = tempfile::tempdir().unwrap();
            std::fs::write(parent.path().join(plain_name()), "taken").unwrap();
            let gate = std::sync::Barrier::new(4);
            let found: Vec<PathBuf> = std::thread::scope(|scope| {
                let ensure = || {
                    gate.wait();
                    ensure_in(parent.path()).unwrap()
                };
                let threads = [(); 4].map(|()| scope.spawn(ensure));
                threads.into_iter().map(|thread| thread.join().unwrap()).collect()
            });
            assert!(found.iter().all(|path| *path == found[0]), "{found:?}");
        }
    }

    #[test]
    fn a_lock_that_stays_taken_stops_nobody() {
        let parent = tempfile::tempdir().unwrap();
        std::fs::write(parent.path().join(plain_name()), "taken").unwrap();
        let lock = std::fs::File::open(parent.path()).unwrap();
        lock.lock().unwrap();
        let created = ensure_in(parent.path()).unwrap();
        assert_eq!(existing_in(parent.path()).unwrap(), [created]);
    }
}
