//! R_S: the range of placement pairs over which every primitive was swept [Grey 4.4.5], read in
//! place.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use crate::preparation::error::PreparationError;
use crate::preparation::span::{SharedArray, Span};
use crate::preparation::tuning::{RANGE_HEIGHTS, RANGE_TURNS};
use crate::primitives::level_sole::PairOffset;

/// Most vertices along an axis of a lattice.
const KNOTS_MAX: usize = 16;

/// A lattice over ahead, aside, above and turn.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct Lattice {
    /// Coordinates of its vertices along each axis, in rising order, m and rad: one more than there
    /// are cells, the rest 0.
    knots: [[f64; KNOTS_MAX]; 4],
    /// Cells along each axis.
    cells: [u32; 4],
}

/// A lattice, and the span of its cells' bits.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct RangeHeader {
    /// The lattice.
    pub lattice: Lattice,
    /// A bit for each cell, ahead fastest.
    pub bits: Span,
}

/// The range of placement pairs with one foot as stance.
#[derive(Debug, Clone)]
pub struct PairRange {
    lattice: Lattice,
    bits: SharedArray<u64>,
}

impl PairRange {
    /// The range with this header within the words of a preparation.
    ///
    /// # Errors
    /// Header and bits do not fit together.
    pub(crate) fn new(header: &RangeHeader, words: &Arc<[u64]>) -> Result<Self, PreparationError> {
        let bits = SharedArray::new(words, header.bits)?;
        let fits = header.lattice.is_sound()
            && header.lattice.cells_total().div_ceil(64) as u64 == header.bits.len;
        if fits {
            Ok(Self { lattice: header.lattice, bits })
        } else {
            Err(PreparationError::Damaged)
        }
    }

    /// Whether all primitives of a pair are known to hold.
    pub fn contains(&self, offset: &PairOffset) -> bool {
        self.lattice.cell_of(offset).is_some_and(|cell| self.bits.bit(cell))
    }

    /// The number of cells that hold, and of all cells.
    pub fn cells(&self) -> (u64, u64) {
        let held = self.bits.items().iter().map(|word| u64::from(word.count_ones())).sum();
        (held, self.lattice.cells_total() as u64)
    }

    /// The least and the greatest of ahead, aside, above (m) and turn (rad) over all cells that
    /// hold; `None` where no cell holds.
    pub fn extent(&self) -> Option<[[f64; 2]; 4]> {
        let Lattice { knots, cells } = &self.lattice;
        let mut extent = [[f64::INFINITY, f64::NEG_INFINITY]; 4];
        for cell in (0..self.lattice.cells_total()).filter(|&cell| self.bits.bit(cell)) {
            let mut rest = cell;
            for axis in 0..4 {
                let at = rest % cells[axis] as usize;
                rest /= cells[axis] as usize;
                let [least, greatest] = &mut extent[axis];
                *least = least.min(knots[axis][at]);
                *greatest = greatest.max(knots[axis][at + 1]);
            }
        }
        (extent[0][0] < extent[0][1]).then_some(extent)
    }
}

impl Lattice {
    /// The lattice of a leg that reaches `reach` (m).
    pub fn new(reach: f64) -> Self {
        let step = reach / 16.0;
        let mut lattice = Self { knots: [[0.0; KNOTS_MAX]; 4], cells: [14, 8, 5, 5] };
        for (index, knot) in lattice.knots[0][..15].iter_mut().enumerate() {
            *knot = (index as f64 - 7.0) * step;
        }
        for (index, knot) in lattice.knots[1][..9].iter_mut().enumerate() {
            *knot = (index as f64 + 2.0) * step;
        }
        lattice.knots[2][..6].copy_from_slice(&RANGE_HEIGHTS.map(|share| share * reach));
        lattice.knots[3][..6].copy_from_slice(&RANGE_TURNS);
        lattice
    }

    fn is_sound(&self) -> bool {
        self.cells.iter().zip(&self.knots).all(|(&cells, knots)| {
            let is_rising = |pair: &[f64]| pair[0] < pair[1];
            (1..KNOTS_MAX as u32).contains(&cells)
                && knots[..=cells as usize].windows(2).all(is_rising)
        })
    }

    fn cells_total(&self) -> usize {
        self.cells.iter().map(|&count| count as usize).product()
    }

