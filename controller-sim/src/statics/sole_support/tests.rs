use glam::DQuat;
use surefoot_shared_types::Shape;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;
use surefoot_shared_types::base::spatial::rotation_from_scaled_axis;
use surefoot_shared_types::robot::model::{Foot, LinkShape};
use surefoot_shared_types::world::world::WorldShape;

use super::*;
use crate::check_robot::{at, box_of, contact, randoms, robot, world};
use crate::kinematics::forward::Posture;
use crate::statics::tuning::{FINE_SAMPLE_SPACING, STEEP_GROUND_MIN};

/// Distance by which the foot may be beside its pose in the standard configuration, m.
fn shift_max() -> f64 {
    let config = CheckerConfig::default();
    config.foot_position_max + config.foot_rotation_max * DVec2::new(0.1, 0.05).length()
}

/// A world of these shapes alone.
fn only(shapes: Vec<(Pose, Shape)>) -> World {
    let shapes = shapes.into_iter().enumerate().map(|(index, (world_from_shape, shape))| {
        WorldShape { name: format!("shape {index}"), world_from_shape, shape }
    });
    World { shapes: shapes.collect(), ..world(vec![]) }
}

fn finder(world: &World) -> SupportFinder {
    SupportFinder::new(&robot(), world, &CheckerConfig::default()).unwrap()
}

/// The feet of a posture on level ground that carries their declared soles.
pub fn level_soles(model: &RobotModel, posture: &Posture) -> Vec<SoleSupport> {
    let support = |(limb, foot): (usize, &Foot)| {
        let world_from_sole = posture.world_from_sole(model, limb);
        let position = |at: &DVec2| world_from_sole * at.extend(0.0);
        let points = foot.polygon.iter().map(position);
        let points = points.map(|position| ContactPoint { position, normal: DVec3::Z }).collect();
        SoleSupport { limb, area: polygon::area(&foot.polygon), deepest: 0.0, points }
    };
    model.feet.iter().enumerate().map(support).collect()
}

fn contact_at(pose: &Pose) -> Contact {
    Contact {
        limb: 0,
        polygon_len: 0,
        position: pose.translation.to_array(),
        rotation: pose.rotation.to_array(),
        polygon: [[0.0; 2]; POLYGON_VERTICES_MAX],
    }
}

/// A box of 2 m whose top contains this place and faces along this normal.
fn block_under(place: DVec3, normal: DVec3) -> (Pose, Shape) {
    let rotation = DQuat::from_rotation_arc(DVec3::Z, normal);
    (Pose::from_parts(place - normal, rotation), box_of(1.0, 1.0, 1.0))
}

fn turned(axis: DVec3, angle: f64) -> DQuat {
    rotation_from_scaled_axis(angle * axis)
}

#[test]
fn the_support_is_the_part_of_the_sole_that_is_surely_over_the_ground() {
    let mut random = randoms(1);
    let mut compared = 0;
    for _ in 0..60 {
        // The ground ends along a line.
        let heading = random(-3.0, 3.0);
        let outward = DVec2::new(libm::cos(heading), libm::sin(heading));
        let end = random(-0.05, 0.08);
        let rotation = turned(DVec3::Z, heading);
        let middle = ((end - 0.5) * outward).extend(-0.5);
        let ground = only(vec![(Pose::from_parts(middle, rotation), box_of(0.5, 0.5, 0.5))]);
        let sole = robot().feet[0].polygon.clone();
        let inner: Vec<DVec2> =
            sole.iter().map(|at| *at - (shift_max() + 1e-3) * at.signum()).collect();
        let kept =
            |part: &[DVec2], lost: f64| polygon::area(&polygon::clip(part, outward, end - lost));
        // Beside the sole there is no foot that could miss the ground.
        let surely_lost = kept(&inner, 0.0) - kept(&inner, shift_max() - 1e-3);
        let (least, most) = (kept(&sole, shift_max() + 3e-3), kept(&sole, 0.0) - surely_lost);
        let found = finder(&ground).find(&contact_at(&Pose::IDENTITY), 0.8);
        assert!(
            (least - 2e-5..=most + 1e-4).contains(&found.area),
            "{outward} {end}: {} not in {least}..{most}",
            found.area
        );
        assert!(found.deepest == 0.0 || found.deepest.abs() < 1e-12);
        for point in &found.points {
            assert!(
                point.position.z.abs() < 1e-9 && point.normal.distance(DVec3::Z) < 1e-9,
                "{point:?}"
            );
            let at = point.position.truncate();
            assert!(polygon::margin(&sole, at) > -1e-9);
            let is_lost = outward.dot(at) > end - shift_max() + 1e-3;
            assert!(!is_lost || polygon::margin(&inner, at) < 0.0, "{at} {end}");
        }
        let corners: Vec<DVec2> =
            found.points.iter().map(|point| point.position.truncate()).collect();
        assert!((polygon::area(&polygon::hull(&corners)) - found.area).abs() < 1e-9);
        compared += usize::from(most > least && least > 1e-3);
    }
    assert!(compared > 30, "{compared}");
}

