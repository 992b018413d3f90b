//! Proposed placements: found on every feature of section 4.2, near the ideal, and reproducible.

mod foot_placement_worlds;

use foot_placement_worlds::*;
use glam::{DVec2, DVec3};
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::foot_placement::{
    PlacementQuery, SampleLimits, Scratch, SoleShape, Source, Surfaces, propose,
};
use surefoot_shared_types::base::spatial::{rotation_from_rpy, yaw_of};
use surefoot_shared_types::{Pose, Shape};

const GEOMETRY_ONLY: SampleLimits =
    SampleLimits { geometric_max: 256, perturbed_max: 0, sampled_max: 0 };
const SAMPLING_ONLY: SampleLimits =
    SampleLimits { geometric_max: 0, perturbed_max: 0, sampled_max: 8_000 };

/// The share of random ideals within `region` (lower, upper corner) for which some placement is
/// found.
fn rate(surfaces: &Surfaces, region: [[f64; 3]; 2], limits: SampleLimits, reach_xy: f64) -> f64 {
    let polygon = sole();
    let mut scratch = Scratch::new(surfaces.config());
    let queries = 100;
    let succeeds = |object: u64| {
        let mut random = Random::new(5, Stream::Preparation, object, 0);
        let [x, y, z] = [0, 1, 2].map(|axis| random.uniform(region[0][axis], region[1][axis]));
        let ideal = turned(x, y, z, random.uniform(-3.1, 3.1));
        let query = PlacementQuery { limits, object, reach_xy, ..query(&polygon, ideal) };
        propose(surfaces, &mut scratch, &query, &mut |_| false).stopped
    };
    (0..queries).map(succeeds).filter(|&found| found).count() as f64 / queries as f64
}

#[test]
fn a_flat_floor_gives_the_ideal_itself_first() {
    let floor = surfaces(vec![floor()]);
    let polygon = sole();
    let ideal = turned(0.4, 0.7, 0.0, 0.3);
    let placements = first(&floor, &query(&polygon, ideal), 3);
    assert!((placements[0].world_from_sole.translation - ideal.translation).length() < 1e-12);
    assert!((yaw_of(placements[0].world_from_sole.rotation) - 0.3).abs() < 1e-12);
    assert_eq!(placements[0].source, Source::Geometric);
    assert_eq!(placements.len(), 3);
}

#[test]
fn a_slope_tilts_the_sole_and_keeps_its_heading() {
    let angle = 0.9 * libm::atan(MU);
    let polygon = sole();
    let placements = first(&surfaces(ramp(angle)), &query(&polygon, turned(0.1, 0.0, 0.0, 0.8)), 1);
    let rotation = placements[0].world_from_sole.rotation;
    assert!((yaw_of(rotation) - 0.8).abs() < 1e-9);
    assert!((libm::acos((rotation * DVec3::Z).z) - angle).abs() < 1e-9);
    assert!((placements[0].support.area - SOLE_AREA).abs() < 1e-9);
    let steep = 1.1 * libm::atan(MU);
    assert!(first(&surfaces(ramp(steep)), &query(&polygon, at(0.0, 0.0, 0.0)), 1).is_empty());
}

#[test]
fn stones_carry_the_whole_sole_at_the_nearest_pose() {
    let polygon = sole();
    let stones = surfaces(stones());
    let geometry =
        PlacementQuery { limits: GEOMETRY_ONLY, ..query(&polygon, at(0.36, -0.02, 0.0)) };
    let whole = first(&stones, &geometry, 100)
        .into_iter()
        .find(|p| (p.support.area - SOLE_AREA).abs() < 1e-9)
        .unwrap();
    let moved = whole.world_from_sole.translation - geometry.ideal.translation;
    assert!(
        moved.length() < 0.07,
        "moved by {moved}: the stone's area for the sole begins 0.05 away"
    );
}

