use super::*;
use crate::check_robot::randoms;
use crate::statics::sole_support::ContactPoint;

fn sole(limb: usize, middle: DVec3, normal: DVec3) -> SoleSupport {
    let corners = [(0.1, 0.05), (-0.1, 0.05), (-0.1, -0.05), (0.1, -0.05)];
    let (across, along) = (DVec3::X - DVec3::X.dot(normal) * normal, normal.cross(DVec3::X));
    let points = corners.map(|(x, y)| ContactPoint {
        position: middle + x * across + y * along,
        normal: normal.normalize(),
    });
    SoleSupport { limb, area: 0.02, deepest: 0.0, points: points.to_vec() }
}

/// By the definition, with one program per direction.
fn furthest_by_definition(generators: &[Generator], direction: DVec2) -> f64 {
    let count = generators.len();
    let mut equalities = balance_rows(generators, DVec3::ZERO);
    equalities.iter_mut().for_each(|(row, _)| row.extend([0.0, 0.0]));
    (equalities[3].0[count + 1], equalities[4].0[count]) = (-1.0, 1.0);
    let cost: Vec<f64> = (0..count).map(|_| 0.0).chain([-direction.x, -direction.y]).collect();
    let x = ConvexProgram {
        cost,
        square_cost: 0.0,
        nonnegative: count,
        equalities,
        inequalities: Vec::new(),
    }
    .solve()
    .unwrap();
    DVec2::new(x[count], x[count + 1]).dot(direction)
}

#[test]
fn the_region_agrees_with_the_interior_point_method() {
    let equilibrium = Equilibrium::new(0.6);
    let tilted = DVec3::new(0.2, 0.1, 1.0);
    for supports in [
        vec![sole(0, DVec3::new(1.0, 0.1, 0.0), DVec3::Z)],
        vec![
            sole(0, DVec3::new(1.0, 0.1, 0.0), DVec3::Z),
            sole(1, DVec3::new(1.3, -0.1, 0.0), DVec3::Z),
        ],
        vec![
            sole(0, DVec3::new(1.0, 0.1, 0.3), tilted),
            sole(1, DVec3::new(1.3, -0.1, 0.0), DVec3::Z),
        ],
        // As rays measure it: heights and normals off by rounding.
        vec![
            sole(0, DVec3::new(1.0, 0.1, 2e-9), DVec3::new(1e-9, -3e-9, 1.0)),
            sole(1, DVec3::new(1.3, -0.1, 0.0), DVec3::Z),
        ],
    ] {
        let generators = equilibrium.generators(&supports, ALL_FRICTION);
        let region = region_of(&generators);
        for direction in (0..45).map(|k| polygon::direction(k, 45)) {
            let reach =
                region.iter().map(|corner| corner.dot(direction)).fold(f64::NEG_INFINITY, f64::max);
            let wanted = furthest_by_definition(&generators, direction);
            assert!(
                reach < wanted + 1e-7 && reach > wanted - 2e-6,
                "{direction}: {reach} {wanted}"
            );
        }
    }
}

/// Two soles on slopes drawn at random.
fn random_generators(seed: u64) -> Vec<Generator> {
    generators_on_slopes(seed, 0.1)
}

fn generators_on_slopes(seed: u64, slope: f64) -> Vec<Generator> {
    let mut random = randoms(seed);
    let mut vector = |size: f64, z: f64| {
        DVec3::new(random(-size, size), random(-size, size), z + random(-size, size))
    };
    let supports = [0, 1].map(|limb| {
        let middle = DVec3::new(0.8, 0.4 * limb as f64, 0.0) + vector(0.05, 0.0);
        sole(limb, middle, vector(slope, 1.0).normalize())
    });
    Equilibrium::new(0.6).generators(&supports, ALL_FRICTION)
}

/// Two soles whose 16 contact points lie on domes: the region has many corners.
fn generators_on_domes(seed: u64) -> Vec<Generator> {
    let mut random = randoms(seed);
    let supports = [0, 1].map(|limb| {
        let middle = DVec3::new(0.8 + 0.3 * limb as f64, 0.4 * limb as f64, random(0.0, 0.2));
        let points = (0..16).map(|k| {
            let out = polygon::direction(k, 16).extend(0.0);
            let normal = (DVec3::Z + random(0.1, 0.4) * out).normalize();
            ContactPoint { position: middle + 0.1 * out, normal }
        });
        SoleSupport { limb, area: 0.03, deepest: 0.0, points: points.collect() }
    });
    Equilibrium::new(0.3).generators(&supports, ALL_FRICTION)
}

