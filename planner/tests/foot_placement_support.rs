//! The support of a sole: areas compared with values computed by hand, and each reason for having
//! none.

#![allow(clippy::unwrap_used, reason = "a test ends where its world does not compile")]

mod foot_placement_worlds;

use foot_placement_worlds::*;
use glam::{DVec2, DVec3};
use surefoot_planner::foot_placement::sole_support::{NoSupport, Support, SurfacesError};
use surefoot_planner::foot_placement::{FootPlacementConfig, Scratch, SoleShape, Surfaces};
use surefoot_shared_types::base::spatial::{rotation_about, rotation_from_rpy};
use surefoot_shared_types::{Pose, Shape};

fn area_at(surfaces: &Surfaces, pose: &Pose) -> f64 {
    support(surfaces, pose).unwrap().area
}

/// The sole pose on a slope up along x.
fn on_ramp(angle: f64) -> Pose {
    Pose::from_parts(DVec3::ZERO, rotation_about(DVec3::Y, -angle))
}

#[test]
fn a_floor_carries_the_whole_sole() {
    let support = support(&surfaces(vec![floor()]), &turned(0.3, -0.2, 0.0, 0.7)).unwrap();
    assert!((support.area - SOLE_AREA).abs() < 1e-12);
    assert!((support.edge_distance - 0.07).abs() < 1e-12);
    assert_eq!(support.polygon.len(), 4);
    assert!(support.polygon.iter().all(|p| sole().iter().any(|q| p.distance(*q) < 1e-12)));
}

#[test]
fn both_ibeams_carry_and_one_does_not() {
    let beams = surfaces(ibeams());
    let both = area_at(&beams, &at(-0.02, 0.3, 0.2));
    assert!((both - 0.20 * 0.14).abs() < 1e-9, "outer span 0.20 by the sole's width, got {both}");
    let one = support(&beams, &at(-0.075 - 0.1, 0.0, 0.2));
    assert_eq!(one, Err(NoSupport::AreaTooSmall), "across one top: 0.05 by 0.14 is 0.007 m2");
}

#[test]
fn a_stone_supports_the_part_of_the_sole_on_it() {
    let stones = surfaces(stones());
    assert!((area_at(&stones, &at(-0.02, 0.12, 0.0)) - SOLE_AREA).abs() < 1e-9);
    assert!(
        (area_at(&stones, &at(0.08, 0.12, 0.0)) - 0.15 * 0.14).abs() < 1e-9,
        "toe beyond the edge by 0.07"
    );
}

#[test]
fn a_beam_narrower_than_the_sole_carries_its_own_width() {
    let beam = surfaces(vec![block([2.0, 0.12, 0.02], [0.0, 0.0, 0.8])]);
    assert!((area_at(&beam, &at(0.0, 0.0, 0.8)) - 0.22 * 0.12).abs() < 1e-9);
}

#[test]
fn friction_decides_the_steepest_slope() {
    let cone = libm::atan(MU);
    let gentle = 0.9 * cone;
    assert!((area_at(&surfaces(ramp(gentle)), &on_ramp(gentle)) - SOLE_AREA).abs() < 1e-9);
    let steep = 1.1 * cone;
    assert_eq!(support(&surfaces(ramp(steep)), &on_ramp(steep)), Err(NoSupport::TooSteep));
}

#[test]
fn two_round_bars_support_the_area_between_their_top_lines() {
    let bars = surfaces(round_bars(2));
    let support = support(&bars, &at(0.06, 0.1, 0.0)).unwrap();
    assert!((support.area - 0.16 * 0.14).abs() < 1e-9, "{}", support.area);
    assert_eq!(support_of_one_bar(&bars), Err(NoSupport::AreaTooSmall));
}

fn rectangle(x: [f64; 2], y: [f64; 2]) -> Vec<DVec2> {
    [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])].map(DVec2::from).to_vec()
}

fn support_on(pads: &[Vec<DVec2>], surfaces: &Surfaces, pose: &Pose) -> Result<Support, NoSupport> {
    let sole = sole();
    let sole = SoleShape { outline: &sole, pads };
    surfaces.support_of_sole(&mut Scratch::new(surfaces.config()), sole, pose)
}