    /// The cell that holds a pair.
    fn cell_of(&self, offset: &PairOffset) -> Option<usize> {
        let at = coordinates(offset);
        (0..4).rev().try_fold(0, |index, axis| {
            let cells = self.cells[axis] as usize;
            let knots = &self.knots[axis][..=cells];
            let along = knots.iter().take_while(|&&knot| knot <= at[axis]).count();
            (1..=cells).contains(&along).then(|| index * cells + along - 1)
        })
    }

    /// The number of vertices.
    pub fn vertices(&self) -> usize {
        self.cells.iter().map(|&count| count as usize + 1).product()
    }

    /// The pair at a vertex.
    pub fn vertex(&self, index: usize) -> PairOffset {
        let steps = self.steps(index);
        let [ahead, aside, above, turn] = std::array::from_fn(|axis| self.knots[axis][steps[axis]]);
        PairOffset { ahead, aside, above, turn }
    }

    /// Whether a vertex belongs to a coarser lattice, of twice the step.
    pub fn is_coarse(&self, index: usize) -> bool {
        let steps = self.steps(index);
        (0..4).all(|axis| steps[axis] % 2 == LEVEL[axis] % 2)
    }

    /// Whether a coarse vertex is one of the few that represent walking on a floor.
    pub fn is_level(&self, index: usize) -> bool {
        let steps = self.steps(index);
        self.is_coarse(index)
            && (2..4).all(|axis| steps[axis] == LEVEL[axis])
            && steps[0] % 4 == LEVEL[0] % 4
    }

    /// Whether the sum of a vertex's indices is odd: true for half of the vertices of every cell.
    pub fn is_odd(&self, index: usize) -> bool {
        self.steps(index).iter().sum::<usize>() % 2 == 1
    }

    /// The indices of a vertex along each axis.
    fn steps(&self, index: usize) -> [usize; 4] {
        let mut rest = index;
        self.cells.map(|cells| {
            let along = cells as usize + 1;
            let at = rest % along;
            rest /= along;
            at
        })
    }

    /// A bit for each cell whose sixteen vertices all hold.
    pub fn cell_bits(&self, holds: &[bool]) -> Vec<u64> {
        let along = self.cells.map(|count| count as usize);
        let strides = [
            1,
            along[0] + 1,
            (along[0] + 1) * (along[1] + 1),
            (along[0] + 1) * (along[1] + 1) * (along[2] + 1),
        ];
        let total: usize = along.iter().product();
        let mut words = vec![0u64; total.div_ceil(64)];
        for cell in 0..total {
            let mut rest = cell;
            let mut vertex = 0;
            for axis in 0..4 {
                vertex += rest % along[axis] * strides[axis];
                rest /= along[axis];
            }
            let corner = |corner: usize| {
                vertex + (0..4).map(|axis| (corner >> axis & 1) * strides[axis]).sum::<usize>()
            };
            if (0..16).all(|index| holds[corner(index)]) {
                words[cell / 64] |= 1 << (cell % 64);
            }
        }
        words
    }
}

/// The indices of a vertex that is a step ahead on a floor.
const LEVEL: [usize; 4] = [11, 2, 2, 3];

fn coordinates(offset: &PairOffset) -> [f64; 4] {
    [offset.ahead, offset.aside, offset.above, offset.turn]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_holds_if_its_sixteen_vertices_do() {
        let lattice = Lattice::new(0.64);
        let inside =
            |offset: &PairOffset| offset.ahead < 0.21 && offset.turn > -0.25 && offset.aside < 0.35;
        let holds: Vec<bool> =
            (0..lattice.vertices()).map(|index| inside(&lattice.vertex(index))).collect();
        let words = lattice.cell_bits(&holds);
        let header = RangeHeader { lattice, bits: Span { first: 0, len: words.len() as u64 } };
        let range = PairRange::new(&header, &words.into()).unwrap();
        let at = |ahead: f64, turn: f64| PairOffset { ahead, aside: 0.2, above: 0.01, turn };
        assert!(
            range.contains(&at(0.19, -0.14))
                && range.contains(&at(-0.27, 0.29))
                && range.contains(&at(0.0, 0.0))
        );
        assert!(
            !range.contains(&at(0.22, 0.0))
                && !range.contains(&at(0.0, -0.16))
                && !range.contains(&at(f64::NAN, 0.0))
        );
        let extent = range.extent().unwrap();
        assert!(
            (extent[0][1] - 0.2).abs() < 1e-9 && (extent[3][0] + 0.15).abs() < 1e-9,
            "{extent:?}"
        );
    }
}
