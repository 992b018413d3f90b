//! Actual support of a sole by the world, sampled by rays over the *whole* declared sole. It does
//! not depend on the contact polygon that the planner declares.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::Contact;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

use crate::base::comparison::{is_at_most, smallest};
use crate::geometry::body::{CollisionBody, SolidPose};
use crate::geometry::bounds::Bounds;
use crate::geometry::polygon;
use crate::geometry::rays::{Hit, Target};
use crate::geometry::separation::separation;
use crate::geometry::solid::{Convex, Core, Solid};
use crate::statics::error::CheckerError;
use crate::statics::tuning::{
    CONTACT_POINTS_MAX, EDGE_PULL, FINE_SAMPLE_SPACING, RAY_START, SAMPLE_SPACING, SOLES_CACHED_MAX,
};

/// A contact point of a sole with the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPoint {
    /// In the world, m.
    pub position: DVec3,
    /// The surface's outward unit normal.
    pub normal: DVec3,
}

/// The support of a sole by the world.
#[derive(Debug, Clone, PartialEq)]
pub struct SoleSupport {
    /// The foot.
    pub limb: usize,
    /// Area of the hull of all supported samples, m2.
    pub area: f64,
    /// The deepest sample below a surface, m; minus infinity over a void.
    pub deepest: f64,
    /// The hull's vertices; empty where the hull has no area.
    pub points: Vec<ContactPoint>,
}

/// Finds the support of soles and caches it.
pub struct SupportFinder {
    targets: Vec<Target>,
    soles: Vec<Vec<DVec2>>,
    gap_max: f64,
    /// Cosines of the largest angle between surface and sole normal, and between surface normal and
    /// the vertical.
    tilt_cos_min: f64,
    slope_cos_min: f64,
    cache: BTreeMap<(u32, [u64; 7]), SoleSupport>,
}

#[derive(Clone, Copy)]
struct RaySample {
    at: DVec2,
    /// Height of the sole over the surface, m; infinite over a void.
    gap: f64,
    normal: DVec3,
    is_near: bool,
    is_supported: bool,
}

impl SupportFinder {
    /// A finder for the soles of a robot in a world.
    ///
    /// # Errors
    /// A shape of the world has no form for ray casts.
    pub fn new(model: &RobotModel, world: &World, config: &CheckerConfig) -> Result<Self, String> {
        let target = |shape: &surefoot_shared_types::world::world::WorldShape| {
            Target::new(&shape.shape, &shape.world_from_shape)
                .map_err(|error| format!("{}: {error}", shape.name))
        };
        Ok(Self {
            targets: world.shapes.iter().map(target).collect::<Result<_, _>>()?,
            soles: model.feet.iter().map(|foot| polygon::hull(&foot.polygon)).collect(),
            gap_max: config.contact_gap_max,
            tilt_cos_min: libm::cos(config.contact_tilt_max),
            slope_cos_min: 1.0 / (1.0 + world.mu * world.mu).sqrt() - 1e-9,
            cache: BTreeMap::new(),
        })
    }

    /// The support of a declared contact.
    pub fn find(&mut self, contact: &Contact) -> SoleSupport {
        let mut bits = [0; 7];
        bits.iter_mut()
            .zip(contact.position.iter().chain(&contact.rotation))
            .for_each(|(bits, value)| *bits = value.to_bits());
        let key = (contact.limb, bits);
        if let Some(support) = self.cache.get(&key) {
            return support.clone();
        }
        let pose = contact.world_from_sole();
        let support = self.measure(
            contact.limb as usize,
            &Pose::from_parts(pose.translation, pose.rotation.normalize()),
        );
        if self.cache.len() >= SOLES_CACHED_MAX {
            self.cache.clear();
        }
        self.cache.insert(key, support.clone());
        support
    }

    fn measure(&self, limb: usize, world_from_sole: &Pose) -> SoleSupport {
        let sole = &self.soles[limb];
        let targets = self.targets_below(sole, world_from_sole);
        let sample = |at: DVec2| self.sample(&targets, world_from_sole, at);
        let mut samples: Vec<RaySample> = coarse_samples(sole).into_iter().map(sample).collect();
        if samples.iter().any(|sample| sample.is_near)
            && !samples.iter().all(|sample| sample.is_supported)
        {
            let near: Vec<DVec2> =
                samples.iter().filter(|sample| sample.is_near).map(|sample| sample.at).collect();
            samples.extend(fine_samples(sole, &near).into_iter().map(sample));
        }
        let supported: Vec<RaySample> =
            samples.iter().copied().filter(|sample| sample.is_supported).collect();
        let flat: Vec<DVec2> = supported.iter().map(|sample| sample.at).collect();
        let corners = polygon::hull_indices(&flat);
        let outline: Vec<DVec2> = corners.iter().map(|&index| flat[index]).collect();
        let deepest = samples.iter().map(|sample| -sample.gap).fold(f64::NEG_INFINITY, f64::max);
        if outline.len() < 3 {
            return SoleSupport { limb, area: 0.0, deepest, points: Vec::new() };
        }
        let contact_point = |kept: usize| {
            let RaySample { at, gap, normal, .. } = supported[corners[kept]];
            ContactPoint { position: *world_from_sole * at.extend(-gap), normal }
        };
        let points = polygon::extreme_vertices(&outline, CONTACT_POINTS_MAX)
            .into_iter()
            .map(contact_point)
            .collect();
        SoleSupport { limb, area: polygon::area(&outline), deepest, points }
    }

