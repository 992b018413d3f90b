//! Name, root folder and segment prefix of an instance.

use std::path::{Path, PathBuf};

use crate::base::digest::Digest;
use crate::instance::directory;
use crate::instance::error::{BASE_PATH_LEN_MAX, InstanceError, NAME_LEN_MAX};

/// Hexadecimal digits of the base folder's digest in a segment prefix.
const TAG_LEN: usize = 12;

/// Name, root folder and segment prefix of an instance.
#[derive(Debug, Clone)]
pub(crate) struct Location {
    /// The instance's name.
    pub(crate) name: String,
    /// The root folder: `<base>/<name>`.
    pub(crate) root: PathBuf,
    /// The beginning of every segment's name. It names the base folder too, because segments of
    /// all base folders lie in `/dev/shm`.
    pub(crate) prefix: String,
}

impl Location {
    /// The location of instance `name` below the folder `base`, neither of which needs to exist.
    pub(crate) fn new(base: &Path, name: &str) -> Result<Self, InstanceError> {
        if !is_name(name) {
            return Err(InstanceError::Name { name: name.to_owned() });
        }
        let path =
            base.to_str().filter(|path| base.is_absolute() && path.len() <= BASE_PATH_LEN_MAX);
        let path = path.ok_or_else(|| InstanceError::Path { path: base.to_owned() })?;
        let tag = Digest::of(&[path.as_bytes()]).to_string();
        Ok(Self {
            name: name.to_owned(),
            root: base.join(name),
            prefix: format!("surefoot-{}-{name}.", &tag[..TAG_LEN]),
        })
    }

    /// Removes the root folder and the segments. The caller holds the lock exclusively.
    pub(crate) fn remove(&self) -> Result<(), InstanceError> {
        directory::remove_segments(&self.prefix)?;
        directory::remove_root(&self.root)
    }
}

fn is_name(name: &str) -> bool {
    let is_name_byte = |byte: u8| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'_' | b'-');
    (1..=NAME_LEN_MAX).contains(&name.len()) && name.bytes().all(is_name_byte)
}