#[test]
fn a_foot_whose_flat_part_lies_between_two_bars_touches_neither() {
    let bars = surfaces(round_bars(2));
    let pose = at(0.06, 0.1, 0.0);
    // The bars are 0.16 m apart. Their hull covers the flat part, which touches no bar.
    let flat = |x: [f64; 2]| [rectangle(x, [-0.07, 0.07])];
    let found = |x| support_on(&flat(x), &bars, &pose).map(|support| support.area);
    assert_eq!(found([-0.03, 0.08]), Err(NoSupport::NothingBelow));
    assert_eq!(found([-0.08, 0.08]), Err(NoSupport::AreaTooSmall), "one of them");
    assert!((found([-0.08, 0.12]).unwrap() - 0.16 * 0.14).abs() < 1e-9);
}

#[test]
fn a_sole_on_studs_touches_with_those_that_are_over_ground() {
    let stud = |x: f64, y: f64| rectangle([x - 0.01, x + 0.01], [y - 0.01, y + 0.01]);
    let studs: Vec<Vec<DVec2>> = [(-0.07, -0.05), (-0.07, 0.05), (0.11, -0.05), (0.11, 0.05)]
        .map(|(x, y)| stud(x, y))
        .into();
    let area =
        |ground| support_on(&studs, &surfaces(vec![ground]), &at(0.0, 0.0, 0.0)).unwrap().area;
    assert!((area(floor()) - 0.2 * 0.12).abs() < 1e-9);
    // An edge at x = 0.11, in the middle of the front studs, and one at 0.09, before them.
    assert!((area(block([2.0, 2.0, 0.5], [-0.89, 0.0, 0.0])) - 0.19 * 0.12).abs() < 1e-9);
    let behind = surfaces(vec![block([2.0, 2.0, 0.5], [-0.91, 0.0, 0.0])]);
    assert_eq!(support_on(&studs, &behind, &at(0.0, 0.0, 0.0)), Err(NoSupport::AreaTooSmall));
}

#[test]
fn ground_rises_into_a_pad_no_more_than_into_a_whole_sole() {
    let pads = [rectangle([-0.05, 0.09], [-0.07, 0.07])];
    let on = |z: f64| support_on(&pads, &surfaces(vec![floor()]), &at(0.0, 0.0, z));
    assert!(on(-9e-5).is_ok());
    assert_eq!(on(-1.1e-4), Err(NoSupport::Penetrates));
}

#[test]
fn the_highest_ground_is_near_the_plane_of_a_sole() {
    let scene = surfaces(vec![floor()]);
    let on = |z: f64| support(&scene, &at(0.0, 0.0, z)).map(|_| ());
    assert_eq!((on(9e-5), on(-9e-5)), (Ok(()), Ok(())));
    assert_eq!(on(1.1e-4), Err(NoSupport::NothingBelow));
    assert_eq!(on(-1.1e-4), Err(NoSupport::Penetrates));
}

fn support_of_one_bar(bars: &Surfaces) -> Result<f64, NoSupport> {
    support(bars, &at(-0.12, 0.0, 0.0)).map(|s| s.area)
}

#[test]
fn bars_at_different_heights_carry_a_tilted_sole() {
    let mut shapes = round_bars(2);
    shapes[1].1.translation.z += 0.04;
    let tilt = libm::asin(0.04 / (0.16f64 * 0.16 + 0.04 * 0.04).sqrt());
    let rotation = rotation_about(DVec3::Y, -tilt);
    let centre = 0.5 * (shapes[0].1.translation + shapes[1].1.translation)
        + rotation * DVec3::new(-0.02, 0.0, 0.02);
    let area = area_at(&surfaces(shapes), &Pose::from_parts(centre, rotation));
    assert!((area - 0.14 * (0.16f64 * 0.16 + 0.04 * 0.04).sqrt()).abs() < 1e-6, "{area}");
}