#[test]
fn ibeams_are_crossed_with_the_sole_centred() {
    let polygon = sole();
    let beams = surfaces(ibeams());
    let query = PlacementQuery {
        reach_z: [-0.05, 0.05],
        limits: GEOMETRY_ONLY,
        ..query(&polygon, turned(0.06, 0.2, 0.2, 0.15))
    };
    let placements = first(&beams, &query, 1_000);
    let centred = placements.iter().find(|p| {
        let centre = p.world_from_sole * DVec3::new(0.02, 0.0, 0.0);
        centre.x.abs() < 1e-9 && yaw_of(p.world_from_sole.rotation).abs() < 1e-9
    });
    assert!((centred.unwrap().support.area - 0.2 * 0.14).abs() < 1e-9);
    let mut along: Vec<f64> = placements.iter().map(|p| p.world_from_sole.translation.y).collect();
    along.sort_by(f64::total_cmp);
    assert!(
        along[0] < 0.0 && along[along.len() - 1] > 0.4,
        "several places along the beams: {along:?}"
    );
    assert!(placements.iter().all(|p| p.support.area >= 0.008));
}

#[test]
fn a_sole_with_little_play_across_two_bars_stands_in_the_middle() {
    let bar = |x: f64| {
        let across = rotation_from_rpy(std::f64::consts::FRAC_PI_2, 0.0, 0.0);
        let pose = Pose::from_parts(DVec3::new(x, 0.0, -0.02), across);
        (Shape::Cylinder { radius: 0.02, half_length: 0.6 }, pose)
    };
    // The sole is 0.22 m long: it has 1 cm of play.
    let bars = surfaces(vec![bar(-0.105), bar(0.105)]);
    let polygon = sole();
    let query =
        PlacementQuery { limits: GEOMETRY_ONLY, ..query(&polygon, turned(0.02, 0.1, 0.0, 0.0)) };
    let straight: Vec<f64> = first(&bars, &query, 1_000)
        .iter()
        .filter(|p| yaw_of(p.world_from_sole.rotation).abs() < 1e-9)
        .map(|p| (p.world_from_sole * DVec3::new(0.02, 0.0, 0.0)).x)
        .collect();
    assert!(!straight.is_empty() && straight.iter().all(|x| x.abs() < 1e-9), "{straight:?}");
}

#[test]
fn geometry_alone_finds_placements_on_every_feature() {
    let beam = vec![block([2.0, 0.12, 0.02], [0.0, 0.0, 0.8])];
    let drum_pose = Pose::from_parts(
        DVec3::new(0.0, 0.0, -0.02),
        rotation_from_rpy(std::f64::consts::FRAC_PI_2, 0.0, 0.0),
    );
    let mixed = vec![
        block([0.05, 1.0, 0.05], [-0.16, 0.0, 0.0]),
        (Shape::Capsule { radius: 0.02, half_length: 0.6 }, drum_pose),
    ];
    let tilted_bars = {
        let mut shapes = round_bars(2);
        shapes[1].1.translation.z += 0.05;
        shapes
    };
    let uneven_pipes: Vec<_> =
        (0..13).map(|i| pipe(0.12 * f64::from(i), 0.006 * libm::sin(2.0 * f64::from(i)))).collect();
    let features = [
        ("floor", vec![floor()], [[-2.0, -2.0, -0.1], [2.0, 2.0, 0.1]]),
        ("ramp", ramp(0.9 * libm::atan(MU)), [[-0.3, -0.5, -0.1], [0.3, 0.5, 0.1]]),
        ("stones", stones(), [[0.0, -0.1, -0.05], [1.4, 0.1, 0.05]]),
        ("ibeams", ibeams()[1..].to_vec(), [[-0.15, -0.8, 0.1], [0.15, 0.8, 0.3]]),
        ("round bars", round_bars(12), [[0.1, -0.4, -0.1], [1.6, 0.4, 0.1]]),
        ("tilted bars", tilted_bars, [[0.0, -0.4, -0.1], [0.16, 0.4, 0.1]]),
        ("bar and capsule", mixed, [[-0.15, -0.4, -0.1], [0.15, 0.4, 0.1]]),
        ("beam", beam, [[-0.8, -0.15, 0.7], [0.8, 0.15, 0.9]]),
        ("stairs", stairs(), [[0.4, -0.4, 0.55], [0.6, 0.4, 0.75]]),
        ("spiral", spiral(), [[0.2, 0.5, 0.45], [0.45, 0.75, 0.65]]),
        (
            "block edge",
            vec![block([1.0, 1.0, 0.3], [0.5, 0.0, 0.0])],
            [[-0.15, -0.4, -0.1], [0.1, 0.4, 0.1]],
        ),
        ("flat mesh", vec![mesh(4.0, 20, |_, _| 0.0)], [[-1.5, -1.5, -0.1], [1.5, 1.5, 0.1]]),
        ("uneven pipes", uneven_pipes, [[0.2, -0.3, -0.1], [1.2, 0.3, 0.1]]),
        (
            "hills",
            vec![mesh(4.0, 80, |x, y| 0.1 * libm::sin(2.0 * x + y))],
            [[-1.5, -1.5, -0.1], [1.5, 1.5, 0.1]],
        ),
    ];
    for (name, shapes, region) in features {
        let surfaces = surfaces(shapes);
        let [geometric, sampled] =
            [GEOMETRY_ONLY, SAMPLING_ONLY].map(|limits| rate(&surfaces, region, limits, 0.3));
        println!("{name}: geometry {geometric:.3}, Algorithm 1 alone {sampled:.3}");
        assert!(geometric >= 0.95, "{name}: {geometric}");
    }
}