#[test]
fn the_depth_is_that_of_the_deepest_ground() {
    for (height, expected) in [(0.0, 0.0), (0.002, -0.002), (-0.0015, 0.0015), (0.019, -0.019)] {
        let pose = Pose::from_translation(DVec3::new(0.3, -0.2, height));
        let support = finder(&world(vec![])).find(&contact_at(&pose), 0.8);
        assert!((support.deepest - expected).abs() < 1e-12, "{height}: {}", support.deepest);
        assert!((support.area - 0.02).abs() < 2e-5, "{height}: {}", support.area);
        assert_eq!(support.points.len(), 4);
        for point in &support.points {
            assert!(point.position.z.abs() < 1e-12, "{point:?}");
            let corner = (point.position - pose.translation).truncate().abs();
            assert!(corner.distance(DVec2::new(0.1, 0.05)) < 2e-5, "{corner}");
        }
    }
    // Deep inside, and so far below that no ray reaches it.
    let of_height = |height: f64| {
        let pose = Pose::from_translation(height * DVec3::Z);
        finder(&world(vec![])).find(&contact_at(&pose), 0.8)
    };
    assert_eq!(of_height(-0.05).deepest, RAY_START);
    let void = of_height(0.0201);
    assert_eq!((void.area, void.deepest, void.points.len()), (0.0, f64::NEG_INFINITY, 0));
    // A stud of 4 mm under the middle.
    let stud = only(vec![
        (at(0., 0., -0.5), box_of(1.0, 1.0, 0.5)),
        (at(0.02, 0.01, 0.0), box_of(0.006, 0.006, 0.004)),
    ]);
    let support = finder(&stud).find(&contact_at(&Pose::IDENTITY), 0.8);
    assert!((support.deepest - 0.004).abs() < 1e-12 && support.area < 1e-4, "{support:?}");
}

#[test]
fn a_ray_measures_the_air_the_normal_and_the_slope_of_a_plane() {
    let mut random = randoms(2);
    let config = CheckerConfig::default();
    for _ in 0..300 {
        let mut small = |size: f64| DVec3::from_array([0; 3].map(|_| random(-size, size)));
        let pose = Pose::from_parts(small(0.3), turned(small(0.5), 1.0));
        let up = pose.rotation * DVec3::Z;
        let normal = (up + small(0.15)).normalize();
        let place = pose.translation + small(0.01);
        let ground = only(vec![block_under(place, normal)]);
        let finder = finder(&ground);
        let targets: Vec<&Target> = finder.targets.iter().collect();
        let height = 0.5 * small(0.01).x;
        let point = SolePoint { at: small(0.08).truncate(), height };
        let sample = finder.sample(&targets, &pose, point);
        let origin = pose * point.at.extend(height);
        let air = (origin - place).dot(normal) / up.dot(normal);
        if air <= -RAY_START {
            assert!((sample.air + RAY_START).abs() < 1e-12);
            continue;
        }
        if air > RAY_START {
            assert!(sample.air == f64::INFINITY && !sample.is_carrying);
            continue;
        }
        assert!((sample.air - air).abs() < 1e-9, "{} {air}", sample.air);
        assert!(sample.normal.distance(normal) < 1e-9);
        // Along the plane of the sole the air grows by the slope of the ground.
        for direction in [DVec2::X, DVec2::Y] {
            let beside = SolePoint { at: point.at + 1e-4 * direction, height };
            let other = finder.sample(&targets, &pose, beside);
            let slope = (other.air - sample.air) / 1e-4;
            assert!((sample.gradient.dot(direction) - slope).abs() < 1e-6, "{slope}");
        }
        let tilt = normal.angle_between(up);
        let slope = normal.angle_between(DVec3::Z);
        let carries = tilt <= config.contact_tilt_max && slope <= libm::atan(0.6);
        assert_eq!(sample.is_carrying, carries, "{tilt} {slope}");
        let growth = if carries { shift_max() * libm::tan(tilt) } else { 0.0 };
        assert!((sample.most_air - sample.air - growth).abs() < 1e-9);
    }
}

