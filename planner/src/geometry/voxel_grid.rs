//! Dense grids of voxels with one bit each.

use glam::{DVec3, IVec3, UVec3};

use crate::geometry::bvh::Aabb;

/// A grid of cubes of one size with a bit each, x fastest.
#[derive(Debug, Clone)]
pub struct VoxelGrid {
    /// Lowest corner, m.
    pub origin: DVec3,
    /// Side of a cube, m.
    pub side: f64,
    /// Number of cubes along each axis.
    pub dims: UVec3,
    /// The bits, 64 cubes per word.
    pub words: Vec<u64>,
}

impl VoxelGrid {
    /// An empty grid that covers a box and at least one cube beyond it on each side. Its origin is
    /// a multiple of `side * align` and its dimensions are multiples of `align`, so that grids of
    /// different sides have common borders.
    pub fn around(bounds: &Aabb, side: f64, align: u32) -> Self {
        let block = side * f64::from(align);
        let low = ((bounds.min - DVec3::splat(side)) / block).floor();
        let high = ((bounds.max + DVec3::splat(side)) / block).ceil();
        let dims = (high - low).as_uvec3() * align;
        Self { origin: low * block, side, dims, words: vec![0; words_for(dims)] }
    }

    /// Coordinates of a point in units of cubes from the lowest corner.
    pub fn in_cubes(&self, point: DVec3) -> DVec3 {
        (point - self.origin) / self.side
    }

    /// Sets the cube that contains a point (in units of cubes); a point outside of the grid has no
    /// effect.
    pub fn set_at(&mut self, in_cubes: DVec3) {
        if let Some(index) = self.index_at(in_cubes) {
            self.words[index / 64] |= 1 << (index % 64);
        }
    }

    /// Whether the cube that contains a point (in units of cubes) is set; `false` outside of the
    /// grid.
    pub fn is_set_at(&self, in_cubes: DVec3) -> bool {
        self.index_at(in_cubes).is_some_and(|index| self.words[index / 64] >> (index % 64) & 1 == 1)
    }

    /// Sets a cube; one outside of the grid has no effect.
    pub fn set(&mut self, cube: IVec3) {
        self.set_at(cube.as_dvec3() + DVec3::splat(0.5));
    }

    /// The centre of a cube, m.
    pub fn center(&self, cube: IVec3) -> DVec3 {
        self.origin + (cube.as_dvec3() + DVec3::splat(0.5)) * self.side
    }

    /// The set cubes in order.
    pub fn cubes(&self) -> impl Iterator<Item = IVec3> + '_ {
        let (nx, ny) = (self.dims.x as usize, self.dims.y as usize);
        let bits = self.words.iter().enumerate().filter(|(_, word)| **word != 0);
        bits.flat_map(|(at, &word)| {
            (0..64).filter(move |bit| word >> bit & 1 == 1).map(move |bit| at * 64 + bit)
        })
        .map(move |index| {
            IVec3::new((index % nx) as i32, (index / nx % ny) as i32, (index / nx / ny) as i32)
        })
    }

    /// The grid of those set cubes of which one of the 26 neighbours is not set.
    pub fn border(&self) -> Self {
        let row = self.dims.x as usize;
        let inner = [1, row, row * self.dims.y as usize]
            .into_iter()
            .fold(self.words.clone(), |words, stride| between_set(&words, stride));
        let words = self.words.iter().zip(&inner).map(|(all, inner)| all & !inner).collect();
        Self { words, ..*self }
    }

    fn index_at(&self, in_cubes: DVec3) -> Option<usize> {
        let DVec3 { x, y, z } = in_cubes;
        let dims = self.dims;
        // Casts saturate, so a too large number is not below the dimension.
        let (i, j, k) = (x as u32, y as u32, z as u32);
        let inside = x >= 0.0 && y >= 0.0 && z >= 0.0 && i < dims.x && j < dims.y && k < dims.z;
        inside.then(|| i as usize + dims.x as usize * (j as usize + dims.y as usize * k as usize))
    }
}

/// The set bits with both bits `stride` before and after set. No cube at the border of a grid is
/// set, so that rows do not influence each other.
fn between_set(words: &[u64], stride: usize) -> Vec<u64> {
    let (skip, shift) = (stride / 64, stride % 64);
    let word =
        |index: Option<usize>| index.and_then(|index| words.get(index)).copied().unwrap_or(0);
    let joined =
        |low: u64, high: u64| if shift == 0 { low } else { low >> shift | high << (64 - shift) };
    let after = |at: usize| joined(word(at.checked_add(skip)), word(at.checked_add(skip + 1)));
    let before = |at: usize| {
        let (near, far) = (word(at.checked_sub(skip)), word(at.checked_sub(skip + 1)));
        if shift == 0 { near } else { near << shift | far >> (64 - shift) }
    };
    words.iter().enumerate().map(|(at, word)| word & after(at) & before(at)).collect()
}

/// Number of words for the bits of a grid.
pub fn words_for(dims: UVec3) -> usize {
    (dims.x as usize * dims.y as usize * dims.z as usize).div_ceil(64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> VoxelGrid {
        VoxelGrid::around(&Aabb { min: DVec3::splat(-0.1), max: DVec3::splat(0.25) }, 0.05, 4)
    }

    #[test]
    fn points_set_the_cubes_that_contain_them() {
        let mut grid = grid();
        grid.set_at(grid.in_cubes(DVec3::new(0.26, -0.12, 0.01)));
        let cubes: Vec<IVec3> = grid.cubes().collect();
        assert_eq!(cubes.len(), 1);
        assert!((grid.center(cubes[0]) - DVec3::new(0.275, -0.125, 0.025)).length() < 1e-12);
        assert!(
            grid.is_set_at(cubes[0].as_dvec3()) && grid.border().is_set_at(cubes[0].as_dvec3())
        );
    }

    #[test]
    fn points_outside_have_no_effect() {
        let mut grid = grid();
        [900.0, 1e300, -1e-9, f64::NAN].into_iter().for_each(|at| grid.set_at(DVec3::splat(at)));
        grid.set(IVec3::splat(-1));
        assert_eq!(grid.cubes().count(), 0);
    }

    #[test]
    fn an_inner_cube_is_not_in_the_border() {
        let mut grid = grid();
        (0..27).for_each(|i| grid.set(IVec3::new(2 + i % 3, 2 + i / 3 % 3, 2 + i / 9)));
        assert_eq!((grid.cubes().count(), grid.border().cubes().count()), (27, 26));
        assert!(!grid.border().is_set_at(DVec3::new(3.5, 3.5, 3.5)));
    }
}
