//! The preparation of a robot: checked once, then read in place.

use std::sync::Arc;

use glam::DVec3;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::RobotModel;

use crate::preparation::error::PreparationError;
use crate::preparation::expanded_geometry::ExpandedGeometry;
use crate::preparation::file_format::{Contents, header, key};
use crate::preparation::primitive_range::PairRange;
use crate::preparation::reachable_space::ReachableSpace;
use crate::preparation::step_limits::StepLimits;
use crate::primitives::Gait;

/// The preparation of a robot. A clone shares the data.
#[derive(Debug, Clone)]
pub struct Preparation(Arc<Data>);

#[derive(Debug)]
struct Data {
    words: Arc<[u64]>,
    key: Digest,
    contents: Contents,
    reach: [ReachableSpace; 2],
    ranges: [PairRange; 2],
}

impl Preparation {
    /// The preparation that was made from `key`, from its words. All of them are checked here.
    ///
    /// # Errors
    /// The words are not that preparation, or damaged.
    pub fn from_words(
        words: impl Into<Arc<[u64]>>,
        key: &Digest,
    ) -> Result<Self, PreparationError> {
        let words = words.into();
        let contents = header(&words, key)?.contents;
        if !contents.gait.is_sound() || !contents.step_limits.is_sound() {
            return Err(PreparationError::Damaged);
        }
        let reach = |limb: usize| ReachableSpace::new(&contents.reach[limb], &words);
        let range = |limb: usize| PairRange::new(&contents.ranges[limb], &words);
        let (reach, ranges) = ([reach(0)?, reach(1)?], [range(0)?, range(1)?]);
        Ok(Self(Arc::new(Data { words, key: *key, contents, reach, ranges })))
    }

    /// The preparation that was made from `key`, from its bytes, which are copied.
    ///
    /// # Errors
    /// As [`Preparation::from_words`].
    pub fn from_bytes(bytes: &[u8], key: &Digest) -> Result<Self, PreparationError> {
        let (words, rest) = bytes.as_chunks::<8>();
        if !rest.is_empty() {
            return Err(PreparationError::Damaged);
        }
        Self::from_words(words.iter().copied().map(u64::from_ne_bytes).collect::<Arc<_>>(), key)
    }

    /// All bytes, as [`Preparation::from_bytes`] reads them.
    pub fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.0.words)
    }

    /// Whether this was made for a robot and the margins of a configuration.
    pub fn is_for(&self, model: &RobotModel, config: &PlannerConfig) -> bool {
        self.0.key == key(model, config)
    }

    /// Whether a leg may place its sole at a position in the root's frame (m), with any rotation.
    /// `false` is certain.
    pub fn may_reach(&self, limb: usize, root_from_sole: DVec3) -> bool {
        self.0.reach[limb].may_reach(root_from_sole)
    }

    /// The reachable space R of a leg.
    pub fn reach(&self, limb: usize) -> &ReachableSpace {
        &self.0.reach[limb]
    }

    /// The parameters of the primitives.
    pub fn gait(&self) -> &Gait {
        &self.0.contents.gait
    }

    /// The range R_S of the primitives over the stance foot `stance`.
    pub fn range(&self, stance: usize) -> &PairRange {
        &self.0.ranges[stance]
    }

    /// The step limits.
    pub fn step_limits(&self) -> &StepLimits {
        &self.0.contents.step_limits
    }

    /// The volume that the primitives occupy.
    pub fn expanded(&self) -> &ExpandedGeometry {
        &self.0.contents.expanded
    }
}