    fn targets_below(&self, sole: &[DVec2], world_from_sole: &Pose) -> Vec<&Target> {
        let corners = sole
            .iter()
            .flat_map(|at| [RAY_START, -RAY_START].map(|z| *world_from_sole * at.extend(z)));
        let reached = Bounds::of_points(corners);
        self.targets.iter().filter(|target| target.bounds.distance(&reached) <= 0.0).collect()
    }

    /// One ray from above the sole against its normal; contact where it hits a surface at the
    /// sole's height that is neither tilted from the sole nor too steep for friction.
    fn sample(&self, targets: &[&Target], world_from_sole: &Pose, at: DVec2) -> RaySample {
        let up = world_from_sole.rotation * DVec3::Z;
        let origin = *world_from_sole * at.extend(RAY_START);
        let mut sample =
            RaySample { at, gap: f64::INFINITY, normal: up, is_near: false, is_supported: false };
        for target in targets {
            match target.cast(origin, -up) {
                Hit::Inside => sample.gap = -RAY_START,
                Hit::Surface { distance, normal }
                    if distance <= 2.0 * RAY_START && distance - RAY_START < sample.gap =>
                {
                    sample = RaySample { gap: distance - RAY_START, normal, ..sample };
                }
                _ => {}
            }
        }
        sample.is_near = sample.gap.abs() <= self.gap_max;
        sample.is_supported = sample.is_near
            && sample.normal.dot(up) >= self.tilt_cos_min
            && sample.normal.z >= self.slope_cos_min;
        sample
    }
}

/// A grid over the sole, and points along its edges.
fn coarse_samples(sole: &[DVec2]) -> Vec<DVec2> {
    let (low, high) = extent(sole);
    let count = ((high - low) / SAMPLE_SPACING).ceil();
    let cells = (0..count.x as usize)
        .flat_map(|x| (0..count.y as usize).map(move |y| DVec2::new(x as f64, y as f64)));
    let grid = cells
        .map(|cell| low + SAMPLE_SPACING * (cell + 0.5))
        .filter(|&at| polygon::margin(sole, at) >= 0.0);
    let middle = sole.iter().sum::<DVec2>() / sole.len() as f64;
    let edges = polygon::sides(sole).flat_map(|(a, b)| {
        let pieces = ((b - a).length() / SAMPLE_SPACING).ceil().max(1.0) as usize;
        (0..pieces).map(move |piece| a + (b - a) * (piece as f64 / pieces as f64))
    });
    grid.chain(edges.map(|at| middle + (at - middle) * (1.0 - EDGE_PULL))).collect()
}

/// All points of a fine grid over the sole within half a coarse cell of one of `near`.
fn fine_samples(sole: &[DVec2], near: &[DVec2]) -> Vec<DVec2> {
    let (low, high) = extent(sole);
    let count = ((high - low) / FINE_SAMPLE_SPACING).ceil() + 1.0;
    let (width, height) = (count.x as usize, count.y as usize);
    let mut wanted = vec![false; width * height];
    let cell = |value: f64, count: usize| {
        (value / FINE_SAMPLE_SPACING).round().clamp(0.0, count as f64 - 1.0) as usize
    };
    for at in near {
        let (first, last) = (*at - low - 0.5 * SAMPLE_SPACING, *at - low + 0.5 * SAMPLE_SPACING);
        for x in cell(first.x, width)..=cell(last.x, width) {
            let row = x * height;
            wanted[row + cell(first.y, height)..=row + cell(last.y, height)].fill(true);
        }
    }
    let chosen = (0..wanted.len()).filter(|&index| wanted[index]);
    let at = chosen.map(|index| {
        low + FINE_SAMPLE_SPACING * DVec2::new((index / height) as f64, (index % height) as f64)
    });
    at.filter(|&at| polygon::margin(sole, at) >= 0.0).collect()
}

fn extent(sole: &[DVec2]) -> (DVec2, DVec2) {
    sole.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), at| {
        (low.min(*at), high.max(*at))
    })
}

/// Whether each declared sole lies on its foot's own collision shapes within `tolerance` (m), so
/// that no robot file declares a sole larger than its foot.
///
/// # Errors
/// A vertex of a sole that is farther from the shapes.
pub fn check_soles(
    model: &RobotModel,
    bodies: &[CollisionBody],
    tolerance: f64,
) -> Result<(), CheckerError> {
    let vertex = Solid::Convex(Convex { core: Core::Segment(0.0), radius: 0.0 });
    for foot in &model.feet {
        for at in &foot.polygon {
            let point = foot.link_from_sole * at.extend(0.0);
            let placed = SolidPose {
                world_from_solid: Pose::from_translation(point),
                bounds: Bounds { low: point, high: point },
            };
            let off = bodies.iter().filter(|body| body.link == Some(foot.link)).map(|body| {
                let on_link = SolidPose::new(body, &Pose::IDENTITY);
                separation((&body.solid, &on_link), (&vertex, &placed), DVec3::Z, 1.0)
                    .distance
                    .abs()
            });
            let nearest = smallest(off);
            if !is_at_most(nearest, tolerance) {
                let millimetres = (1e3 * nearest).min(1e6).ceil() as u64;
                return Err(CheckerError::SoleOffFoot { foot: foot.name.clone(), millimetres });
            }
        }
    }
    Ok(())
}
