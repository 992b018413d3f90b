//! |F|: the area of the discs about the vertices of a route [Grey 5.7.1].

use std::f64::consts::PI;

use glam::DVec2;

/// The printed chain of bounds before equation 5.14 for a path of this length (m), balls of this
/// radius (m) and discs of this radius (m): L / epsilon pi rho^2, and 4 L pi rho, m^2. The second
/// is not the greater one: epsilon is at most rho / 4.
pub fn printed_area_bounds(length: f64, ball_radius: f64, disc_radius: f64) -> [f64; 2] {
    let first = length / ball_radius * PI * disc_radius * disc_radius;
    [first, 4.0 * length * PI * disc_radius]
}

/// The area of the tube about a route of this length (m), which covers the discs about all its
/// points, m^2: 2 rho L + pi rho^2.
pub fn tube_area(route_length: f64, disc_radius: f64) -> f64 {
    2.0 * disc_radius * route_length + PI * disc_radius * disc_radius
}

/// The area of the union of discs about some points, by the centres of square cells of this width
/// (m) that lie within: exact to about the width times the union's circumference, m^2.
pub fn union_area(centres: &[DVec2], disc_radius: f64, cell: f64) -> f64 {
    let empty = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let (min, max) =
        centres.iter().fold(empty, |(min, max), &centre| (min.min(centre), max.max(centre)));
    if centres.is_empty() {
        return 0.0;
    }
    let (min, max) = (min - DVec2::splat(disc_radius), max + DVec2::splat(disc_radius));
    let cells = |from: f64, to: f64| libm::ceil((to - from) / cell) as u64;
    let is_covered = |x: u64, y: u64| {
        let point = min + cell * DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        centres.iter().any(|centre| centre.distance_squared(point) <= disc_radius * disc_radius)
    };
    let (columns, rows) = (cells(min.x, max.x), cells(min.y, max.y));
    let covered = (0..columns).map(|x| (0..rows).filter(|&y| is_covered(x, y)).count() as u64);
    covered.sum::<u64>() as f64 * cell * cell
}
