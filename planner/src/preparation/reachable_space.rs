//! The reachable space R of each leg [Grey 4.2.1], read in place: where its sole may be relative to
//! the root, with any rotation. An outer bound, so that nothing reachable is left out.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, UVec3};

use crate::geometry::bvh::Aabb;
use crate::geometry::voxel_grid::VoxelGrid;
use crate::preparation::file_format::Span;

/// Cubes along a side of a block.
const BLOCK: u32 = 8;

/// Where a leg's reachable space is in a file, and its grid.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct ReachableSpaceHeader {
    /// The grid's lowest corner in the root's frame, m.
    pub origin: [f64; 3],
    /// The side of a cube, m.
    pub side: f64,
    /// Cubes along each axis.
    pub dims: [u32; 3],
    /// Zero.
    pub padding: u32,
    /// The bits, x fastest.
    pub bits: Span,
    /// The blocks.
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
#[derive(Debug, Clone, Copy)]
pub struct ReachableSpace<'a> {
    origin: DVec3,
    cubes_per_metre: f64,
    dims: UVec3,
    words: &'a [u64],
    blocks: &'a [Block],
}

impl<'a> ReachableSpace<'a> {
    /// The reachable space with this header; `None` where header, bits and blocks do not fit
    /// together.
    pub fn new(
        header: &ReachableSpaceHeader,
        words: &'a [u64],
        blocks: &'a [Block],
    ) -> Option<Self> {
        let cubes = header
            .dims
            .iter()
            .try_fold(1u64, |product, &count| product.checked_mul(u64::from(count)))?;
        let origin = DVec3::from(header.origin);
        let is_sound = origin.is_finite()
            && header.side.is_finite()
            && header.side > 0.0
            && cubes.div_ceil(64) == words.len() as u64;
        let are_boxes = blocks.iter().all(|block| {
            DVec3::from(block.center).is_finite()
                && DVec3::from(block.half_extents).is_finite()
                && block.half_extents.iter().all(|&half| half > 0.0)
        });
        let reach = Self {
            origin,
            cubes_per_metre: 1.0 / header.side,
            dims: header.dims.into(),
            words,
            blocks,
        };
        (is_sound && are_boxes).then_some(reach)
    }

    /// Whether the sole may be at a place in the root's frame. `false` is certain.
    pub fn may_reach(&self, root_from_sole: DVec3) -> bool {
        let at = (root_from_sole - self.origin) * self.cubes_per_metre;
        if !(at.cmpge(DVec3::ZERO).all() && at.cmplt(self.dims.as_dvec3()).all()) {
            return false;
        }
        let cube = at.as_uvec3();
        let index = cube.x as usize
            + self.dims.x as usize * (cube.y as usize + self.dims.y as usize * cube.z as usize);
        self.words[index / 64] >> (index % 64) & 1 == 1
    }

    /// Boxes of the root's frame that cover the reachable space, those nearest to the standing
    /// posture's sole first.
    pub fn blocks(&self) -> &'a [Block] {
        self.blocks
    }

    /// Cubes that may be reached.
    pub fn cubes(&self) -> u64 {
        self.words.iter().map(|word| u64::from(word.count_ones())).sum()
    }

    /// The volume of the outer bound, m3.
    pub fn volume(&self) -> f64 {
        let side = 1.0 / self.cubes_per_metre;
        self.cubes() as f64 * side * side * side
    }
}

/// Tight boxes around the set cubes of each block of cubes, those nearest to `near` first.
pub fn blocks(cubes: &VoxelGrid, near: DVec3) -> Vec<Block> {
    let per_axis = cubes.dims.map(|count| count.div_ceil(BLOCK));
    let mut boxes = vec![Aabb::EMPTY; (per_axis.x * per_axis.y * per_axis.z) as usize];
    for cube in cubes.cubes() {
        let block = cube.as_uvec3() / BLOCK;
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
