//! The reachable space R of each leg [Grey 4.2.1], read in place: the positions of its sole
//! relative to the root, for any rotation. It is an outer bound: every reachable position is in it.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, UVec3};

use crate::geometry::bvh::Aabb;
use crate::geometry::voxel_grid::VoxelGrid;
use crate::preparation::error::PreparationError;
use crate::preparation::span::{SharedArray, Span};
use crate::preparation::tuning::BLOCK_CUBES;

/// The grid of a leg's reachable space, and the spans of its arrays.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct ReachableSpaceHeader {
    /// The grid's lowest corner in the root's frame, m.
    pub origin: [f64; 3],
    /// The side of a cube, m.
    pub side: f64,
    /// Cubes along each axis.
    pub dims: [u32; 3],
    /// Zero.
    pub padding: u32,
    /// A bit for each cube, x fastest.
    pub bits: Span,
    /// The [`Block`]s.
    pub blocks: Span,
}

/// A box of the root's frame around a part of a reachable space; all of them together cover it.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Block {
    /// The middle, m.
    pub center: [f64; 3],
    /// Half of each side, m.
    pub half_extents: [f64; 3],
}

/// The reachable space of one leg.
#[derive(Debug, Clone)]
pub struct ReachableSpace {
    origin: DVec3,
    cubes_per_metre: f64,
    dims: UVec3,
    bits: SharedArray<u64>,
    blocks: SharedArray<Block>,
}

impl ReachableSpace {
    /// The reachable space with this header within the words of a preparation.
    ///
    /// # Errors
    /// Header, bits and blocks do not fit together.
    pub(crate) fn new(
        header: &ReachableSpaceHeader,
        words: &Arc<[u64]>,
    ) -> Result<Self, PreparationError> {
        let space = Self {
            origin: DVec3::from(header.origin),
            cubes_per_metre: 1.0 / header.side,
            dims: header.dims.into(),
            bits: SharedArray::new(words, header.bits)?,
            blocks: SharedArray::new(words, header.blocks)?,
        };
        let cubes = header
            .dims
            .iter()
            .try_fold(1u64, |product, &count| product.checked_mul(u64::from(count)));
        let is_sound = space.origin.is_finite()
            && header.side.is_finite()
            && header.side > 0.0
            && cubes.is_some_and(|cubes| cubes.div_ceil(64) == header.bits.len);
        let are_boxes = space.blocks().iter().all(|block| {
            DVec3::from(block.center).is_finite()
                && DVec3::from(block.half_extents).is_finite()
                && block.half_extents.iter().all(|&half| half > 0.0)
        });
        if is_sound && are_boxes { Ok(space) } else { Err(PreparationError::Damaged) }
    }

    /// Whether the sole may be at a position in the root's frame (m), with any rotation. `false` is
    /// certain.
    pub fn may_reach(&self, root_from_sole: DVec3) -> bool {
        let at = (root_from_sole - self.origin) * self.cubes_per_metre;
        if !(at.cmpge(DVec3::ZERO).all() && at.cmplt(self.dims.as_dvec3()).all()) {
            return false;
        }
        let cube = at.as_uvec3();
        let index = cube.x as usize
            + self.dims.x as usize * (cube.y as usize + self.dims.y as usize * cube.z as usize);
        self.bits.bit(index)
    }

    /// Boxes of the root's frame that cover the reachable space, those nearest to the standing
    /// posture's sole first.
    pub fn blocks(&self) -> &[Block] {
        self.blocks.items()
    }

    /// Number of cubes that may be reached.
    pub fn cubes(&self) -> u64 {
        self.bits.items().iter().map(|word| u64::from(word.count_ones())).sum()
    }

    /// The volume of the outer bound, m3.
    pub fn volume(&self) -> f64 {
        let side = 1.0 / self.cubes_per_metre;
        self.cubes() as f64 * side * side * side
    }
}

/// Tight boxes around the set cubes of each block of cubes, those nearest to `near` (m) first.
pub(crate) fn blocks(cubes: &VoxelGrid, near: DVec3) -> Vec<Block> {
    let per_axis = cubes.dims.map(|count| count.div_ceil(BLOCK_CUBES));
    let mut boxes = vec![Aabb::EMPTY; (per_axis.x * per_axis.y * per_axis.z) as usize];
    for cube in cubes.cubes() {
        let block = cube.as_uvec3() / BLOCK_CUBES;
        let entry = &mut boxes[(block.x + per_axis.x * (block.y + per_axis.y * block.z)) as usize];
        let center = cubes.center(cube);
        *entry = entry.union(Aabb { min: center, max: center }.grown(0.5 * cubes.side));
    }
    boxes.retain(|bounds| bounds.min.x <= bounds.max.x);
    boxes.sort_by(|a, b| {
        a.center().distance_squared(near).total_cmp(&b.center().distance_squared(near))
    });
    boxes
        .iter()
        .map(|bounds| Block {
            center: bounds.center().into(),
            half_extents: bounds.half_extents().into(),
        })
        .collect()
}