/// Shares of the weight, of which the forces of `generators` sum to about one weight.
fn random_shares(generators: &[Generator], seed: u64) -> Vec<f64> {
    let mut random = randoms(seed);
    generators.iter().map(|_| random(0.0, 2.0) / generators.len() as f64).collect()
}

#[test]
fn generators_are_the_edges_of_a_pyramid_about_each_normal() {
    let normals = [DVec3::Z, DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.2, -0.3, 1.0).normalize()];
    for (normal, share) in normals.into_iter().zip([1.0, 0.5, 0.25]) {
        let supports = [sole(1, DVec3::new(0.3, 0.2, 0.1), normal), sole(0, DVec3::ZERO, normal)];
        let generators = Equilibrium::new(0.6).generators(&supports, share);
        let points = supports.iter().flat_map(|s| s.points.iter().map(|point| (s.limb, point)));
        assert_eq!(generators.len(), 8 * PYRAMID_SIDES);
        for ((limb, point), edges) in points.zip(generators.chunks(PYRAMID_SIDES)) {
            assert!(edges.iter().all(|edge| edge.limb == limb && edge.point == point.position));
            let tangents: Vec<DVec3> = edges.iter().map(|edge| edge.force - normal).collect();
            for (index, tangent) in tangents.iter().enumerate() {
                assert!((tangent.length() - 0.6 * share).abs() < 1e-12);
                assert!(tangent.dot(normal).abs() < 1e-12);
                let next = tangents[(index + 1) % PYRAMID_SIDES];
                let angle = tangent.angle_between(next).to_degrees();
                assert!((angle - 45.0).abs() < 1e-6, "{angle}");
            }
        }
    }
}

#[test]
fn the_rows_of_a_balance_hold_for_the_forces_that_exert_the_wrench() {
    for seed in 0..20 {
        let generators = random_generators(seed);
        let shares = random_shares(&generators, seed + 100);
        let forces =
            || generators.iter().zip(&shares).map(|(g, share)| (g.point, *share * g.force));
        let force: DVec3 = forces().map(|(_, force)| force).sum();
        let torque: DVec3 = forces().map(|(at, force)| at.cross(force)).sum();
        let rows = wrench_balance(&generators, force, torque);
        assert!(rows.len() == 6 && is_balanced(&rows, &shares));
        // Each of the six numbers counts.
        for axis in 0..3 {
            let [push, turn] = [DVec3::AXES[axis] * 2e-6; 2];
            assert!(!is_balanced(&wrench_balance(&generators, force + push, torque), &shares));
            assert!(!is_balanced(&wrench_balance(&generators, force, torque + turn), &shares));
        }
        // The weight at a centre of mass is such a wrench.
        let centre = DVec3::new(0.7, -0.2, 0.9);
        let weight = wrench_balance(&generators, DVec3::Z, centre.cross(DVec3::Z));
        for ((row, right), (other, other_right)) in balance(&generators, centre).iter().zip(&weight)
        {
            assert!(row == other && (right - other_right).abs() < 1e-12, "{right} {other_right}");
        }
    }
    assert!(!is_balanced(&[(vec![1.0], 1.0)], &[f64::NAN]));
}

#[test]
fn a_region_reaches_as_far_as_some_forces_hold() {
    let mut refined = 0;
    for seed in 0..10 {
        let generators =
            if seed < 5 { generators_on_slopes(seed, 0.4) } else { generators_on_domes(seed) };
        let region = region_of(&generators);
        let mut furthest = FurthestCentre::new(&generators);
        refined += usize::from(region.len() > INITIAL_DIRECTIONS);
        for direction in (0..90).map(|k| polygon::direction(k, 90)) {
            let reach = region.iter().map(|corner| corner.dot(direction)).fold(-9.0, f64::max);
            let wanted = furthest.along(direction).unwrap().dot(direction);
            assert!((wanted - reach).abs() < 2e-6, "{direction}: {reach} {wanted}");
        }
    }
    assert!(refined > 4, "{refined}");
}

