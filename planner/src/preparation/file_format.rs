//! The format of a preparation: a header and arrays of plain data behind it, in units of eight
//! bytes, to be read in place.
//!
//! ```text
//! Header   magic, version, key (what it was made from), digest of the rest, and where the arrays are
//! arrays   each a whole number of words
//! ```

use bytemuck::{Pod, Zeroable};
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::RobotModel;

use crate::preparation::expanded_geometry::ExpandedGeometry;
use crate::preparation::primitive_range::RangeHeader;
use crate::preparation::reachable_space::ReachableSpaceHeader;
use crate::preparation::step_limits::StepLimits;
use crate::primitives::Gait;

/// The first bytes of every preparation.
const MAGIC: [u8; 8] = *b"surefoot";
/// Changes with the format and with whatever a preparation holds.
const VERSION: u32 = 9;
/// Bytes of a word.
const WORD: usize = 8;

/// An array of a file: where its first word is, counted from the file's begin, and how many words
/// it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Span {
    /// The first word.
    pub first: u64,
    /// Words.
    pub len: u64,
}

/// What a file begins with.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct Header {
    magic: [u8; 8],
    version: u32,
    padding: u32,
    /// What the file was made from.
    pub key: Digest,
    /// The digest of everything behind `digest`.
    digest: Digest,
    /// Words of the file.
    words: u64,
    /// What the arrays are.
    pub contents: Contents,
}

/// What a file holds.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct Contents {
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

/// Bytes that are no preparation, or not the expected one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PreparationError {
    /// No preparation at all, or one of another version.
    #[error("is no preparation of this version of surefoot; prepare the robot again")]
    Foreign,
    /// Made for another robot or other margins.
    #[error("was prepared for another robot or with other margins; prepare the robot again")]
    OtherRobot,
    /// Cut short, or changed since it was written.
    #[error("is damaged; prepare the robot again")]
    Damaged,
    /// Not at an address that is a multiple of eight.
    #[error("the bytes of a preparation must begin at a multiple of eight")]
    Misaligned,
}

/// What a preparation is made from: the robot, the margins that count, and the version of the
/// program.
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

/// A file that is being put together.
#[derive(Debug)]
pub struct Writer {
    words: Vec<u64>,
}

impl Default for Writer {
    /// A file with space for its header.
    fn default() -> Self {
        Self { words: vec![0; size_of::<Header>() / WORD] }
    }
}

impl Writer {
    /// Appends an array.
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

    /// The file with its header, digest included.
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

/// The header of a sound file that was made from `key`.
///
/// # Errors
/// What is wrong with the bytes.
pub fn header<'a>(bytes: &'a [u8], key: &Digest) -> Result<&'a Header, PreparationError> {
    if bytes.as_ptr().align_offset(WORD) != 0 {
        return Err(PreparationError::Misaligned);
    }
    let Some(head) = bytes.get(..size_of::<Header>()) else {
        return Err(PreparationError::Damaged);
    };
    let header: &Header =
        bytemuck::try_from_bytes(head).map_err(|_| PreparationError::Misaligned)?;
    if (header.magic, header.version) != (MAGIC, VERSION) {
        return Err(PreparationError::Foreign);
    }
    if header.words.checked_mul(WORD as u64) != Some(bytes.len() as u64)
        || header.digest != Digest::of(&[&bytes[DIGEST_END..]])
    {
        return Err(PreparationError::Damaged);
    }
    if header.key != *key {
        return Err(PreparationError::OtherRobot);
    }
    Ok(header)
}

/// An array of a file.
///
/// # Errors
/// The array does not lie in the file, or does not hold whole items.
pub fn array<T: Pod>(bytes: &[u8], span: Span) -> Result<&[T], PreparationError> {
    let first = usize::try_from(span.first).ok().and_then(|first| first.checked_mul(WORD));
    let len = usize::try_from(span.len).ok().and_then(|len| len.checked_mul(WORD));
    let range = first.zip(len).and_then(|(first, len)| Some(first..first.checked_add(len)?));
    let part = range.and_then(|range| bytes.get(range)).ok_or(PreparationError::Damaged)?;
    bytemuck::try_cast_slice(part).map_err(|_| PreparationError::Damaged)
}
