//! The part of a declared sole that touches level ground: where the foot's collision shapes are in
//! the sole plane. The underside of a detailed foot rises toward its rim.

use glam::{DVec2, DVec3};
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;
use surefoot_shared_types::robot::model::{Foot, RobotModel};

use crate::geometry::polygon::{area_and_centroid, convex_hull, inner_distance, simplify};
use crate::geometry::tessellation::triangles_of;

/// Spacing of the places at which the underside is measured, m.
const SPACING: f64 = 1e-3;
/// Largest distance of the underside from the sole plane where it counts as flat, m.
const FLATNESS: f64 = 0.9e-3;
/// A surface farther above the sole plane is not the underside, m.
const HEIGHT_MAX: f64 = 0.04;
/// Distance that the flat part keeps from places where the underside is higher, m: a foot may land
/// as far beside its place.
const KEPT_FROM_HIGHER: f64 = 3.5e-3;
/// The least share of the declared sole that a flat part has. Without it the declared sole counts.
const FLAT_SHARE_MIN: f64 = 0.1;

/// Heights of a foot's underside over its sole plane, on a grid over the declared sole.
struct HeightMap {
    low: DVec2,
    columns: usize,
    rows: usize,
    /// Infinite where the foot is not, m.
    heights: Vec<f64>,
}

/// What of a foot's declared sole touches level ground, in the sole frame (m). All polygons are
/// convex and counter-clockwise.
#[derive(Debug, PartialEq)]
pub(crate) struct Underside {
    /// The hull of all that touches.
    pub(crate) flat_part: Vec<DVec2>,
    /// Its pads: one, or several, as studs or the heel and the ball of an arched foot. Empty if the
    /// whole declared sole touches.
    pub(crate) pads: Vec<Vec<DVec2>>,
}

impl Underside {
    /// The underside of a foot.
    pub(crate) fn of(model: &RobotModel, foot: &Foot) -> Self {
        HeightMap::of(model, foot).underside(&foot.polygon)
    }
}

impl HeightMap {
    fn of(model: &RobotModel, foot: &Foot) -> Self {
        let mut map = HeightMap::over(&foot.polygon);
        let sole_from_link = foot.link_from_sole.inverse();
        for link_shape in &model.links[foot.link].shapes {
            let sole_from_shape = sole_from_link * link_shape.link_from_shape;
            let (mut vertices, triangles) = triangles_of(&link_shape.shape);
            vertices.iter_mut().for_each(|vertex| *vertex = sole_from_shape * *vertex);
            for triangle in triangles {
                map.lower(triangle.map(|corner| vertices[corner as usize]));
            }
        }
        map
    }

    fn over(outline: &[DVec2]) -> Self {
        let low = outline.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = outline.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let cells = ((high - low) / SPACING).ceil();
        let (columns, rows) = (cells.x as usize + 1, cells.y as usize + 1);
        Self { low, columns, rows, heights: vec![f64::INFINITY; columns * rows] }
    }

    fn at(&self, column: usize, row: usize) -> DVec2 {
        self.low + SPACING * DVec2::new(column as f64, row as f64)
    }

    /// The columns and rows between two corners of a box, seen from above, as far as they exist.
    fn cells(&self, low: DVec2, high: DVec2) -> impl Iterator<Item = (usize, usize)> + use<> {
        let from = ((low - self.low) / SPACING).ceil().max(DVec2::ZERO);
        let to = ((high - self.low) / SPACING).floor() + 1.0;
        let end = |to: f64, count: usize| (to.max(0.0) as usize).min(count);
        let rows = from.y as usize..end(to.y, self.rows);
        (from.x as usize..end(to.x, self.columns))
            .flat_map(move |column| rows.clone().map(move |row| (column, row)))
    }

    /// Takes a triangle of the foot's surface.
    fn lower(&mut self, triangle: [DVec3; 3]) {
        let [a, b, c] = triangle;
        let normal = (b - a).cross(c - a);
        if a.min(b).min(c).z > HEIGHT_MAX || normal.z.abs() < 1e-3 * normal.length() {
            return;
        }
        let side = |from: DVec3, to: DVec3| {
            let along = (to - from).truncate();
            move |at: DVec2| normal.z.signum() * along.perp_dot(at - from.truncate())
        };
        let sides = (side(a, b), side(b, c), side(c, a));
        let (low, high) = (a.min(b).min(c).truncate(), a.max(b).max(c).truncate());
        for (column, row) in self.cells(low, high) {
            let at = self.at(column, row);
            let depth = sides.0(at).min(sides.1(at)).min(sides.2(at));
            if depth >= -ON_SIDE_MAX {
                let height = a.z - normal.truncate().dot(at - a.truncate()) / normal.z;
                let known = &mut self.heights[column * self.rows + row];
                *known = known.min(height);
            }
        }
    }

    fn height(&self, (column, row): (usize, usize)) -> f64 {
        self.heights[column * self.rows + row]
    }

    fn is_flat(&self, cell: (usize, usize)) -> bool {
        self.height(cell).abs() <= FLATNESS
    }