#[test]
fn the_nearest_of_several_shapes_is_the_ground() {
    let shapes = vec![
        (at(0., 0., -0.105), box_of(0.3, 0.3, 0.1)),
        (at(0., 0., -0.102), box_of(0.3, 0.3, 0.1)),
        (at(0., 0., -0.110), box_of(0.3, 0.3, 0.1)),
    ];
    let finder = finder(&only(shapes));
    let targets: Vec<&Target> = finder.targets.iter().collect();
    let point = SolePoint { at: DVec2::new(0.01, 0.02), height: 0.001 };
    assert!((finder.sample(&targets, &Pose::IDENTITY, point).air - 0.003).abs() < 1e-12);
}

#[test]
fn ground_carries_up_to_the_angle_of_friction() {
    let limit = libm::atan(0.6);
    for (angle, carries) in [(limit - 1e-3, true), (limit + 1e-3, false)] {
        let rotation = turned(DVec3::X, angle);
        let ground = only(vec![block_under(DVec3::ZERO, rotation * DVec3::Z)]);
        let pose = Pose::from_parts(DVec3::ZERO, rotation);
        let support = finder(&ground).find(&contact_at(&pose), 0.0);
        assert_eq!(support.area > 0.019, carries, "{}", support.area);
    }
}

/// Ground of steps, bumps and slopes.
fn uneven(random: &mut impl FnMut(f64, f64) -> f64) -> World {
    let mut shapes = vec![(at(0., 0., -0.5), box_of(1.0, 1.0, 0.499))];
    for _ in 0..12 {
        let tilt = DVec3::new(random(-0.06, 0.06), random(-0.06, 0.06), random(-3.0, 3.0));
        let place = DVec3::new(random(-0.1, 0.1), random(-0.1, 0.1), random(-0.022, -0.019));
        let pose = Pose::from_parts(place, turned(tilt, 1.0));
        shapes.push((pose, box_of(random(0.01, 0.06), random(0.01, 0.06), 0.02)));
    }
    only(shapes)
}

#[test]
fn the_most_air_is_that_of_all_places_that_the_foot_may_miss() {
    let mut random = randoms(3);
    for _ in 0..6 {
        let finder = finder(&uneven(&mut random));
        let underside = &finder.undersides[0];
        let samples = finder.ray_samples(underside, &Pose::IDENTITY);
        let targets: Vec<&Target> = finder.targets.iter().collect();
        let direct =
            |at: DVec2| finder.sample(&targets, &Pose::IDENTITY, SolePoint { at, height: 0.0 });
        let coarse = underside.coarse.len() + underside.edges.len();
        assert!(samples.len() > coarse, "{} {coarse}", samples.len());
        let grid = underside.fine();
        let is_foot = |index: &usize| grid.is_foot(*index);
        let all: Vec<RaySample> =
            (0..grid.len()).map(|index| direct(grid.point(index).at)).collect();
        for sample in &samples {
            let here = direct(sample.point.at);
            assert_eq!(sample.air, here.air);
            // Whatever lies in its place and may be missed is known, or the sample lies in a plane.
            let near: Vec<&RaySample> =
                grid.within(sample.point.at).filter(is_foot).map(|index| &all[index]).collect();
            let most = near.iter().map(|other| other.air).fold(sample.air, f64::max);
            assert!(sample.most_air >= most - 1e-5, "{} {most}", sample.most_air);
            if sample.most_air.is_finite() {
                // Between the grid's last point and the end of the reach a slope goes on, by half a
                // cell. The ground beside the sole counts as well.
                let deepest = |other: &RaySample| {
                    let slope = Some(other.gradient.length()).filter(|it| *it < STEEP_GROUND_MIN);
                    other.air + 0.5 * FINE_SAMPLE_SPACING * slope.unwrap_or(0.0)
                };
                let around = grid.within(sample.point.at).map(|index| deepest(&all[index]));
                let most = around.fold(most.max(here.most_air), f64::max);
                assert!(sample.most_air <= most + 1e-9, "{} {most}", sample.most_air);
            }
            let may_carry = here.is_carrying || near.iter().any(|other| other.is_carrying);
            assert!(!sample.is_carrying || may_carry && sample.air.is_finite());
            assert!(sample.is_carrying || !here.is_carrying);
        }
        // Around coarse samples where the ground is near and no plane, all of it is known.
        let of_coarse = &samples[samples.len() - coarse..];
        let least = least_air(of_coarse);
        for (near, neighbours) in of_coarse.iter().zip(underside.neighbours()) {
            let is_plane = neighbours.iter().all(|&other| near.is_in_plane(&of_coarse[other]));
            if is_plane || near.air > least + NEAR_AIR_MAX {
                continue;
            }
            for index in grid.around([near.point.at].into_iter(), 0.5 * SAMPLE_SPACING) {
                let at = grid.point(index).at;
                assert!(samples.iter().any(|sample| sample.point.at == at), "{at}");
            }
        }
    }
}

