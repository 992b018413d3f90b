//! Nested placements: found in the concave M, where random planes find none, and held by friction
//! on both faces.

mod foot_placement_worlds;

use foot_placement_worlds::*;
use glam::{DVec2, DVec3};
use surefoot_planner::foot_placement::{
    PlacementQuery, SampleLimits, Scratch, Source, SupportedSole, Surfaces, propose_nests,
};
use surefoot_shared_types::{Pose, Shape};

const SAMPLING_ONLY: SampleLimits =
    SampleLimits { geometric_max: 0, perturbed_max: 0, sampled_max: 8_000 };

/// Two wedges whose faces rise at `angles` (right, left) from a valley along y, 0.3 wide each.
fn groove(angles: [f64; 2]) -> Vec<(Shape, Pose)> {
    let wedge = |side: f64, angle: f64| {
        let outline =
            [(0.0, -0.1), (0.0, 0.0), (side * 0.3, 0.3 * libm::tan(angle)), (side * 0.3, -0.1)];
        let points = outline
            .iter()
            .flat_map(|&(x, z)| [DVec3::new(x, -0.5, z), DVec3::new(x, 0.5, z)])
            .collect();
        (Shape::ConvexHull { points, source: None }, Pose::IDENTITY)
    };
    vec![wedge(1.0, angles[0]), wedge(-1.0, angles[1])]
}

fn friction_angle() -> f64 {
    libm::atan(MU)
}

fn nests(surfaces: &Surfaces, query: &PlacementQuery) -> Vec<SupportedSole> {
    let mut found = Vec::new();
    propose_nests(surfaces, &mut Scratch::new(surfaces.config()), query, &mut |placement| {
        found.push(placement);
        true
    });
    found
}

/// Whether two forces within friction of the faces of a symmetric or asymmetric groove carry a
/// weight above `x`: one at the valley, the other on the right face up to `far` (m along it). A
/// grid search, independent of the formula.
fn is_carried(angles: [f64; 2], x: f64, far: f64) -> bool {
    let friction = friction_angle();
    let steps = |count: i32| (0..=count).map(move |step| f64::from(step) / f64::from(count));
    steps(400).any(|share| {
        // The valley's force leans to the right by `lean`, and meets the weight's line at this
        // height.
        let lean = angles[1] - friction + 2.0 * friction * share;
        let height = x / libm::tan(lean);
        lean > 1e-3
            && height > 0.0
            && steps(100).any(|share| {
                let foot = DVec2::new(libm::cos(angles[0]), libm::sin(angles[0])) * (far * share);
                let needed = libm::atan2(foot.x - x, height - foot.y);
                needed >= 0.0 && (needed - angles[0]).abs() <= friction
            })
    })
}

#[test]
fn the_m_holds_a_sole_with_its_toes_in_the_valley() {
    let angle = 1.25 * friction_angle();
    let surfaces = surfaces(groove([angle; 2]));
    let polygon = sole();
    let query = query(&polygon, turned(0.1, 0.0, 0.1, std::f64::consts::PI));
    let found = nests(&surfaces, &query);
    assert!(!found.is_empty());
    for placement in &found {
        let pose = placement.world_from_sole;
        assert_eq!(placement.source, Source::Nested);
        assert!(
            ((pose.rotation * DVec3::Z).z - libm::cos(angle)).abs() < 1e-9,
            "it lies flat on a face"
        );
        let corners: Vec<DVec3> = polygon.iter().map(|p| pose * p.extend(0.0)).collect();
        let lowest = corners.iter().map(|p| p.x.abs()).fold(f64::INFINITY, f64::min);
        assert!(lowest < 1e-3, "its edge is {lowest} from the valley");
        assert_eq!(corners.iter().filter(|p| p.x.abs() < 1e-3).count(), 2, "a whole edge");
        assert!((placement.support.area - SOLE_AREA).abs() < 1e-6);
        let middle = corners.iter().map(|p| p.x.abs()).sum::<f64>() / 4.0;
        let far = corners.iter().map(|p| libm::hypot(p.x, p.z)).fold(0.0, f64::max);
        assert!(is_carried([angle; 2], middle, far), "friction does not hold it");
    }
    let toes_first =
        |p: &SupportedSole| (p.world_from_sole * DVec3::new(0.13, 0.0, 0.0)).x.abs() < 1e-3;
    assert!(found.iter().any(toes_first), "its toes are in the valley");
}