    fn underside(&self, outline: &[DVec2]) -> Underside {
        let whole = || Underside { flat_part: outline.to_vec(), pads: Vec::new() };
        let is_on_sole =
            |&(column, row): &(usize, usize)| inner_distance(outline, self.at(column, row)) >= 0.0;
        let all = self.cells(self.low, self.at(self.columns, self.rows));
        let on_sole: Vec<(usize, usize)> = all.filter(is_on_sole).collect();
        if on_sole.iter().all(|&cell| self.is_flat(cell)) {
            return whole();
        }
        let is_higher = |&cell: &(usize, usize)| {
            !self.is_flat(cell) && self.height(cell) <= HEIGHT_MAX && is_on_sole(&cell)
        };
        let is_kept = |&(column, row): &(usize, usize)| {
            let at = self.at(column, row);
            let mut near = self.cells(at - KEPT_FROM_HIGHER, at + KEPT_FROM_HIGHER);
            !near.any(|cell| {
                is_higher(&cell) && self.at(cell.0, cell.1).distance(at) <= KEPT_FROM_HIGHER
            })
        };
        let kept: Vec<(usize, usize)> =
            on_sole.into_iter().filter(|&cell| self.is_flat(cell)).filter(is_kept).collect();
        let flat_part = self.hull(&kept);
        let least = FLAT_SHARE_MIN * area_and_centroid(outline).0;
        if flat_part.len() < 3 || area_and_centroid(&flat_part).0 < least {
            return whole();
        }
        let parts = self.connected_parts(&kept);
        let pads = parts.iter().map(|part| self.hull(part)).filter(|pad| pad.len() >= 3).collect();
        Underside { flat_part, pads }
    }

    /// The convex hull of cells.
    fn hull(&self, cells: &[(usize, usize)]) -> Vec<DVec2> {
        let mut points: Vec<DVec2> =
            cells.iter().map(|&(column, row)| self.at(column, row)).collect();
        let mut hull = Vec::new();
        convex_hull(&mut points, &mut hull);
        simplify(&mut hull, POLYGON_VERTICES_MAX);
        hull
    }

    /// The parts of a set of cells whose cells are neighbours, sides and corners alike.
    fn connected_parts(&self, cells: &[(usize, usize)]) -> Vec<Vec<(usize, usize)>> {
        let index = |(column, row): (usize, usize)| column * self.rows + row;
        let mut is_left = vec![false; self.heights.len()];
        cells.iter().for_each(|&cell| is_left[index(cell)] = true);
        let mut parts = Vec::new();
        for &first in cells {
            if !std::mem::take(&mut is_left[index(first)]) {
                continue;
            }
            let mut part = vec![first];
            let mut next = 0;
            while let Some(&(column, row)) = part.get(next) {
                next += 1;
                let columns = column.saturating_sub(1)..(column + 2).min(self.columns);
                let around = columns.flat_map(|column| {
                    (row.saturating_sub(1)..(row + 2).min(self.rows)).map(move |row| (column, row))
                });
                part.extend(around.filter(|&cell| std::mem::take(&mut is_left[index(cell)])));
            }
            parts.push(part);
        }
        parts
    }
}

/// Twice the area (m2) of a triangle on a side up to which a place lies on the side.
const ON_SIDE_MAX: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use surefoot_shared_types::Shape;
    use surefoot_shared_types::robot::model::LinkShape;

    const OUTLINE: [(f64, f64); 4] = [(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)];

    fn flat_part_of(underside: &[(f64, f64, f64)]) -> Vec<DVec2> {
        let outline = OUTLINE.map(DVec2::from);
        let mut map = HeightMap::over(&outline);
        for pair in underside.windows(2) {
            let corner = |(x, _, z): (f64, f64, f64), y: f64| DVec3::new(x, y, z);
            let [a, b] = [pair[0], pair[1]];
            map.lower([corner(a, -0.06), corner(b, -0.06), corner(b, 0.06)]);
            map.lower([corner(a, -0.06), corner(b, 0.06), corner(a, 0.06)]);
        }
        map.underside(&outline).flat_part
    }

    fn extent(part: &[DVec2]) -> [f64; 2] {
        part.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
            [low.min(at.x), high.max(at.x)]
        })
    }

    #[test]
    fn a_flat_foot_touches_with_the_whole_sole() {
        let whole = flat_part_of(&[(-0.12, 0.0, 5e-4), (0.12, 0.0, -5e-4)]);
        assert_eq!(whole, OUTLINE.map(DVec2::from));
    }

    #[test]
    fn a_toe_that_rises_does_not_touch() {
        // It rises by 1 in 10 from x = 0.04, and is 0.9 mm high at x = 0.049.
        let part = flat_part_of(&[(-0.12, 0.0, 0.0), (0.04, 0.0, 0.0), (0.12, 0.0, 8e-3)]);
        let [low, high] = extent(&part);
        assert!((low + 0.1).abs() < 1e-9, "{low}");
        assert!((high - (0.049 - KEPT_FROM_HIGHER)).abs() < 1.5e-3, "{high}");
    }

    #[test]
    fn a_foot_without_a_flat_part_keeps_the_declared_sole() {
        let round = flat_part_of(&[(-0.12, 0.0, 0.02), (0.0, 0.0, 2e-3), (0.12, 0.0, 0.02)]);
        assert_eq!(round, OUTLINE.map(DVec2::from));
    }

    #[test]
    fn a_hubo_stands_on_its_whole_sole_and_on_less_with_a_smaller_foot() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../configs/robots/hubo/robot.toml");
        let Ok(mut model) = surefoot_shared_types::robot::load::load_robot(&path) else {
            panic!("{} does not load", path.display());
        };
        let foot = model.feet[0].clone();
        assert_eq!(Underside::of(&model, &foot).flat_part, foot.polygon);
        let half = DVec3::new(0.05, 0.04, 0.01);
        let link_from_shape =
            foot.link_from_sole * surefoot_shared_types::Pose::from_translation(DVec3::Z * half.z);
        let shape = LinkShape { shape: Shape::Box { half_extents: half }, link_from_shape };
        model.links[foot.link].shapes = vec![shape];
        let [low, high] = extent(&Underside::of(&model, &foot).flat_part);
        assert!((low + 0.05).abs() < 2e-3 && (high - 0.05).abs() < 2e-3, "{low} {high}");
    }
}
