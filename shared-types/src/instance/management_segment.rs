//! iceoryx2's management segment, made here so that it is closed to other users at all times.
//!
//! iceoryx2 0.10.0 makes this one segment itself with mode 0666 if it does not exist; in that
//! moment another user may open it, and later change its content or its size. It opens an existing
//! one without changing its mode. docs/UPSTREAM.md lists it.

use std::fs::{OpenOptions, Permissions};
use std::io::{ErrorKind, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;

use crate::base::user::effective_uid;
use crate::instance::error::{InstanceError, SHARED_MEMORY, io_error};
use crate::instance::private;

/// The segment's name after the prefix: the SHA-1 of
/// `iceoryx2::node::global_management_segment::State`, which is the type of its content, and the
/// version.
const NAME: &str = "9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt";
/// iceoryx2's version as it stands at the segment's beginning.
const VERSION: u64 = 10 << 16;
/// Bytes of the segment: the version, and a counter of nodes with padding.
const SIZE: usize = 16;
/// Mode of a segment that is being made.
const MODE_UNFINISHED: u32 = 0o200;
/// Mode of a finished segment.
const MODE: u32 = 0o600;

/// Makes the segment of an instance with this prefix, if it does not exist. The caller holds the
/// lock `making`, so that no process opens an unfinished one.
pub(crate) fn ensure(prefix: &str) -> Result<(), InstanceError> {
    let path = Path::new(SHARED_MEMORY).join(format!("{prefix}{NAME}"));
    let failed = |error| io_error(&path, error);
    let created = OpenOptions::new()
        .write(true)
        .create_new(true)
        .mode(MODE_UNFINISHED)
        .custom_flags(libc::O_NOFOLLOW)
        .open(&path);
    let mut file = match created {
        Ok(file) => file,
        Err(error) if error.kind() == ErrorKind::AlreadyExists => return check_owner(&path),
        Err(error) => return Err(failed(error)),
    };
    let mut content = [0; SIZE];
    content[..size_of::<u64>()].copy_from_slice(&VERSION.to_ne_bytes());
    file.write_all(&content).map_err(failed)?;
    file.set_permissions(Permissions::from_mode(MODE)).map_err(failed)
}

fn check_owner(path: &Path) -> Result<(), InstanceError> {
    let metadata = path.symlink_metadata().map_err(|error| io_error(path, error))?;
    if metadata.uid() == effective_uid() {
        return Ok(());
    }
    Err(private::not_private(path, format!("it belongs to user {}", metadata.uid())))
}

#[cfg(test)]
mod tests {
    use iceoryx2::prelude::{NodeBuilder, SignalHandlingMode, ipc};

    use super::*;
    use crate::instance::directory;
    use crate::instance::instance::Instance;

    /// The modes of the segments of an instance.
    fn modes(instance: &Instance) -> Vec<(String, u32)> {
        let segments = directory::segments(instance.segment_prefix()).unwrap();
        let mode = |path: &Path| path.symlink_metadata().unwrap().mode() & 0o777;
        let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
        segments.iter().map(|path| (name(path), mode(path))).collect()
    }

    #[test]
    fn iceoryx2_uses_our_segment_and_leaves_it_closed() {
        let base = tempfile::tempdir_in(SHARED_MEMORY).unwrap();
        let instance = Instance::create_in(&base.path().join("base"), "closed").unwrap();
        ensure(instance.segment_prefix()).unwrap();
        ensure(instance.segment_prefix()).unwrap();
        let node = NodeBuilder::new()
            .config(&instance.config().unwrap())
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .unwrap();
        let name = format!("{}{NAME}", instance.segment_prefix());
        assert_eq!(modes(&instance), [(name.clone(), MODE)]);
        let content = std::fs::read(Path::new(SHARED_MEMORY).join(name)).unwrap();
        assert_eq!(content[size_of::<u64>()], 1, "iceoryx2 has counted the node there");
        drop(node);
    }
}