#[test]
fn even_ground_and_a_void_need_no_fine_samples() {
    let coarse = |finder: &SupportFinder| {
        let underside = &finder.undersides[0];
        underside.coarse.len() + underside.edges.len()
    };
    let floor = finder(&world(vec![]));
    let samples = floor.ray_samples(&floor.undersides[0], &Pose::IDENTITY);
    assert_eq!(samples.len(), coarse(&floor));
    let void = finder(&only(vec![(at(5., 0., 0.), box_of(1.0, 1.0, 1.0))]));
    let samples = void.ray_samples(&void.undersides[0], &Pose::IDENTITY);
    assert_eq!(samples.len(), coarse(&void));
    assert!(samples.iter().all(|sample| sample.air == f64::INFINITY && !sample.is_carrying));
    // On a slope each sample knows the plane around it; the foot touches along one edge.
    let slope = only(vec![block_under(DVec3::ZERO, turned(DVec3::Y, 0.05) * DVec3::Z)]);
    let slope = finder(&slope);
    let samples = slope.ray_samples(&slope.undersides[0], &Pose::IDENTITY);
    assert_eq!(samples.len(), coarse(&slope));
    let least = least_air(&samples);
    for sample in samples.iter().filter(|sample| sample.air < least + 2.5e-3) {
        let growth = shift_max() * libm::tan(0.05);
        assert!((sample.most_air - sample.air - growth).abs() < 1e-6, "{:?}", sample.point);
    }
}

#[test]
fn samples_lie_in_a_plane_if_their_air_grows_as_it_does() {
    let sample = RaySample {
        point: SolePoint { at: DVec2::new(0.01, 0.02), height: 0.0 },
        air: 0.003,
        most_air: 0.0,
        normal: DVec3::Z,
        gradient: DVec2::new(0.1, -0.2),
        is_carrying: true,
        is_round: false,
    };
    let beside = |air: f64| {
        let point = SolePoint { at: DVec2::new(0.015, 0.022), ..sample.point };
        RaySample { point, air: 0.003 + 0.0005 - 0.0004 + air, gradient: DVec2::ZERO, ..sample }
    };
    assert!(sample.is_in_plane(&beside(0.0)));
    assert!(sample.is_in_plane(&beside(0.9e-7)) && sample.is_in_plane(&beside(-0.9e-7)));
    assert!(!sample.is_in_plane(&beside(1.1e-7)) && !sample.is_in_plane(&beside(-1.1e-7)));
    assert!(!sample.is_in_plane(&RaySample { is_carrying: false, ..beside(0.0) }));
    let raised = SolePoint { height: 0.001, ..beside(0.0).point };
    assert!(!sample.is_in_plane(&RaySample { point: raised, ..beside(0.0) }));
}

