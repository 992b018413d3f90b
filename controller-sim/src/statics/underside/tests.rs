use super::*;
use crate::check_robot::{at, randoms, robot};
use surefoot_shared_types::Shape;
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::robot::model::LinkShape;

/// How far the foot may be beside its pose, m.
const REACH: f64 = 2.6e-3;

/// The left foot of the robot with these boxes as its shapes, in the frame of the sole: middle and
/// half of each side.
fn foot_of(boxes: &[(DVec3, DVec3)]) -> RobotModel {
    let mut model = robot();
    model.links[1].shapes = boxes
        .iter()
        .map(|(middle, half)| LinkShape {
            link_from_shape: at(0., 0., -0.9) * Pose::from_translation(*middle),
            shape: Shape::Box { half_extents: *half },
        })
        .collect();
    model
}

/// A block that covers the sole, this high over it.
fn block(height: f64) -> (DVec3, DVec3) {
    (DVec3::new(0.0, 0.0, height + 0.02), DVec3::new(0.1, 0.05, 0.02))
}

fn underside(model: &RobotModel) -> Underside {
    Underside::new(model, &model.feet[0], REACH).unwrap()
}

/// A sole with eight unequal sides.
fn octagon() -> Vec<DVec2> {
    (0..8).map(|k| DVec2::new(0.11, 0.06) * polygon::direction(k, 8)).collect()
}

#[test]
fn the_height_of_a_foot_is_that_of_its_lowest_shape() {
    let cases = [
        (0.0, 0.0),
        // Within the flatness of a sole it counts as flat.
        (0.9e-3, 0.0),
        (-0.9e-3, 0.0),
        (1.1e-3, 1.1e-3),
        (-1.1e-3, -1.1e-3),
        (0.0399, 0.0399),
        // Too high to stand on.
        (0.0401, f64::INFINITY),
        (-0.019, -0.019),
        // The ray begins inside.
        (-0.03, -0.02),
    ];
    for (height, expected) in cases {
        for boxes in [&[block(height)][..], &[block(height + 0.005), block(height)]] {
            let points = underside(&foot_of(boxes));
            for point in points.coarse.iter().chain(&points.edges) {
                assert!((point.height - expected).abs() < 1e-9, "{height}: {}", point.height);
            }
            let is_there = expected.is_finite();
            assert_eq!(points.edges.is_empty(), !is_there);
            assert_eq!(points.share_on_foot, f64::from(u8::from(expected == 0.0)));
            let below = points.depth_below_sole();
            let depth = if is_there { -expected } else { f64::NEG_INFINITY };
            assert!(below == depth || (below - depth).abs() < 1e-9, "{below} {depth}");
        }
    }
}

#[test]
fn a_lying_cylinder_is_the_foot_along_a_line_and_a_standing_one_with_its_end() {
    let mut model = foot_of(&[]);
    let along_x = Pose::from_parts(
        DVec3::new(0.0, 0.0, -0.88),
        rotation_about(DVec3::Y, std::f64::consts::FRAC_PI_2),
    );
    let lying = Shape::Cylinder { radius: 0.02, half_length: 0.1 };
    model.links[1].shapes = vec![LinkShape { link_from_shape: along_x, shape: lying }];
    for point in &underside(&model).coarse {
        let expected = 0.02 - (0.02_f64.powi(2) - point.at.y.powi(2)).sqrt();
        let expected = if expected <= ROUND_FLATNESS { 0.0 } else { expected };
        assert!((point.height - expected).abs() < 1e-9, "{point:?}");
    }
    let standing = Shape::Cylinder { radius: 0.12, half_length: 0.1 };
    let pose = at(0.0, 0.0, -0.8 + 0.9e-3);
    model.links[1].shapes = vec![LinkShape { link_from_shape: pose, shape: standing }];
    assert_eq!(underside(&model).share_on_foot, 1.0);
}

