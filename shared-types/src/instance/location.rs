//! Name and root folder of an instance.

use std::path::{Path, PathBuf};

use crate::instance::directory;
use crate::instance::error::{BASE_PATH_LEN_MAX, InstanceError, NAME_LEN_MAX};
use crate::instance::token::Token;

/// Name and root folder of an instance.
#[derive(Debug, Clone)]
pub(crate) struct Location {
    /// The instance's name.
    pub(crate) name: String,
    /// The root folder: `<base>/<name>`.
    pub(crate) root: PathBuf,
}

impl Location {
    /// The location of instance `name` below the folder `base`, neither of which needs to exist.
    pub(crate) fn new(base: &Path, name: &str) -> Result<Self, InstanceError> {
        if !is_name(name) {
            return Err(InstanceError::Name { name: name.to_owned() });
        }
        let is_usable =
            base.is_absolute() && base.to_str().is_some_and(|path| path.len() <= BASE_PATH_LEN_MAX);
        if !is_usable {
            return Err(InstanceError::Path { path: base.to_owned() });
        }
        Ok(Self { name: name.to_owned(), root: base.join(name) })
    }

    /// The beginning of the name of every segment of the instance that has this token.
    pub(crate) fn prefix(&self, token: Token) -> String {
        format!("surefoot-{token}-{}.", self.name)
    }

    /// Removes the segments of the instance that had this token, and the root folder. The caller
    /// holds the lock exclusively.
    pub(crate) fn remove(&self, token: Option<Token>) -> Result<(), InstanceError> {
        self.remove_segments(token)?;
        directory::remove_root(&self.root)
    }

    /// Removes the segments of the instance that had this token.
    pub(crate) fn remove_segments(&self, token: Option<Token>) -> Result<(), InstanceError> {
        token.map_or(Ok(()), |token| directory::remove_segments(&self.prefix(token)))
    }
}

fn is_name(name: &str) -> bool {
    let is_name_byte = |byte: u8| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'_' | b'-');
    (1..=NAME_LEN_MAX).contains(&name.len()) && name.bytes().all(is_name_byte)
}