#[test]
fn a_finder_answers_again_as_at_first() {
    let mut random = randoms(4);
    let ground = uneven(&mut random);
    let mut kept = finder(&ground);
    let poses: Vec<Pose> = (0..4)
        .map(|_| {
            let turn = turned(DVec3::Z, random(-0.5, 0.5));
            Pose::from_parts(DVec3::new(random(-0.05, 0.05), 0.0, 0.0), turn)
        })
        .collect();
    let mut areas = Vec::new();
    for height in [0.8, 0.2, 0.8, 0.78, 0.21, -0.3] {
        for pose in poses.iter().chain(&poses[..2]) {
            let found = kept.find(&contact_at(pose), height);
            assert_eq!(found, finder(&ground).find(&contact_at(pose), height));
            areas.push(found.area);
        }
    }
    assert!(areas.iter().any(|area| *area > 1e-3), "{areas:?}");
    // The other foot has its own cache.
    let right = Contact { limb: 1, ..contact_at(&poses[0]) };
    assert_eq!(kept.find(&right, 0.8).limb, 1);
    assert_eq!(kept.find(&contact_at(&poses[0]), 0.8).limb, 0);
}

#[test]
fn heights_are_rounded_up() {
    let dome = only(vec![(at(0., 0., -4.0), Shape::Sphere { radius: 4.0 })]);
    let area = |height: f64| finder(&dome).find(&contact_at(&Pose::IDENTITY), height).area;
    let areas = [0.0, 0.5, 1.0, 1.5].map(area);
    assert!(areas.windows(2).all(|pair| pair[0] > pair[1]), "{areas:?}");
    assert_eq!(area(0.96), area(1.0));
    assert_eq!(area(0.951), area(1.0));
    assert!(area(0.949) > area(1.0));
    assert_eq!(area(-1.0), area(0.0));
}

#[test]
fn ground_under_a_raised_part_of_the_foot_is_touched_by_that_part() {
    // The toe half of the foot is 5 mm higher, and so is the ground there.
    let mut model = robot();
    let foot = |x: f64, height: f64| LinkShape {
        link_from_shape: at(x, 0., -0.9 + 0.02 + height),
        shape: box_of(0.05, 0.05, 0.02),
    };
    model.links[1].shapes = vec![foot(-0.05, 0.0), foot(0.05, 0.005)];
    let step = |height: f64| {
        only(vec![
            (at(-0.5, 0., -0.5), box_of(0.5, 1.0, 0.5)),
            (at(0.501, 0., -0.5 + height), box_of(0.5, 1.0, 0.5)),
        ])
    };
    let support = |height: f64| {
        let world = step(height);
        let mut finder = SupportFinder::new(&model, &world, &CheckerConfig::default()).unwrap();
        finder.find(&contact_at(&Pose::IDENTITY), 0.8)
    };
    let fits = support(0.005);
    assert!(fits.deepest.abs() < 1e-9 && fits.area > 0.018, "{fits:?}");
    let highest = fits.points.iter().map(|point| point.position.z).fold(0.0, f64::max);
    assert!((highest - 0.005).abs() < 1e-9, "{highest}");
    let gap = support(0.0);
    assert!(gap.deepest.abs() < 1e-9 && gap.area < 0.0101, "{gap:?}");
    assert!((support(0.008).deepest - 0.003).abs() < 1e-9);
}

#[test]
fn a_foot_of_lying_cylinders_stands_on_their_lowest_lines() {
    let along_x = turned(DVec3::Y, std::f64::consts::FRAC_PI_2);
    for (radius, y) in [(0.02, 0.03), (0.01, 0.0405), (0.005, 0.0)] {
        let mut model = robot();
        let foot = |y: f64| LinkShape {
            link_from_shape: Pose::from_parts(DVec3::new(0.0, y, -0.9 + radius), along_x),
            shape: Shape::Cylinder { radius, half_length: 0.1 },
        };
        model.links[1].shapes = vec![foot(y), foot(-y)];
        for tilt in [0.0, 0.1] {
            let rotation = turned(DVec3::Y, tilt);
            let ground = only(vec![block_under(DVec3::ZERO, rotation * DVec3::Z)]);
            let config = CheckerConfig::default();
            let mut finder = SupportFinder::new(&model, &ground, &config).unwrap();
            let pose = Pose::from_parts(DVec3::ZERO, rotation);
            let support = finder.find(&contact_at(&pose), 0.8);
            let (least, most) = (0.199 * 2.0 * (y - 1e-3), 0.2 * 2.0 * (y + 1e-3));
            assert!((least..most).contains(&support.area), "{radius} {y}: {support:?}");
        }
    }
}