#[test]
fn parallel_bars_are_found_at_every_span() {
    for percent in (60..=130).step_by(5) {
        let bars = surfaces(square_bars(f64::from(percent) / 100.0));
        let region = [[-0.1, -0.2, -0.05], [0.1, 0.2, 0.05]];
        let [geometric, sampled] =
            [GEOMETRY_ONLY, SAMPLING_ONLY].map(|limits| rate(&bars, region, limits, 0.3));
        println!("span {percent} %: geometry {geometric:.3}, Algorithm 1 alone {sampled:.3}");
        assert!(geometric >= 0.95, "{percent} %: {geometric}");
    }
}

#[test]
fn on_rough_ground_soles_are_set_down_near_their_ideal_poses() {
    let height = |x: f64, y: f64| {
        0.06 * libm::sin(3.0 * x) * libm::cos(2.0 * y) + 0.001 * libm::sin(40.0 * x + 27.0 * y)
    };
    let (size, n) = (4.0, 40);
    let (rough, polygon) = (surfaces(vec![mesh(size, n, height)]), sole());
    let side = |i: u32| size * (f64::from(i) / f64::from(n) - 0.5);
    let corners = || {
        (0..=n)
            .flat_map(|i| (0..=n).map(move |j| (side(i), side(j))))
            .map(|(x, y)| DVec3::new(x, y, height(x, y)))
    };
    let mut random = Random::new(6, Stream::Preparation, 0, 0);
    let mut distances = Vec::new();
    for _ in 0..100 {
        let [x, y, yaw] = [1.7, 1.7, 3.0].map(|most| random.uniform(-most, most));
        let query = PlacementQuery {
            limits: GEOMETRY_ONLY,
            ..query(&polygon, turned(x, y, height(x, y), yaw))
        };
        let [placement] = &first(&rough, &query, 1)[..] else { continue };
        let pose = placement.world_from_sole;
        distances.push((pose.translation - query.ideal.translation).truncate().length());
        let in_sole = corners().map(|corner| pose.inverse_transform_point(corner));
        let highest = in_sole
            .filter(|p| (-0.09..0.13).contains(&p.x) && p.y.abs() < 0.07)
            .map(|p| p.z)
            .fold(f64::MIN, f64::max);
        assert!(highest < 1e-3, "a corner of the ground is {highest} above the sole");
    }
    assert!(distances.len() >= 98, "found for {} of 100", distances.len());
    let near = |most: f64| distances.iter().filter(|distance| **distance <= most).count();
    // A support that a rigid foot holds without tilting is wide at a third of the ideal poses,
    // within 5 cm of half of the others, and within 16 cm of all but one.
    let counts = [1e-9, 0.0501, 0.16].map(near);
    assert!(counts[0] >= 33 && counts[1] >= 75 && counts[2] >= 99, "{counts:?}");
}