#[test]
fn both_methods_find_the_furthest_centre_of_mass() {
    for seed in 0..10 {
        let mut furthest = FurthestCentre::new(&random_generators(seed));
        for direction in (0..7).map(|k| polygon::direction(k, 7)) {
            let by_simplex = furthest.along(direction).unwrap();
            let simplex = furthest.simplex.take();
            let by_interior_point = furthest.along(direction).unwrap();
            furthest.simplex = simplex;
            let apart = (by_simplex - by_interior_point).dot(direction);
            assert!(apart.abs() < 1e-5, "{direction}: {by_simplex} {by_interior_point}");
            assert!(furthest.simplex.is_some());
        }
    }
}

/// The first share is the largest one without forces, upwards or downwards, or it is nothing
/// without them.
fn with_large_first(mut shares: Vec<Row>, seed: u64) -> Vec<Row> {
    shares[0].1 = [1.5, -1.5, 0.0][(seed % 3) as usize];
    shares
}

/// The largest share of a limit that forces need.
fn largest_share(shares: &[Row], forces: &[f64]) -> f64 {
    shares.iter().map(|(row, offset)| (offset + dot(row, forces)).abs()).fold(0.0, f64::max)
}

#[test]
fn no_other_forces_need_a_smaller_share_than_those_of_either_method() {
    let mut random = randoms(11);
    for seed in 0..20 {
        let generators = random_generators(seed);
        let centre = DVec3::new(0.8, 0.2, 0.9);
        let shares: Vec<Row> = (0..6)
            .map(|_| (generators.iter().map(|_| random(-2.0, 2.0)).collect(), random(-1.0, 1.0)))
            .collect();
        let shares = with_large_first(shares, seed);
        let program = MinimaxEffort::new(&generators, centre, shares.clone());
        let found = [program.by_simplex().unwrap(), program.by_interior_point().unwrap()];
        let rows = balance(&generators, centre);
        let [by_simplex, by_interior_point] = found.each_ref().map(|forces| {
            assert!(forces.len() == generators.len() && is_balanced(&rows, forces));
            assert!(forces.iter().all(|force| *force >= 0.0));
            largest_share(&shares, forces)
        });
        assert!((by_simplex - by_interior_point).abs() < 1e-5, "{by_simplex} {by_interior_point}");
        // Other forces in balance: the corners that some costs prefer, and mixtures of them.
        let mut simplex = Simplex::at_vertex(&rows, &[]).unwrap();
        for _ in 0..30 {
            let cost: Vec<f64> = generators.iter().map(|_| random(0.0, 1.0)).collect();
            let other = simplex.minimise(&cost).unwrap();
            let part = random(0.0, 1.0);
            let mixed: Vec<f64> =
                found[0].iter().zip(&other).map(|(a, b)| a + part * (b - a)).collect();
            assert!(largest_share(&shares, &mixed) > by_simplex - 1e-9);
        }
        let elsewhere = MinimaxEffort::with_balance(
            wrench_balance(&generators, DVec3::new(0.0, 0.0, -1.0), DVec3::ZERO),
            shares,
        );
        assert!(elsewhere.by_simplex().is_none() && elsewhere.by_interior_point().is_none());
    }
}

#[test]
fn where_forces_have_little_freedom_both_methods_agree_too() {
    let mut random = randoms(12);
    for _ in 0..200 {
        let mut point = || DVec3::new(random(-0.1, 0.1), random(-0.1, 0.1), 0.0);
        let generators: Vec<Generator> =
            (0..5).map(|_| Generator { limb: 0, point: point(), force: DVec3::Z }).collect();
        let shares: Vec<f64> = generators.iter().map(|_| random(0.1, 1.0)).collect();
        let weighted = generators.iter().zip(&shares).map(|(g, share)| *share * g.point);
        let centre = weighted.sum::<DVec3>() / shares.iter().sum::<f64>();
        let shares: Vec<Row> = (0..3)
            .map(|_| (generators.iter().map(|_| random(-5.0, 5.0)).collect(), random(-3.0, 3.0)))
            .collect();
        let program = MinimaxEffort::new(&generators, centre, shares.clone());
        let found = [program.by_simplex().unwrap(), program.by_interior_point().unwrap()];
        let [by_simplex, by_interior_point] =
            found.each_ref().map(|forces| largest_share(&shares, forces));
        assert!((by_simplex - by_interior_point).abs() < 1e-5, "{by_simplex} {by_interior_point}");
    }
}