#[test]
fn both_feet_are_measured_on_their_own_soles() {
    let mut model = robot();
    model.feet[1].polygon =
        [(-0.05, -0.05), (0.05, -0.05), (0.05, 0.05), (-0.05, 0.05)].map(DVec2::from).to_vec();
    let mut finder = SupportFinder::new(&model, &world(vec![]), &CheckerConfig::default()).unwrap();
    let areas = [0, 1].map(|limb| finder.find(&contact(limb), 0.8).area);
    assert!((areas[0] - 0.02).abs() < 2e-5 && (areas[1] - 0.01).abs() < 2e-5, "{areas:?}");
    assert_eq!(finder.undersides().len(), 2);
}

#[test]
fn ribs_that_the_foot_may_miss_do_not_carry_on_a_slope_either() {
    let tilt = turned(DVec3::Y, 3.5e-3);
    let slope = |half: DVec3, place: DVec3| {
        (Pose::from_parts(tilt * place, tilt), box_of(half.x, half.y, half.z))
    };
    // A block under the middle, ribs under both ends, and a floor 10 mm below.
    let area = |rib_half: f64| {
        let rib = |x: f64| slope(DVec3::new(rib_half, 0.5, 0.05), DVec3::new(x, 0.0, -0.05));
        let block = slope(DVec3::new(0.03, 0.5, 0.05), DVec3::new(0.0, 0.0, -0.05));
        let floor = slope(DVec3::new(0.5, 0.5, 0.1), DVec3::new(0.0, 0.0, -0.11));
        let ground = only(vec![block, rib(-0.08), rib(0.08), floor]);
        finder(&ground).find(&contact_at(&Pose::IDENTITY), 0.0).area
    };
    let (thin, wide) = (area(1.4e-3), area(6e-3));
    assert!(thin > 0.004 && thin < 0.006 && wide > 0.013, "{thin} {wide}");
}

/// Samples of even ground 2 mm under a sole, and these on top of it: air, most air and place.
fn samples_with(more: &[(f64, f64, DVec2)], is_carrying: bool) -> Vec<RaySample> {
    let sample = |air: f64, most_air: f64, at: DVec2, is_carrying: bool| RaySample {
        point: SolePoint { at, height: 0.0 },
        air,
        most_air,
        normal: DVec3::Z,
        gradient: DVec2::ZERO,
        is_carrying,
        is_round: false,
    };
    let grid = (-20..=20).flat_map(|x| (-10..=10).map(move |y| (x, y)));
    let even = grid.map(|(x, y)| DVec2::new(5e-3 * f64::from(x), 5e-3 * f64::from(y)));
    let even = even.map(|at| sample(2e-3, 2e-3, at, true));
    let more = more.iter().map(|&(air, most, at)| sample(air, most, at, is_carrying));
    even.chain(more).collect()
}

#[test]
fn a_sole_holds_where_it_touches_and_where_it_misses() {
    let corners = [(-0.04, -0.02), (0.05, -0.01), (0.0, 0.03)].map(DVec2::from);
    let raised = |air: f64, most: f64| corners.map(|at| (air, most, at));
    let area = |samples: Vec<RaySample>| polygon::area(&certain_region(&samples, 0.0));
    let triangle = polygon::area(&corners);
    // What the foot touches surely is all that holds.
    assert!((area(samples_with(&raised(0.0, 0.0), true)) - triangle).abs() < 1e-5);
    // The foot may miss the three points and stand on the ground: both hold inside them.
    assert!((area(samples_with(&raised(0.0, 2e-3), true)) - triangle).abs() < 1e-5);
    // Points that hold nothing, whether they may be missed or not.
    for most in [0.0, 2e-3] {
        assert_eq!(area(samples_with(&raised(0.0, most), false)), 0.0);
        assert_eq!(area(samples_with(&[(0.0, most, DVec2::ZERO)], true)), 0.0);
        assert_eq!(area(samples_with(&raised(0.0, most)[..2], true)), 0.0);
    }
    assert!((area(samples_with(&[], true)) - 0.02).abs() < 1e-9);
    let missing = raised(2e-3, f64::INFINITY);
    assert!((area(samples_with(&missing, true)) - 0.02).abs() < 1e-9);
    assert_eq!(area(Vec::new()), 0.0);
}