#[test]
fn algorithm_1_finds_placements_by_itself() {
    for (shapes, least) in [(vec![floor()], 0.99), (stones(), 0.8), (ibeams(), 0.8)] {
        let region = [[0.0, -0.1, 0.0], [0.3, 0.1, 0.1]];
        let rate = rate(&surfaces(shapes), region, SAMPLING_ONLY, 0.3);
        assert!(rate >= least, "{rate}");
    }
}

/// Whether any pose of a fine grid across the bars has a support.
fn any_placement_exists(bars: &Surfaces) -> bool {
    let grid = (-60..=60).flat_map(|shift| {
        (0..63).map(move |turn| (2e-3 * f64::from(shift), 0.025 * f64::from(turn)))
    });
    grid.into_iter().any(|(shift, turn)| support(bars, &turned(shift, 0.0, 0.0, turn)).is_ok())
}

#[test]
fn parallel_bars_are_found_as_long_as_any_placement_exists() {
    let mut last = 0;
    for percent in (100..=150).step_by(5) {
        let bars = surfaces(square_bars(f64::from(percent) / 100.0));
        let found = rate(&bars, [[-0.1, -0.2, -0.05], [0.1, 0.2, 0.05]], GEOMETRY_ONLY, 0.3);
        if any_placement_exists(&bars) {
            assert!(found >= 0.99, "{percent} %: {found}");
            last = percent;
        }
    }
    println!("the widest span with a placement: {last} %");
    assert!((120..150).contains(&last), "{last}");
}

#[test]
fn placements_with_a_large_support_precede_those_with_enough() {
    let polygon = sole();
    let beside_an_edge = surfaces(vec![block([1.0, 1.0, 0.3], [0.5, 0.0, 0.0])]);
    let query = PlacementQuery { limits: GEOMETRY_ONLY, ..query(&polygon, at(-0.03, 0.0, 0.0)) };
    let inflated = 2.0 * beside_an_edge.config().support_area_min;
    let areas: Vec<f64> =
        first(&beside_an_edge, &query, 1_000).iter().map(|p| p.support.area).collect();
    let first_small = areas.iter().position(|&area| area < inflated).unwrap();
    assert!(
        first_small > 0 && areas[first_small..].iter().all(|&area| area < inflated),
        "{areas:?}"
    );
}

#[test]
fn bars_that_fit_into_the_sole_are_not_at_its_very_edge() {
    let polygon = sole();
    let query = PlacementQuery { limits: GEOMETRY_ONLY, ..query(&polygon, at(-0.01, 0.0, 0.0)) };
    let x = first(&surfaces(round_bars(2)), &query, 1)[0].world_from_sole.translation.x;
    let (heel, toe) = (x - 0.09, x + 0.13);
    assert!(
        heel <= -0.01 + 1e-9 && toe >= 0.17 - 1e-9,
        "the bars stand at 0 and 0.16, the sole from {heel} to {toe}"
    );
    assert!(toe < 0.175, "and near its ideal: {toe}");
}

#[test]
fn bars_too_far_apart_give_nothing() {
    let bars = surfaces(square_bars(1.6));
    assert_eq!(
        rate(&bars, [[-0.1, -0.2, -0.05], [0.1, 0.2, 0.05]], SampleLimits::default(), 0.3),
        0.0
    );
}