#[test]
fn shares_far_above_all_limits_are_minimised_too() {
    // Two points carry half of the weight each, whatever they load.
    let at = |x: f64| Generator { limb: 0, point: DVec3::new(x, 0.0, 0.0), force: DVec3::Z };
    let program = |share: f64, offset: f64| {
        let shares = vec![(vec![share, share], offset), (vec![20.0, -20.0], 0.0)];
        MinimaxEffort::new(&[at(0.1), at(-0.1)], DVec3::ZERO, shares)
    };
    let is_even = |forces: Vec<f64>| forces.iter().all(|force| (force - 0.5).abs() < 1e-6);
    for share in [6.0, -6.0] {
        assert!(program(share, share).by_simplex().is_some_and(is_even), "{share}");
        assert!(program(share, 0.0).by_simplex().is_some_and(is_even), "{share}");
        let far = program(10.0 * share, share);
        assert!(far.by_interior_point().is_some_and(is_even), "{share}");
    }
}

#[test]
fn a_region_is_that_of_its_contacts_and_of_its_share_of_friction() {
    let mut equilibrium = Equilibrium::new(0.6);
    let slope = DVec3::new(0.0, 0.55, 1.0).normalize();
    let facing = DVec3::new(slope.x, -slope.y, slope.z);
    let pair = [sole(0, DVec3::ZERO, slope), sole(1, DVec3::new(0.4, 0.3, 0.1), facing)];
    let shares = [1.0, 0.5, 1.0, 0.8];
    for share in shares {
        let generators = equilibrium.generators(&pair, share);
        let region = equilibrium.region(&pair, share);
        assert_eq!(region.equilibrium, region_of(&generators), "{share}");
        assert_eq!(region, equilibrium.region(&pair, share));
    }
    let areas = shares.map(|share| polygon::area(&equilibrium.region(&pair, share).equilibrium));
    assert!(areas[1] < areas[3] && areas[3] < areas[0], "{areas:?}");
    let moved = [pair[0].clone(), sole(1, DVec3::new(0.5, 0.3, 0.1), DVec3::Z)];
    assert_ne!(equilibrium.region(&moved, 1.0), equilibrium.region(&pair, 1.0));
}

#[test]
fn a_region_needs_all_of_its_contacts() {
    let mut equilibrium = Equilibrium::new(0.6);
    let stands = sole(0, DVec3::new(1.0, 0.2, 0.0), DVec3::Z);
    let region = equilibrium.region(std::slice::from_ref(&stands), 1.0);
    let corners = [(0.9, 0.15), (1.1, 0.15), (1.1, 0.25), (0.9, 0.25)].map(DVec2::from);
    assert_eq!(region.hull.len(), 4);
    assert!(corners.iter().zip(&region.hull).all(|(a, b)| a.distance(*b) < 1e-12));
    // On a level sole the region is the sole; the margin is that of the nearer edge of both.
    assert!((region.margin(DVec3::new(1.02, 0.2, 0.7)) - 0.05).abs() < 1e-6);
    assert!((region.margin(DVec3::new(1.2, 0.2, 0.7)) + 0.1).abs() < 1e-6);
    let narrow = Region { hull: corners.map(|at| 0.5 * (at + corners[0])).to_vec(), ..region };
    assert!((narrow.margin(DVec3::new(0.99, 0.16, 0.0)) - 0.01).abs() < 1e-6);
    let hangs = SoleSupport { limb: 1, area: 0.0, deepest: 0.0, points: Vec::new() };
    for supports in [vec![stands, hangs], Vec::new()] {
        let region = equilibrium.region(&supports, 1.0);
        assert!(region.equilibrium.is_empty());
        assert_eq!(region.margin(DVec3::new(1.0, 0.2, 0.7)), f64::NEG_INFINITY);
    }
}