/// Two bars of this radius, turned by `heading`, whose top lines pass through these places.
fn bars(radius: f64, heading: f64, places: [DVec2; 2]) -> World {
    let along = turned(DVec3::Z, heading) * turned(DVec3::X, std::f64::consts::FRAC_PI_2);
    let bar = |at: DVec2| {
        (Pose::from_parts(at.extend(-radius), along), Shape::Cylinder { radius, half_length: 0.5 })
    };
    only(places.map(bar).to_vec())
}

#[test]
fn on_bars_all_lies_between_the_lines_that_a_foot_touches() {
    let mut random = randoms(5);
    let sole = robot().feet[0].polygon.clone();
    for _ in 0..40 {
        let (radius, heading) = (random(0.005, 0.06), random(-0.5, 0.5));
        let places = [random(-0.095, -0.04), random(0.04, 0.095)].map(|x| DVec2::new(x, 0.0));
        let found = finder(&bars(radius, heading, places)).find(&contact_at(&Pose::IDENTITY), 1.0);
        let across = DVec2::from_angle(heading);
        // The ends of the lines on the sole less a rim.
        let ends = |rim: f64| {
            let inner: Vec<DVec2> = sole.iter().map(|at| *at - rim * at.signum()).collect();
            let of_line = |place: DVec2| {
                let place = place.dot(across);
                let part = polygon::clip(&inner, across, place);
                let is_on_line = move |at: &DVec2| (at.dot(across) - place).abs() < 1e-9;
                part.into_iter().filter(is_on_line).collect::<Vec<_>>()
            };
            places.into_iter().flat_map(of_line).collect::<Vec<_>>()
        };
        let lines = polygon::hull(&ends(0.0));
        let corners = found.points.iter().map(|point| point.position.truncate());
        let beyond = corners.clone().map(|at| -polygon::margin(&lines, at)).fold(0.0, f64::max);
        // The edge of the sole carries beside the end of a line, with a tilt.
        assert!(beyond < 4e-3, "{radius} {heading}: {beyond}");
        let region = polygon::hull(&corners.collect::<Vec<_>>());
        let missed =
            ends(1.1e-3).iter().map(|at| -polygon::margin(&region, *at)).fold(0.0, f64::max);
        assert!(missed < 2e-4, "{radius} {heading} {places:?}: {missed}");
    }
}

#[test]
fn the_most_air_on_a_crest_is_the_same_all_along_and_that_of_the_ground_beside_the_sole() {
    for (radius, heading) in [(0.01, 0.1), (0.02, -0.3), (0.05, 0.0)] {
        let finder = finder(&bars(radius, heading, [-0.0985, 0.03].map(|x| DVec2::new(x, 0.0))));
        let samples = finder.ray_samples(&finder.undersides[0], &Pose::IDENTITY);
        let most = |samples: &[&RaySample]| {
            let all = samples.iter().map(|sample| sample.most_air);
            [all.clone().fold(f64::INFINITY, f64::min), all.fold(0.0, f64::max)]
        };
        let is_crest = |sample: &&RaySample| {
            sample.is_round && sample.air < 1e-12 && sample.most_air.is_finite()
        };
        let [least, greatest] = most(&samples.iter().filter(is_crest).collect::<Vec<_>>());
        assert!(greatest - least < 1e-9, "{radius} {heading}: {least} {greatest}");
        // Between 2 and 2.5 mm beside the crest.
        let [low, high] = [2e-3, shift_max()].map(|aside| 0.5 * aside * aside / radius);
        assert!(least > low && greatest < high * 1.1, "{low} {least} {high}");
        // No other sample has less.
        let [least_of_all, _] = most(&samples.iter().collect::<Vec<_>>());
        assert!(least_of_all > least - 1e-9, "{radius} {heading}: {least_of_all} {least}");
    }
}