#[test]
fn placements_stay_within_the_query() {
    let polygon = sole();
    let surfaces = surfaces(ibeams());
    let is_left = |pose: &Pose| pose.translation.y > 0.0;
    let query = PlacementQuery {
        reach_xy: 0.2,
        reach_z: [-0.05, 0.02],
        yaw_spread: 0.4,
        is_free: &is_left,
        ..query(&polygon, turned(0.0, 0.0, 0.2, 0.1))
    };
    let mut count = 0;
    let stats = propose(&surfaces, &mut Scratch::new(surfaces.config()), &query, &mut |p| {
        let moved = p.world_from_sole.translation - query.ideal.translation;
        assert!(
            moved.truncate().length() <= 0.2 + 1e-6
                && (-0.05 - 1e-6..=0.02 + 1e-6).contains(&moved.z)
        );
        assert!((yaw_of(p.world_from_sole.rotation) - 0.1).abs() <= 0.4 + 1e-6);
        assert!(p.world_from_sole.translation.y > 0.0);
        count += 1;
        true
    });
    assert_eq!(count, stats.found.iter().sum::<u32>());
    assert!(stats.not_free > 0 && count > 0 && !stats.stopped);
    let examined: u32 = stats.examined.iter().sum();
    assert_eq!(
        examined,
        count + stats.not_free + stats.rejected.iter().sum::<u32>(),
        "every placement is accounted for"
    );
}

#[test]
fn surfaces_just_out_of_reach_do_not_exhaust_the_samples() {
    let polygon = sole();
    let floor = surfaces(vec![floor()]);
    let limits = SampleLimits { geometric_max: 0, perturbed_max: 0, sampled_max: 24 };
    let query = PlacementQuery { limits, reach_xy: 0.3, ..query(&polygon, at(5.27, 5.27, 0.0)) };
    let stats = propose(&floor, &mut Scratch::new(floor.config()), &query, &mut |_| true);
    let examined: u32 = stats.examined.iter().sum();
    assert!(
        stats.features > 0 && stats.out_of_reach > 0,
        "the floor's corner is in the box about the reach: {stats:?}"
    );
    assert!(examined + stats.out_of_reach <= 24, "{stats:?}");
}

#[test]
fn the_same_query_gives_the_same_placements_and_another_seed_others() {
    let polygon = sole();
    let surfaces = surfaces(stones());
    let query = PlacementQuery {
        limits: SampleLimits { geometric_max: 20, ..SampleLimits::default() },
        ..query(&polygon, at(0.2, 0.0, 0.0))
    };
    let placements = first(&surfaces, &query, 10_000);
    assert_eq!(placements, first(&surfaces, &query, 10_000));
    assert_ne!(placements, first(&surfaces, &PlacementQuery { seed: 2, ..query }, 10_000));
    let mut used = Scratch::new(surfaces.config());
    let mut again = Vec::new();
    let elsewhere = PlacementQuery { ideal: at(1.0, 0.0, 0.0), ..query };
    propose(&surfaces, &mut used, &elsewhere, &mut |_| true);
    propose(&surfaces, &mut used, &query, &mut |p| {
        again.push(p);
        true
    });
    assert_eq!(placements, again, "a used scratch changes nothing");
}

#[test]
fn invalid_queries_find_nothing() {
    let polygon = sole();
    let surfaces = surfaces(vec![floor()]);
    let sound = query(&polygon, at(0.0, 0.0, 0.0));
    let broken = [
        PlacementQuery { ideal: at(f64::NAN, 0.0, 0.0), ..sound },
        PlacementQuery { reach_xy: f64::INFINITY, ..sound },
        PlacementQuery { reach_z: [1.0, -1.0], ..sound },
        PlacementQuery { sole: SoleShape::flat(&polygon[..2]), ..sound },
        PlacementQuery { sole: SoleShape::flat(&[]), ..sound },
        PlacementQuery { yaw_spread: f64::NAN, ..sound },
        PlacementQuery { ideal: at(50.0, 0.0, 0.0), ..sound },
    ];
    for (i, query) in broken.iter().enumerate() {
        assert!(first(&surfaces, query, 10).is_empty(), "case {i}");
    }
}