#[test]
fn capsules_and_balls_carry_at_points() {
    let lying = rotation_from_rpy(std::f64::consts::FRAC_PI_2, 0.0, 0.0);
    let capsule = |x: f64| {
        (
            Shape::Capsule { radius: 0.02, half_length: 0.6 },
            Pose::from_parts(DVec3::new(x, 0.0, -0.02), lying),
        )
    };
    let area = area_at(&surfaces(vec![capsule(0.0), capsule(0.16)]), &at(0.06, 0.0, 0.0));
    assert!((area - 0.16 * 0.14).abs() < 1e-9);
    let balls = [(-0.05, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.05, 0.05)];
    let ball = |&(x, y): &(f64, f64)| (Shape::Sphere { radius: 0.03 }, at(x, y, -0.03));
    let area = area_at(&surfaces(balls.iter().map(ball).collect()), &at(0.0, 0.0, 0.0));
    assert!((area - 0.15 * 0.1).abs() < 1e-9);
}

#[test]
fn a_drum_carries_on_its_cap_alone() {
    let drum = (Shape::Cylinder { radius: 0.3, half_length: 0.2 }, at(0.0, 0.0, -0.2));
    assert!((area_at(&surfaces(vec![drum.clone()]), &at(0.0, 0.0, 0.0)) - SOLE_AREA).abs() < 1e-9);
    let lying = (
        drum.0,
        Pose::from_parts(
            DVec3::new(0.0, 0.0, -0.3),
            rotation_from_rpy(std::f64::consts::FRAC_PI_2, 0.0, 0.0),
        ),
    );
    assert_eq!(support(&surfaces(vec![lying]), &at(0.0, 0.0, 0.0)), Err(NoSupport::AreaTooSmall));
}

#[test]
fn a_hull_and_a_mesh_carry_like_the_box_they_trace() {
    let poses = [turned(0.1, 0.05, 0.0, 0.4), at(0.3, 0.0, 0.0), turned(-0.33, 0.31, 0.0, 2.0)];
    let corners = [-0.4, 0.4]
        .iter()
        .flat_map(|&x| [-0.4, 0.4].map(|y| (x, y)))
        .flat_map(|(x, y)| [-0.5, 0.0].map(|z| DVec3::new(x, y, z)));
    let traced = [
        surfaces(vec![(
            Shape::ConvexHull { points: corners.collect(), source: None },
            Pose::IDENTITY,
        )]),
        surfaces(vec![mesh(0.8, 1, |_, _| 0.0)]),
        surfaces(vec![mesh(0.8, 40, |_, _| 0.0)]),
    ];
    let original = surfaces(vec![block([0.8, 0.8, 0.5], [0.0, 0.0, 0.0])]);
    for pose in &poses {
        let expected = support(&original, pose).unwrap();
        for surfaces in &traced {
            let found = support(surfaces, pose).unwrap();
            assert_eq!(found.polygon.len(), expected.polygon.len());
            assert!(
                found
                    .polygon
                    .iter()
                    .all(|p| expected.polygon.iter().any(|q| p.distance(*q) < 1e-6))
            );
            assert!((found.area - expected.area).abs() < 1e-9);
        }
    }
}

#[test]
fn an_uneven_mesh_reports_how_near_its_corners_are() {
    // Ridges along y, 0.3 mm high, one at every second corner.
    let spacing = |cells: u32| {
        let step = 0.8 / f64::from(cells);
        let height = |x: f64, _| 1.5e-4 * libm::cos(std::f64::consts::PI * x / step);
        let surfaces = surfaces(vec![mesh(0.8, cells, height)]);
        support(&surfaces, &at(0.0, 0.0, 1.5e-4)).unwrap().corner_spacing
    };
    assert!((spacing(16) - 0.05).abs() < 1e-4, "{}", spacing(16));
    assert!((spacing(8) - 0.1).abs() < 1e-4, "{}", spacing(8));
    let even = surfaces(vec![mesh(0.8, 40, |_, _| 0.0)]);
    assert_eq!(support(&even, &at(0.0, 0.0, 0.0)).unwrap().corner_spacing, f64::INFINITY);
}