#[test]
fn the_share_on_the_foot_is_that_of_the_area() {
    let pad = |x: f64| (DVec3::new(x, 0.0, 0.02), DVec3::new(0.02, 0.05, 0.02));
    let (left, right) = (pad(-0.08), pad(0.08));
    let arch = (DVec3::new(0.0, 0.0, 0.03), DVec3::new(0.06, 0.05, 0.02));
    let points = underside(&foot_of(&[left, right, arch]));
    assert!((points.share_on_foot - 0.4).abs() < 0.03, "{}", points.share_on_foot);
    for point in &points.coarse {
        let expected = if point.at.x.abs() > 0.06 { 0.0 } else { 0.01 };
        assert!((point.height - expected).abs() < 1e-9, "{point:?}");
    }
    // Where the foot is not, nothing is kept.
    let points = underside(&foot_of(&[left, right]));
    assert!((points.share_on_foot - 0.4).abs() < 0.03, "{}", points.share_on_foot);
    assert!(points.coarse.iter().chain(&points.edges).all(|point| point.at.x.abs() >= 0.06));
}

#[test]
fn a_sole_has_a_sample_near_each_of_its_points() {
    let aside = [(0.31, 0.2), (0.35, 0.19), (0.4, 0.24), (0.33, 0.27)].map(DVec2::from).to_vec();
    for sole in [octagon(), robot().feet[0].polygon.clone(), aside] {
        let (coarse, edges) = (coarse_points(&sole), edge_points(&sole, SAMPLE_SPACING));
        let inside = |at: &DVec2| polygon::margin(&sole, *at);
        assert!(coarse.iter().all(|at| inside(at) >= EDGE_INSET));
        let expected = polygon::area(&sole) / (SAMPLE_SPACING * SAMPLE_SPACING);
        let count = coarse.len() as f64;
        assert!((0.9 * expected..1.1 * expected).contains(&count), "{count} {expected}");
        let near = |point: DVec2| {
            let all = coarse.iter().chain(&edges);
            all.map(|at| at.distance(point)).fold(f64::INFINITY, f64::min)
        };
        let mut random = randoms(1);
        for _ in 0..1_000 {
            let (low, high) = extent(&sole);
            let point = DVec2::new(random(low.x, high.x), random(low.y, high.y));
            if inside(&point) >= 0.0 {
                assert!(near(point) < 0.9 * SAMPLE_SPACING, "{point}: {}", near(point));
            }
        }
        // The edges' samples are evenly spaced on them, a corner first.
        for (a, b) in polygon::sides(&sole) {
            let on_side = edges.iter().filter(|at| {
                let across = (b - a).normalize().perp_dot(**at - a);
                across.abs() < 2e-5 && (**at - a).dot((b - a).normalize()) < (b - a).length() - 3e-5
            });
            let along: Vec<f64> = on_side
                .map(|at| (*at - a).dot((b - a).normalize()))
                .filter(|t| *t > -1e-4)
                .collect();
            assert_eq!(along.len() as f64, ((b - a).length() / SAMPLE_SPACING - 1e-9).ceil());
            assert!(along[0].abs() < 2e-5);
            let steps: Vec<f64> = along.windows(2).map(|pair| pair[1] - pair[0]).collect();
            assert!(steps.iter().all(|step| (step - steps[0]).abs() < 1e-9), "{steps:?}");
            assert!(steps.iter().all(|step| *step <= SAMPLE_SPACING), "{steps:?}");
        }
        assert!(edges.iter().all(|at| inside(at) > 0.0 && inside(at) < 2e-5));
    }
}

#[test]
fn no_bar_of_half_the_spacing_lies_between_the_samples() {
    let sole = robot().feet[0].polygon.clone();
    let coarse = coarse_points(&sole);
    let mut random = randoms(2);
    for _ in 0..500 {
        let (angle, middle) =
            (random(0.0, 3.15), DVec2::new(random(-0.06, 0.06), random(-0.02, 0.02)));
        let across = DVec2::new(-libm::sin(angle), libm::cos(angle));
        let is_on_bar = |at: &&DVec2| (**at - middle).dot(across).abs() < 0.25 * SAMPLE_SPACING;
        assert!(coarse.iter().filter(is_on_bar).count() >= 2, "{angle} {middle}");
    }
}

