//! The queries, and who answers them.

use glam::{DVec2, DVec3};
use serde::Serialize;
use surefoot_planner::PlannerError;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::foot_placement::{
    FootPlacementConfig, PlacementQuery, SampleLimits, Scratch, SoleShape, Surfaces, propose,
    propose_nests,
};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::world::world::World;

use crate::system::clock::Stopwatch;

/// How far from the origin the ideals lie at the most, m.
const IDEALS: DVec3 = DVec3::new(0.1, 0.2, 0.05);
/// How far from its ideal a placement may be, m.
const REACH: f64 = 0.3;
/// No other limit than Algorithm 1's own three.
const UNLIMITED: u32 = u32::MAX;

/// Who answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampler {
    /// Algorithm 1 as it is printed.
    Printed,
    /// Algorithm 1 with seeded targets, seeded placements and a bound of the area that relaxes.
    Seeded,
    /// Proposals from the geometry.
    Geometry,
    /// All of it, nests included.
    Whole,
}

impl Sampler {
    /// All of them, in the order of columns.
    pub const ALL: [Self; 4] = [Self::Printed, Self::Seeded, Self::Geometry, Self::Whole];

    /// Its name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Printed => "Algorithm 1",
            Self::Seeded => "Algorithm 1, seeded",
            Self::Geometry => "geometry",
            Self::Whole => "whole sampler",
        }
    }

    /// Its name in files.
    fn key(self) -> &'static str {
        match self {
            Self::Printed => "algorithm_1",
            Self::Seeded => "algorithm_1_seeded",
            Self::Geometry => "geometry",
            Self::Whole => "whole",
        }
    }

    fn config(self) -> FootPlacementConfig {
        if self == Self::Printed {
            FootPlacementConfig::as_printed()
        } else {
            FootPlacementConfig::default()
        }
    }

    fn limits(self) -> SampleLimits {
        let alone = SampleLimits { geometric_max: 0, perturbed_max: 0, sampled_max: UNLIMITED };
        match self {
            Self::Printed | Self::Seeded => alone,
            Self::Geometry => {
                SampleLimits { sampled_max: 0, perturbed_max: 0, ..SampleLimits::default() }
            }
            Self::Whole => SampleLimits { sampled_max: UNLIMITED, ..SampleLimits::default() },
        }
    }
}

/// The results of one sampler.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct QueryResults {
    /// Who.
    pub sampler: &'static str,
    /// Queries with a placement.
    pub found: u32,
    /// Placements examined per query, mean.
    pub examined_mean: f64,
    /// Seconds per query, mean.
    pub seconds_mean: f64,
}

impl QueryResults {
    /// The share of queries with a placement.
    pub fn share(&self, queries: u32) -> f64 {
        f64::from(self.found) / f64::from(queries)
    }
}

/// Asks a sampler for a place for `sole` about ideals drawn near the origin.
///
/// # Errors
/// When the world cannot be compiled into surfaces.
pub fn run_queries(
    world: &World,
    sole: &[DVec2],
    sampler: Sampler,
    queries: u32,
    seed: u64,
) -> Result<QueryResults, PlannerError> {
    let surfaces = Surfaces::new(world, sampler.config())?;
    let mut scratch = Scratch::new(surfaces.config());
    let (mut found, mut examined) = (0, 0_u64);
    let stopwatch = Stopwatch::start();
    for query in 0..u64::from(queries) {
        let request = PlacementQuery { limits: sampler.limits(), ..request(sole, seed, query) };
        let mut stats = propose(&surfaces, &mut scratch, &request, &mut |_| false);
        examined += stats.examined.iter().map(|&count| u64::from(count)).sum::<u64>();
        if !stats.stopped && sampler == Sampler::Whole {
            stats = propose_nests(&surfaces, &mut scratch, &request, &mut |_| false);
            examined += stats.examined.iter().map(|&count| u64::from(count)).sum::<u64>();
        }
        found += u32::from(stats.stopped);
    }
    let each = 1.0 / f64::from(queries);
    Ok(QueryResults {
        sampler: sampler.key(),
        found,
        examined_mean: examined as f64 * each,
        seconds_mean: stopwatch.seconds() * each,
    })
}

/// A query, the same for every sampler and world.
fn request(sole: &[DVec2], seed: u64, query: u64) -> PlacementQuery<'_> {
    let mut random = Random::new(seed, Stream::Preparation, query, 0);
    let mut within = |reach: f64| random.uniform(-reach, reach);
    let position = DVec3::new(within(IDEALS.x), within(IDEALS.y), within(IDEALS.z));
    let heading = within(std::f64::consts::PI);
    PlacementQuery {
        sole: SoleShape::flat(sole),
        ideal: Pose::from_parts(position, rotation_about(DVec3::Z, heading)),
        reach_xy: REACH,
        reach_z: [-REACH, REACH],
        yaw_spread: std::f64::consts::PI,
        seed,
        object: query,
        attempt: 0,
        limits: SampleLimits::default(),
        is_free: &|_| true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use surefoot_shared_types::Shape;
    use surefoot_shared_types::world::world::WorldShape;

    const SOLE: [DVec2; 4] = [
        DVec2::new(-0.09, -0.07),
        DVec2::new(0.13, -0.07),
        DVec2::new(0.13, 0.07),
        DVec2::new(-0.09, 0.07),
    ];

    fn floor(tilt: f64) -> World {
        let shape = Shape::Box { half_extents: DVec3::new(2.0, 2.0, 0.1) };
        let rotation = rotation_about(DVec3::Y, tilt);
        let world_from_shape = Pose::from_parts(rotation * DVec3::new(0.0, 0.0, -0.1), rotation);
        World {
            mu: 0.6,
            shapes: vec![WorldShape { name: "floor".into(), world_from_shape, shape }],
            digest: Default::default(),
        }
    }

    #[test]
    fn every_query_succeeds_on_a_floor_and_none_on_a_steep_one() {
        for sampler in Sampler::ALL {
            assert_eq!(
                run_queries(&floor(0.0), &SOLE, sampler, 20, 1).unwrap().found,
                20,
                "{sampler:?}"
            );
            assert_eq!(
                run_queries(&floor(0.7), &SOLE, sampler, 20, 1).unwrap().found,
                0,
                "{sampler:?}"
            );
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_queries() {
        let bar = |x: f64| WorldShape {
            name: format!("bar at {x}"),
            world_from_shape: Pose::from_translation(DVec3::new(x, 0.0, -0.1)),
            shape: Shape::Box { half_extents: DVec3::new(0.015, 0.5, 0.1) },
        };
        let bars =
            World { mu: 0.6, shapes: vec![bar(-0.128), bar(0.128)], digest: Default::default() };
        let [one, again, other] = [1, 1, 2].map(|seed| {
            run_queries(&bars, &SOLE, Sampler::Printed, 20, seed).unwrap().examined_mean
        });
        assert_eq!(one, again);
        assert_ne!(one, other);
    }
}
