//! A static bounding volume hierarchy in depth-first order with skip links: queries need neither a
//! stack nor heap memory.

use glam::{DMat3, DVec3};

use crate::geometry::distance::exceeds;

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Lowest corner, m.
    pub min: DVec3,
    /// Highest corner, m.
    pub max: DVec3,
}

impl Aabb {
    /// The empty box.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The bounding box of points.
    pub fn of_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points
            .into_iter()
            .fold(Self::EMPTY, |all, p| Self { min: all.min.min(p), max: all.max.max(p) })
    }

    /// The bounding box of two boxes.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// This box extended by `margin` (m) on every side.
    pub fn grown(self, margin: f64) -> Self {
        Self { min: self.min - DVec3::splat(margin), max: self.max + DVec3::splat(margin) }
    }

    /// The bounding box of this box after a rotation and a translation.
    pub fn transformed(self, rotation: &DMat3, translation: DVec3) -> Self {
        let center = *rotation * self.center() + translation;
        let half = self.half_extents();
        let reach = rotation.x_axis.abs() * half.x
            + rotation.y_axis.abs() * half.y
            + rotation.z_axis.abs() * half.z;
        Self { min: center - reach, max: center + reach }
    }

    /// The centre.
    pub fn center(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// Half of each side.
    pub fn half_extents(&self) -> DVec3 {
        0.5 * (self.max - self.min)
    }

    /// Whether the boxes overlap; `true` if a number is NaN.
    pub fn overlaps(&self, other: &Self) -> bool {
        !(self.min.cmpgt(other.max).any() || other.min.cmpgt(self.max).any())
    }

    /// Whether the box comes within `reach` (m) of a point; `true` if a number is NaN.
    pub fn reaches(&self, point: DVec3, reach: f64) -> bool {
        let distance = (self.min - point).max(point - self.max).max(DVec3::ZERO);
        // A maximum drops NaN; the sum keeps it.
        !exceeds(distance.length_squared() + 0.0 * point.element_sum(), reach * reach)
    }

    /// Whether the point lies in the box.
    pub fn contains(&self, point: DVec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }
}

/// The hierarchy.
#[derive(Debug, Clone)]
pub struct Bvh {
    nodes: Vec<Node>,
    items: Vec<u32>,
}

/// A node. Children follow their parent; `skip` is the node after the subtree. An inner node has no
/// items.
#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Aabb,
    skip: u32,
    first: u32,
    count: u32,
}

impl Bvh {
    /// The hierarchy of the boxes `bounds`, with at most `leaf_max` items per leaf. Items are
    /// indices into `bounds`.
    pub fn new(bounds: &[Aabb], leaf_max: usize) -> Self {
        let mut items: Vec<u32> = (0..bounds.len() as u32).collect();
        let mut nodes = Vec::with_capacity(2 * bounds.len().div_ceil(leaf_max.max(1)));
        if !items.is_empty() {
            build(&mut nodes, &mut items, 0, bounds, leaf_max.max(1));
        }
        Self { nodes, items }
    }

    /// The first item, in the fixed order of the tree, that `accept` accepts. Only nodes whose
    /// boxes `enter` accepts are visited.
    pub fn find(
        &self,
        enter: impl Fn(&Aabb) -> bool,
        mut accept: impl FnMut(usize) -> bool,
    ) -> Option<usize> {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if !enter(&node.bounds) {
                at = node.skip as usize;
                continue;
            }
            if node.count > 0 {
                let range = node.first as usize..(node.first + node.count) as usize;
                if let Some(&item) = self.items[range].iter().find(|&&item| accept(item as usize)) {
                    return Some(item as usize);
                }
            }
            at += 1;
        }
        None
    }

    /// Heap memory, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.items.as_slice())
    }
}

fn build(nodes: &mut Vec<Node>, items: &mut [u32], first: u32, bounds: &[Aabb], leaf_max: usize) {
    let around = items.iter().fold(Aabb::EMPTY, |all, &item| all.union(bounds[item as usize]));
    let index = nodes.len();
    let is_leaf = items.len() <= leaf_max;
    nodes.push(Node {
        bounds: around,
        skip: 0,
        first,
        count: if is_leaf { items.len() as u32 } else { 0 },
    });
    if !is_leaf {
        let half = items.len() / 2;
        split_by_centers(items, half, bounds);
        let (left, right) = items.split_at_mut(half);
        build(nodes, left, first, bounds, leaf_max);
        build(nodes, right, first + half as u32, bounds, leaf_max);
    }
    nodes[index].skip = nodes.len() as u32;
}

/// Moves the items with the lower centres along the longest side to the front.
fn split_by_centers(items: &mut [u32], half: usize, bounds: &[Aabb]) {
    let centers = Aabb::of_points(items.iter().map(|&item| bounds[item as usize].center()));
    let side = centers.max - centers.min;
    let axis = side.max_position();
    let key = |item: u32| bounds[item as usize].center()[axis];
    items.select_nth_unstable_by(half, |&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
}