#[test]
fn on_ground_with_the_noise_of_a_scan_a_sole_is_set_down_nearly_everywhere() {
    // 0.5 mm of deviation between corners 2 cm apart: peaks with a steep face beside a gentle one.
    let mut random = Random::new(7, Stream::Preparation, 0, 0);
    let mut noise = || (0..12).map(|_| random.uniform(-0.5, 0.5)).sum::<f64>() * 5e-4;
    let heights: Vec<f64> = (0..101 * 101).map(|_| noise()).collect();
    let index = |at: f64| ((at + 1.0) / 0.02).round() as usize;
    let ground = surfaces(vec![mesh(2.0, 100, |x, y| heights[101 * index(x) + index(y)])]);
    let mut scratch = Scratch::new(ground.config());
    let polygon = sole();
    let found = (0..50).filter(|&object| {
        let mut random = Random::new(5, Stream::Preparation, object, 0);
        let [x, y, yaw] = [0.8, 0.8, 3.0].map(|most| random.uniform(-most, most));
        let query =
            PlacementQuery { limits: GEOMETRY_ONLY, ..query(&polygon, turned(x, y, 0.0, yaw)) };
        propose(&ground, &mut scratch, &query, &mut |_| false).stopped
    });
    assert!(found.count() >= 49);
}

/// Whether the points that a sole touches surround its middle: those at most 0.25 mm lower than the
/// highest of `heights`, which are over its plane.
fn rests(sole_points: &[DVec2], heights: &[f64]) -> bool {
    let highest = heights.iter().copied().fold(f64::MIN, f64::max);
    let touched = || sole_points.iter().zip(heights).filter(|(_, z)| **z >= highest - 2.5e-4);
    (0..64).all(|k| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(k) / 64.0);
        let along = |at: &DVec2| DVec2::new(cos, sin).dot(*at - DVec2::new(0.02, 0.0));
        touched().any(|(at, _)| along(at) >= -2e-3)
    })
}

#[test]
fn on_folded_ground_soles_rest_on_the_highest_folds() {
    // Strips of 5 cm whose planes pass up to a millimetre over the strips beside them. With the
    // floor at its end the ground counts as planes.
    let mut random = Random::new(8, Stream::Preparation, 0, 0);
    let folds: Vec<f64> = (0..41).map(|_| random.uniform(-4e-4, 4e-4)).collect();
    let height = |x: f64| {
        let (at, share) = (libm::floor((x + 1.0) / 0.05), libm::fmod(x + 1.0, 0.05) / 0.05);
        let fold = |index: f64| folds[(index as usize).min(40)];
        fold(at) + share * (fold(at + 1.0) - fold(at))
    };
    let fold = |x: f64, _: f64| folds[libm::round((x + 1.0) / 0.05) as usize];
    let ground = surfaces(vec![mesh(2.0, 40, fold), block([0.5, 2.0, 0.1], [-1.25, 0.0, 0.0])]);
    let polygon = sole();
    let grid = (0..=110).flat_map(|i| (0..=70).map(move |j| (i, j)));
    let points: Vec<DVec2> = grid
        .map(|(i, j)| DVec2::new(2e-3 * f64::from(i) - 0.09, 2e-3 * f64::from(j) - 0.07))
        .collect();
    let [mut off, mut tilting, mut count] = [0; 3];
    for _ in 0..40 {
        let [x, y, yaw] = [0.12, 0.6, 3.0].map(|most| random.uniform(-most, most));
        let query = query(&polygon, turned(x - 0.75, y, 0.0, yaw));
        for placement in first(&ground, &query, 12) {
            let pose = placement.world_from_sole;
            let world: Vec<DVec3> = points.iter().map(|at| pose * at.extend(0.0)).collect();
            if world.iter().any(|at| at.x <= -1.0) {
                continue;
            }
            let heights: Vec<f64> = world.iter().map(|at| height(at.x) - at.z).collect();
            let highest = heights.iter().copied().fold(f64::MIN, f64::max);
            count += 1;
            // As high as ground may be, and what lies between the sampled points.
            off += usize::from(highest.abs() > 1.2e-4);
            tilting += usize::from(!rests(&points, &heights));
        }
    }
    assert!(count > 200 && off == 0 && tilting == 0, "{off}, {tilting} of {count}");
}
