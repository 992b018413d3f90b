//! The format of a preparation: a header and arrays of plain data after it, in words of eight bytes
//! that are read in place.
//!
//! ```text
//! Header   magic, version, key (of the robot and its margins), digest of the rest, contents
//! arrays   each a whole number of words, at the spans that the contents name
//! ```

use bytemuck::{Pod, Zeroable};
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::RobotModel;

use crate::preparation::error::PreparationError;
use crate::preparation::expanded_geometry::ExpandedGeometry;
use crate::preparation::primitive_range::RangeHeader;
use crate::preparation::reachable_space::ReachableSpaceHeader;
use crate::preparation::span::Span;
use crate::preparation::step_limits::StepLimits;
use crate::primitives::Gait;

/// The first bytes of every preparation.
const MAGIC: [u8; 8] = *b"surefoot";
/// Changes with the format and with the contents of a preparation.
const VERSION: u32 = 13;
/// Bytes of a word.
const WORD: usize = 8;

/// The header of a preparation.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Header {
    magic: [u8; 8],
    version: u32,
    padding: u32,
    /// The digest of the robot, the margins and the program's version.
    key: Digest,
    /// The digest of all bytes after this field.
    digest: Digest,
    /// Number of words of the preparation.
    words: u64,
    /// The contents.
    pub contents: Contents,
}

/// The contents of a preparation.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Contents {
    /// The reachable spaces, by limb.
    pub reach: [ReachableSpaceHeader; 2],
    /// The shape of the primitives.
    pub gait: Gait,
    /// The range of the primitives, by stance limb.
    pub ranges: [RangeHeader; 2],
    /// The volume that the primitives occupy.
    pub expanded: ExpandedGeometry,
    /// The step limits.
    pub step_limits: StepLimits,
}

const DIGEST_END: usize = 16 + 2 * size_of::<Digest>();
const _: () = assert!(
    size_of::<Header>().is_multiple_of(WORD) && std::mem::offset_of!(Header, words) == DIGEST_END
);

/// The key of a preparation: the digest of the robot, of the margins that it depends on, and of the
/// program's version.
pub fn key(model: &RobotModel, config: &PlannerConfig) -> Digest {
    let PlannerConfig {
        clearance,
        com_margin,
        effort_share,
        joint_margin,
        waypoint_joint_step,
        collision_step,
        ..
    } = config;
    let margins =
        [clearance, com_margin, effort_share, joint_margin, waypoint_joint_step, collision_step]
            .map(|value| value.to_le_bytes());
    let program = env!("CARGO_PKG_VERSION").as_bytes();
    Digest::of(&[&MAGIC, &VERSION.to_le_bytes(), program, &model.digest.0, margins.as_flattened()])
}

/// A preparation that is being written.
#[derive(Debug)]
pub(crate) struct Writer {
    words: Vec<u64>,
}

impl Default for Writer {
    /// A preparation with space for its header.
    fn default() -> Self {
        Self { words: vec![0; size_of::<Header>() / WORD] }
    }
}

impl Writer {
    /// Appends an array, padded to whole words, and returns its span.
    pub fn append<T: Pod>(&mut self, items: &[T]) -> Span {
        let first = self.words.len() as u64;
        let bytes: &[u8] = bytemuck::cast_slice(items);
        for word in bytes.chunks(WORD) {
            let mut whole = [0; WORD];
            whole[..word.len()].copy_from_slice(word);
            self.words.push(u64::from_ne_bytes(whole));
        }
        Span { first, len: self.words.len() as u64 - first }
    }

    /// The preparation with its header, digest included.
    pub fn finish(mut self, key: Digest, contents: Contents) -> Vec<u64> {
        let words = self.words.len() as u64;
        let header = Header {
            magic: MAGIC,
            version: VERSION,
            padding: 0,
            key,
            digest: Digest::default(),
            words,
            contents,
        };
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut self.words);
        bytes[..size_of::<Header>()].copy_from_slice(bytemuck::bytes_of(&header));
        let digest = Digest::of(&[&bytes[DIGEST_END..]]);
        bytes[DIGEST_END - size_of::<Digest>()..DIGEST_END].copy_from_slice(&digest.0);
        self.words
    }
}

/// The header of a sound preparation that was made from `key`.
///
/// # Errors
/// The fault of the words.
pub(crate) fn header<'a>(words: &'a [u64], key: &Digest) -> Result<&'a Header, PreparationError> {
    let bytes: &[u8] = bytemuck::cast_slice(words);
    let head = bytes.get(..size_of::<Header>()).ok_or(PreparationError::Damaged)?;
    let header: &Header = bytemuck::from_bytes(head);
    if (header.magic, header.version) != (MAGIC, VERSION) {
        return Err(PreparationError::Foreign);
    }
    if header.words != words.len() as u64 || header.digest != Digest::of(&[&bytes[DIGEST_END..]]) {
        return Err(PreparationError::Damaged);
    }
    if header.key != *key {
        return Err(PreparationError::OtherRobot);
    }
    Ok(header)
}