#[test]
fn a_sliver_at_a_corner_carries_nothing() {
    let tile = block([0.2, 0.4, 0.1], [0.0, 0.0, 0.0]);
    let alone = area_at(&surfaces(vec![tile.clone()]), &at(0.0, 0.0, 0.0));
    let touched = |overlap: f64| {
        let corner = block([0.1, 0.1, 0.1], [0.13 - overlap + 0.05, 0.07 - overlap + 0.05, 0.0]);
        area_at(&surfaces(vec![tile.clone(), corner]), &at(0.0, 0.0, 0.0))
    };
    assert!(
        (touched(0.008) - alone).abs() < 1e-12,
        "8 mm of a neighbour under a corner of the sole"
    );
    assert!(touched(0.02) > alone + 1e-4, "20 mm of it do carry");
}

#[test]
fn tiles_with_a_gap_and_a_small_step_still_carry_together() {
    let tiles = |step: f64| {
        surfaces(vec![
            block([0.2, 0.4, 0.1], [-0.11, 0.0, 0.0]),
            block([0.2, 0.4, 0.1], [0.11, 0.0, step]),
        ])
    };
    // From the edge of the upper tile, 10 mm behind the sole's middle, to the end of the sole the
    // foot tilts by 0.9 mm, and the centre of mass moves with it.
    let shift = FootPlacementConfig::default().centre_height * 0.0009 / 0.14;
    let carried = support(&tiles(-0.0009), &at(0.0, 0.0, 0.0)).unwrap();
    let furthest = carried.polygon.iter().map(|corner| corner.x).fold(f64::NEG_INFINITY, f64::max);
    assert!((furthest - (0.13 - shift)).abs() < 1e-9, "{furthest}");
    // Towards a front corner it tilts more steeply, so that the corners hold less than the middle.
    assert!(carried.area > 0.75 * SOLE_AREA && carried.area < SOLE_AREA - 0.14 * shift);
    assert!(
        (area_at(&tiles(-0.0011), &at(0.0, 0.0, 0.0)) - 0.08 * 0.14).abs() < 1e-9,
        "the lower tile is out of touch"
    );
    assert_eq!(support(&tiles(0.0011), &at(0.0, 0.0, 0.0)), Err(NoSupport::Penetrates));
}

#[test]
fn any_obstacle_within_the_outline_is_rejected() {
    let obstacles = [
        block([0.02, 0.02, 0.5], [0.05, 0.0, 0.25]),
        (Shape::Sphere { radius: 0.02 }, at(0.05, 0.0, 0.0)),
        (Shape::Sphere { radius: 0.05 }, at(0.05, 0.08, 0.02)),
        (Shape::Capsule { radius: 0.01, half_length: 0.5 }, at(0.05, 0.0, 0.0)),
        (Shape::Cylinder { radius: 0.01, half_length: 0.5 }, at(0.05, 0.0, 0.0)),
        block([0.3, 0.3, 0.01], [0.0, 0.0, 0.017]),
        block([0.5, 0.5, 0.5], [0.0, 0.0, 0.5]),
    ];
    for obstacle in obstacles {
        let label = format!("{obstacle:?}");
        let scene = surfaces(vec![floor(), obstacle]);
        assert_eq!(support(&scene, &at(0.0, 0.0, 0.0)), Err(NoSupport::Penetrates), "{label}");
        assert!(support(&scene, &at(2.0, 0.0, 0.0)).is_ok(), "{label}");
    }
}

#[test]
fn walls_beside_the_sole_and_ceilings_above_it_are_no_obstacle() {
    let scene = surfaces(vec![
        floor(),
        block([0.1, 2.0, 1.0], [0.18, 0.0, 1.0]),
        block([1.0, 1.0, 0.1], [0.0, 0.0, 0.2]),
        (Shape::Sphere { radius: 0.05 }, at(0.0, 0.121, 0.01)),
    ]);
    assert!(support(&scene, &at(0.0, 0.0, 0.0)).is_ok());
}