#[test]
fn neighbours_are_the_points_nearby() {
    let points = underside(&robot());
    let all: Vec<DVec2> = points.coarse.iter().chain(&points.edges).map(|point| point.at).collect();
    let neighbours = points.neighbours();
    assert_eq!(neighbours.len(), all.len());
    for (at, neighbours) in all.iter().zip(neighbours) {
        let expected: Vec<usize> = (0..all.len())
            .filter(|&other| all[other].distance(*at) <= NEIGHBOUR_DISTANCE)
            .collect();
        assert_eq!(neighbours, &expected);
    }
    let inner = points
        .coarse
        .iter()
        .zip(neighbours)
        .filter(|(point, _)| polygon::margin(&points.outline, point.at) > NEIGHBOUR_DISTANCE);
    assert!(inner.clone().count() > 200 && inner.clone().all(|(_, near)| near.len() >= 5));
}

/// The underside of a foot with a hole, whose sole is no rectangle.
fn underside_with_a_hole() -> Underside {
    let mut model = foot_of(&[
        (DVec3::new(-0.06, 0.0, 0.02), DVec3::new(0.05, 0.06, 0.02)),
        (DVec3::new(0.06, 0.0, 0.025), DVec3::new(0.05, 0.06, 0.02)),
    ]);
    model.feet[0].polygon = octagon();
    underside(&model)
}

/// Whether a grid point lies on the octagonal sole.
fn is_on_octagon(grid: &FineGrid, index: usize) -> bool {
    polygon::margin(&octagon(), grid.point(index).at) >= EDGE_INSET
}

#[test]
fn the_fine_grid_covers_the_sole() {
    let points = underside_with_a_hole();
    let grid = points.fine();
    let sole = octagon();
    for index in 0..grid.len() {
        let SolePoint { at, height } = grid.point(index);
        assert_eq!(grid.cell(at), (index / grid.height, index % grid.height));
        assert_eq!(grid.nearest(at + DVec2::new(3e-4, -4e-4)), index);
        let depth = polygon::margin(&sole, at);
        let is_beside = (-REACH - FINE_SAMPLE_SPACING..EDGE_INSET).contains(&depth);
        assert_eq!(grid.is_beside[index], is_beside);
        assert_eq!(grid.is_foot(index), height.is_finite() && !is_beside);
        let expected = match at.x {
            _ if is_beside => 0.0,
            _ if depth < EDGE_INSET => f64::NAN,
            x if (-0.11..=-0.01).contains(&x) => 0.0,
            x if (0.01..=0.11).contains(&x) => 0.005,
            _ => f64::INFINITY,
        };
        let is_between = (at.x.abs() - 0.01).abs() < 1e-9;
        assert!(
            is_between
                || height == expected
                || (height - expected).abs() < 1e-9
                || height.is_nan() && expected.is_nan(),
            "{at}: {height} {expected}"
        );
    }
    let count = (0..grid.len()).filter(|&index| is_on_octagon(grid, index)).count();
    let expected = polygon::area(&sole) / (FINE_SAMPLE_SPACING * FINE_SAMPLE_SPACING);
    assert!((count as f64 / expected - 1.0).abs() < 0.02, "{count} {expected}");
}

#[test]
fn the_fine_grid_finds_the_points_near_a_place() {
    let points = underside_with_a_hole();
    let grid = points.fine();
    let mut random = randoms(3);
    for _ in 0..200 {
        let at = DVec2::new(random(-0.13, 0.13), random(-0.08, 0.08));
        let near = |at: DVec2, radius: f64| {
            let is_near = move |index: &usize| grid.point(*index).at.distance(at) <= radius;
            (0..grid.len()).filter(is_near)
        };
        assert!(grid.within(at).eq(near(at, REACH)), "{at}");
        let index = grid.nearest(at);
        if !is_on_octagon(grid, index) {
            continue;
        }
        let at = grid.point(index).at;
        assert!(grid.within_point(index).eq(near(at, REACH)), "{at}");
        let beside = near(at, REACH + FINE_SAMPLE_SPACING);
        let beside = beside.filter(|&index| grid.is_beside[index]);
        assert!(grid.beside([index].into_iter()).into_iter().eq(beside), "{at}");
    }
}

