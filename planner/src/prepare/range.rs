//! R_S: the range of placement pairs over which every primitive was swept [Grey 4.4.5], read in place.

use bytemuck::{Pod, Zeroable};

use super::file::Span;
use crate::motion::primitive::stand::PairOffset;

/// A lattice over ahead, aside, above and turn, and where the bits of its cells are in a file.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct RangeHeader {
    /// The lowest vertex, m and rad.
    pub origin: [f64; 4],
    /// The side of a cell, m and rad.
    pub step: [f64; 4],
    /// Cells along each axis.
    pub cells: [u32; 4],
    /// A bit for each cell, ahead fastest.
    pub bits: Span,
}

/// The pairs with one foot as stance.
#[derive(Debug, Clone, Copy)]
pub struct PairRange<'a> {
    header: &'a RangeHeader,
    words: &'a [u64],
}

impl<'a> PairRange<'a> {
    /// The range with this header; `None` where header and bits do not fit together.
    pub fn new(header: &'a RangeHeader, words: &'a [u64]) -> Option<Self> {
        let cells = header.cells.iter().try_fold(1u64, |product, &count| product.checked_mul(u64::from(count)))?;
        let is_sound = header.origin.iter().all(|at| at.is_finite()) && header.step.iter().all(|&step| step.is_finite() && step > 0.0);
        (is_sound && cells.div_ceil(64) == words.len() as u64).then_some(Self { header, words })
    }

    /// Whether all primitives of a pair are known to hold.
    pub fn contains(&self, offset: &PairOffset) -> bool {
        let RangeHeader { origin, step, cells, .. } = self.header;
        let mut index = 0;
        for axis in (0..4).rev() {
            let at = (coordinates(offset)[axis] - origin[axis]) / step[axis];
            if !(at >= 0.0 && at < f64::from(cells[axis])) {
                return false;
            }
            index = index * cells[axis] as usize + at as usize;
        }
        self.words[index / 64] >> (index % 64) & 1 == 1
    }

    /// How many cells hold, and how many there are.
    pub fn cells(&self) -> (u64, u64) {
        let held = self.words.iter().map(|word| u64::from(word.count_ones())).sum();
        (held, self.header.cells.iter().map(|&count| u64::from(count)).product())
    }

    /// The least and the greatest of ahead, aside, above and turn over all cells that hold; `None` where none does.
    pub fn extent(&self) -> Option<[[f64; 2]; 4]> {
        let RangeHeader { origin, step, cells, .. } = self.header;
        let mut extent = [[f64::INFINITY, f64::NEG_INFINITY]; 4];
        let total = self.cells().1 as usize;
        for index in (0..total).filter(|index| self.words[index / 64] >> (index % 64) & 1 == 1) {
            let mut rest = index;
            for axis in 0..4 {
                let at = (rest % cells[axis] as usize) as f64;
                rest /= cells[axis] as usize;
                let [least, greatest] = &mut extent[axis];
                *least = least.min(origin[axis] + at * step[axis]);
                *greatest = greatest.max(origin[axis] + (at + 1.0) * step[axis]);
            }
        }
        (extent[0][0] < extent[0][1]).then_some(extent)
    }
}

/// A lattice whose vertices are visited one after another.
#[derive(Debug, Clone, Copy)]
pub struct Lattice {
    /// The lowest vertex, m and rad.
    pub origin: [f64; 4],
    /// The side of a cell, m and rad.
    pub step: [f64; 4],
    /// Cells along each axis.
    pub cells: [u32; 4],
}

impl Lattice {
    /// The lattice of a leg that reaches `reach` (m).
    pub fn new(reach: f64) -> Self {
        let step = [reach / 16.0, reach / 16.0, reach / 16.0, 0.1];
        let cells = [14, 8, 6, 6];
        let origin = [-7.0 * step[0], 2.0 * step[1], -3.0 * step[2], -3.0 * step[3]];
        Self { origin, step, cells }
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> usize {
        self.cells.iter().map(|&count| count as usize + 1).product()
    }

    /// A vertex.
    pub fn vertex(&self, index: usize) -> PairOffset {
        let steps = self.steps(index);
        let [ahead, aside, above, turn] = std::array::from_fn(|axis| self.origin[axis] + steps[axis] as f64 * self.step[axis]);
        PairOffset { ahead, aside, above, turn }
    }

    /// Whether all coordinates of a vertex are even, counted from the lowest.
    pub fn is_coarse(&self, index: usize) -> bool {
        self.steps(index).iter().all(|at| at % 2 == 0)
    }

    /// Whether the sum of a vertex's coordinates is odd, counted from the lowest: half of the vertices of every cell.
    pub fn is_odd(&self, index: usize) -> bool {
        self.steps(index).iter().sum::<usize>() % 2 == 1
    }

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
        let strides = [1, along[0] + 1, (along[0] + 1) * (along[1] + 1), (along[0] + 1) * (along[1] + 1) * (along[2] + 1)];
        let total: usize = along.iter().product();
        let mut words = vec![0u64; total.div_ceil(64)];
        for cell in 0..total {
            let mut rest = cell;
            let mut vertex = 0;
            for axis in 0..4 {
                vertex += rest % along[axis] * strides[axis];
                rest /= along[axis];
            }
            let corner = |corner: usize| vertex + (0..4).map(|axis| (corner >> axis & 1) * strides[axis]).sum::<usize>();
            if (0..16).all(|index| holds[corner(index)]) {
                words[cell / 64] |= 1 << (cell % 64);
            }
        }
        words
    }
}

fn coordinates(offset: &PairOffset) -> [f64; 4] {
    [offset.ahead, offset.aside, offset.above, offset.turn]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_holds_if_its_sixteen_vertices_do() {
        let lattice = Lattice::new(0.64);
        let inside = |offset: &PairOffset| offset.ahead < 0.21 && offset.turn > -0.25 && offset.aside < 0.35;
        let holds: Vec<bool> = (0..lattice.vertices()).map(|index| inside(&lattice.vertex(index))).collect();
        let words = lattice.cell_bits(&holds);
        let Lattice { origin, step, cells } = lattice;
        let header = RangeHeader { origin, step, cells, bits: Span { first: 0, len: words.len() as u64 } };
        let range = PairRange::new(&header, &words).unwrap();
        let at = |ahead: f64, turn: f64| PairOffset { ahead, aside: 0.2, above: 0.01, turn };
        assert!(range.contains(&at(0.19, -0.19)) && range.contains(&at(-0.27, 0.29)));
        assert!(!range.contains(&at(0.22, 0.0)) && !range.contains(&at(0.0, -0.21)) && !range.contains(&at(f64::NAN, 0.0)));
        let extent = range.extent().unwrap();
        assert!((extent[0][1] - 0.2).abs() < 1e-9 && (extent[3][0] + 0.2).abs() < 1e-9, "{extent:?}");
    }
}