#[test]
fn random_planes_do_not_find_the_nest() {
    let surfaces = surfaces(groove([1.25 * friction_angle(); 2]));
    let polygon = sole();
    for object in 0..50 {
        let ideal = turned(0.02 * object as f64 - 0.5, 0.0, 0.1, 0.3 * object as f64);
        let query = PlacementQuery { limits: SAMPLING_ONLY, object, ..query(&polygon, ideal) };
        let whole = PlacementQuery { limits: SampleLimits::default(), ..query };
        assert!(first(&surfaces, &query, 1).is_empty() && first(&surfaces, &whole, 1).is_empty());
    }
}

#[test]
fn a_placement_beyond_friction_is_no_nest() {
    let polygon = sole();
    let query = query(&polygon, turned(0.1, 0.0, 0.1, std::f64::consts::PI));
    let mut held = 0;
    for step in 0..12 {
        let angles =
            [friction_angle() * (1.1 + 0.07 * f64::from(step)), 0.2 + 0.05 * f64::from(step)];
        let found = nests(&surfaces(groove(angles)), &query);
        for placement in found.iter().filter(|p| (p.world_from_sole.rotation * DVec3::Z).x < 0.0) {
            let corners: Vec<DVec3> =
                polygon.iter().map(|p| placement.world_from_sole * p.extend(0.0)).collect();
            let middle = corners.iter().map(|p| p.x).sum::<f64>() / 4.0;
            let far = corners.iter().map(|p| libm::hypot(p.x, p.z)).fold(0.0, f64::max);
            assert!(is_carried(angles, middle, far), "{angles:?}");
            held += 1;
        }
    }
    assert!(held > 0);
}

#[test]
fn one_steep_face_or_a_ridge_is_no_nest() {
    let steep = 1.25 * friction_angle();
    let polygon = sole();
    let query = query(&polygon, turned(0.1, 0.0, 0.1, 0.0));
    assert!(nests(&surfaces(ramp(steep)), &query).is_empty(), "one face");
    let gentle = 0.5 * friction_angle();
    assert!(
        nests(&surfaces(groove([gentle; 2])), &query).is_empty(),
        "faces that hold by themselves are for the other proposals"
    );
    let roof = (Shape::ConvexHull { points: roof(steep), source: None }, Pose::IDENTITY);
    assert!(nests(&surfaces(vec![roof]), &query).is_empty(), "a ridge is convex");
}

/// A roof along y.
fn roof(angle: f64) -> Vec<DVec3> {
    let outline = [(-0.3, -0.3 * libm::tan(angle)), (0.0, 0.0), (0.3, -0.3 * libm::tan(angle))];
    outline.iter().flat_map(|&(x, z)| [DVec3::new(x, -0.5, z), DVec3::new(x, 0.5, z)]).collect()
}

#[test]
fn nests_stay_within_the_query_and_are_reproducible() {
    let surfaces = surfaces(groove([1.25 * friction_angle(), 0.4]));
    let polygon = sole();
    let near = PlacementQuery {
        reach_xy: 0.1,
        yaw_spread: 0.5,
        ..query(&polygon, turned(0.1, 0.1, 0.1, std::f64::consts::PI))
    };
    let found = nests(&surfaces, &near);
    assert!(!found.is_empty());
    for placement in &found {
        let moved = placement.world_from_sole.translation - near.ideal.translation;
        assert!(moved.truncate().length() <= 0.1 + 1e-6);
    }
    assert_eq!(found, nests(&surfaces, &near));
    let blocked = PlacementQuery { is_free: &|_| false, ..near };
    assert!(nests(&surfaces, &blocked).is_empty());
    let broken = PlacementQuery { ideal: at(f64::NAN, 0.0, 0.0), ..near };
    assert!(nests(&surfaces, &broken).is_empty());
}