#[test]
fn a_steep_roof_of_one_layer_takes_nothing_from_the_ground_below() {
    let roof = Shape::Mesh {
        vertices: vec![
            DVec3::new(-2.0, -2.0, 0.0),
            DVec3::new(4.0, -2.0, 0.0),
            DVec3::new(4.0, 0.0, 3.0),
            DVec3::new(-2.0, 0.0, 3.0),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        source: None,
    };
    let under = surfaces(vec![floor(), (roof, Pose::IDENTITY)]);
    assert!((area_at(&under, &at(0.0, -0.2, 0.0)) - SOLE_AREA).abs() < 1e-12);
}

#[test]
fn each_reason_is_given() {
    let scene = surfaces(vec![floor(), block([0.3, 0.04, 0.1], [3.0, 0.0, 0.5])]);
    let narrow = surfaces(vec![block([0.5, 0.038, 0.1], [0.0, 0.0, 0.0])]);
    assert_eq!(support(&scene, &at(0.0, 0.0, 0.5)), Err(NoSupport::NothingBelow));
    assert_eq!(support(&scene, &at(0.0, 0.0, 0.002)), Err(NoSupport::NothingBelow));
    assert_eq!(support(&scene, &at(0.0, 0.0, -0.002)), Err(NoSupport::Penetrates));
    assert_eq!(support(&scene, &on_ramp(0.55)), Err(NoSupport::TooSteep));
    assert_eq!(support(&scene, &at(f64::NAN, 0.0, 0.0)), Err(NoSupport::InvalidSole));
    assert_eq!(support(&narrow, &at(0.0, 0.0, 0.0)), Err(NoSupport::CentroidNearEdge));
    let few = FootPlacementConfig { support_elements_max: 1, ..Default::default() };
    let exceeded = Surfaces::new(&world(ibeams()), few.clone()).unwrap();
    assert_eq!(
        exceeded.support(&mut Scratch::new(&few), &sole(), &at(-0.02, 0.0, 0.2)),
        Err(NoSupport::TooManyElements)
    );
}

#[test]
fn a_mesh_that_faces_down_is_distinguished_from_an_obstacle() {
    let (mut ground, pose) = mesh(2.0, 4, |_, _| 0.0);
    assert!(support(&surfaces(vec![(ground.clone(), pose)]), &at(0.1, 0.0, 0.0)).is_ok());
    let Shape::Mesh { triangles, .. } = &mut ground else { panic!("not a mesh") };
    triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    let inside_out = surfaces(vec![(ground.clone(), pose)]);
    assert_eq!(support(&inside_out, &at(0.1, 0.0, 0.0)), Err(NoSupport::FacesDown));
    assert!(support(&surfaces(vec![(ground, pose), floor()]), &at(1.5, 0.0, 0.0)).is_ok());
}

#[test]
fn invalid_soles_worlds_and_parameters_are_rejected() {
    let scene = surfaces(vec![floor()]);
    let mut scratch = Scratch::new(scene.config());
    let clockwise: Vec<DVec2> = sole().into_iter().rev().collect();
    let too_many: Vec<DVec2> =
        (0..17).map(|i| DVec2::from(libm::sincos(-f64::from(i) * 0.3))).collect();
    for polygon in [vec![], vec![DVec2::ZERO; 4], clockwise, too_many, vec![DVec2::NAN; 3]] {
        assert_eq!(
            scene.support(&mut scratch, &polygon, &at(0.0, 0.0, 0.0)),
            Err(NoSupport::InvalidSole)
        );
    }
    let flat = [DVec3::ZERO, DVec3::X];
    let broken =
        world(vec![(Shape::ConvexHull { points: flat.to_vec(), source: None }, Pose::IDENTITY)]);
    assert!(matches!(Surfaces::new(&broken, Default::default()), Err(SurfacesError::Shape { .. })));
    let config = FootPlacementConfig { plane_distance_max: f64::NAN, ..Default::default() };
    assert!(matches!(
        Surfaces::new(&world(vec![]), config),
        Err(SurfacesError::Config { field: "plane_distance_max", .. })
    ));
    assert_eq!(support(&surfaces(vec![]), &at(0.0, 0.0, 0.0)), Err(NoSupport::NothingBelow));
}