#[test]
fn the_fine_grid_knows_the_steps_between_its_points() {
    let points = underside_with_a_hole();
    let grid = points.fine();
    // Of the points as near as 2.6 mm those at (2, 1), (1, 2) and so on are the outermost.
    let offsets = grid.outermost_offsets();
    assert_eq!(offsets.len(), 8);
    assert!(offsets.iter().all(|way| (way.length() - 5f64.sqrt() * 1e-3).abs() < 1e-12));
    for index in 0..grid.len() {
        let at = grid.point(index).at;
        let ways: Vec<DVec2> = grid.next(index).map(|next| grid.point(next).at - at).collect();
        let is_step = |way: &DVec2| {
            [DVec2::X, DVec2::Y].iter().any(|axis| (*way - 1e-3 * axis).length() < 1e-12)
        };
        assert!(ways.len() <= 2 && ways.iter().all(is_step), "{ways:?}");
    }
}

#[test]
fn the_fine_grid_finds_the_points_around_coarse_samples() {
    let points = underside_with_a_hole();
    let grid = points.fine();
    let is_there = |index: &usize| grid.point(*index).height.is_finite();
    let is_foot = |index: &usize| is_there(index) && is_on_octagon(grid, *index);
    // Half a coarse cell to each side, to the nearest point of the grid.
    let at = [DVec2::new(-0.0512, 0.0108), DVec2::new(0.0503, -0.0204), DVec2::new(0.0, 0.0)];
    let found = grid.around(at.into_iter(), 0.5 * SAMPLE_SPACING);
    let is_wanted = |index: &usize| {
        at.iter().any(|at| {
            let apart = (grid.point(*index).at - *at).abs().max_element();
            apart <= 0.5 * SAMPLE_SPACING - FINE_SAMPLE_SPACING
        })
    };
    let is_unwanted = |index: &usize| {
        at.iter().all(|at| {
            let apart = (grid.point(*index).at - *at).abs().max_element();
            apart > 0.5 * SAMPLE_SPACING + FINE_SAMPLE_SPACING
        })
    };
    assert!(found.is_sorted() && found.iter().all(is_foot) && !found.iter().any(is_unwanted));
    assert!((0..grid.len()).filter(is_foot).filter(is_wanted).all(|index| found.contains(&index)));
    assert!(!found.is_empty());
}

#[test]
fn a_sole_lies_on_the_surface_of_its_foot() {
    const TOLERANCE: f64 = 3e-3;
    let check = |model: &RobotModel| {
        let bodies = CollisionBody::of_robot(model).unwrap();
        let undersides: Vec<Underside> =
            model.feet.iter().map(|foot| Underside::new(model, foot, REACH).unwrap()).collect();
        check_soles(model, &bodies, &undersides, TOLERANCE)
    };
    let off = |millimetres: u64| CheckerError::SoleOffFoot { foot: "left".into(), millimetres };
    assert_eq!(check(&robot()), Ok(()));
    // The foot is this much higher than its sole, or its surface is this far beside.
    for (boxes, answer) in [
        ([block(2.9e-3)], Ok(())),
        ([block(3.1e-3)], Err(off(4))),
        ([block(-2.9e-3)], Ok(())),
        (
            [block(-5.5e-3)],
            Err(CheckerError::FootBelowSole { foot: "left".into(), millimetres: 6 }),
        ),
        ([(DVec3::new(0.0, 0.0, 0.02), DVec3::new(0.0972, 0.05, 0.02))], Ok(())),
        ([(DVec3::new(0.0, 0.0, 0.02), DVec3::new(0.0968, 0.05, 0.02))], Err(off(4))),
        // All corners are deep inside.
        ([(DVec3::new(0.0, 0.0, 0.02), DVec3::new(0.2, 0.2, 0.0995))], Err(off(80))),
    ] {
        assert_eq!(check(&foot_of(&boxes)), answer, "{boxes:?}");
    }
    // A foot without shapes is far away.
    assert_eq!(check(&foot_of(&[])), Err(off(1_000_000)));
}
