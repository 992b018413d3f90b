//! Actual support of a sole by the world: the air between the real foot and the ground, measured by
//! rays over the whole declared sole. It does not depend on the contact polygon that the planner
//! declares.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::Contact;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

use crate::geometry::bounds::Bounds;
use crate::geometry::polygon;
use crate::geometry::rays::{Hit, Target};
use crate::statics::resting_contact::{AirSample, resting_region};
use crate::statics::sole_support::crests::crests;
use crate::statics::sole_support::near_ground::NearGround;
use crate::statics::sole_support::ray_sample::RaySample;
use crate::statics::tuning::{
    CONTACT_POINTS_MAX, EVEN_AIR_MAX, HEIGHT_STEP, NEAR_AIR_MAX, RAY_START, SAMPLE_SPACING,
    SOLES_CACHED_MAX,
};
use crate::statics::underside::{SolePoint, Underside};

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
    /// Area of the part of the sole that holds, m2.
    pub area: f64,
    /// How deep the foot is in the ground, m: minus the least air under it; minus infinity over a
    /// void.
    pub deepest: f64,
    /// The part's vertices; empty where nothing holds.
    pub points: Vec<ContactPoint>,
}

/// Finds the support of soles and caches it.
pub struct SupportFinder {
    targets: Vec<Target>,
    undersides: Vec<Underside>,
    /// The distance by which the real foot may be beside its declared pose, m.
    shift_max: f64,
    /// Cosines of the largest angle between surface and sole normal, and between surface normal and
    /// the vertical.
    tilt_cos_min: f64,
    slope_cos_min: f64,
    cache: BTreeMap<(u32, [u64; 8]), SoleSupport>,
    /// The last samples under each foot, with the pose of its sole: the support under another
    /// centre of mass needs the same rays.
    last_samples: Vec<Option<(Pose, Vec<RaySample>)>>,
}

impl SupportFinder {
    /// A finder for the soles of a robot in a world.
    ///
    /// # Errors
    /// A shape of the world or of a foot has no form for ray casts.
    pub fn new(model: &RobotModel, world: &World, config: &CheckerConfig) -> Result<Self, String> {
        let target = |shape: &surefoot_shared_types::world::world::WorldShape| {
            Target::new(&shape.shape, &shape.world_from_shape)
                .map_err(|error| format!("{}: {error}", shape.name))
        };
        let vertices = model.feet.iter().flat_map(|foot| &foot.polygon);
        let reach = vertices.map(|vertex| vertex.length()).fold(0.0, f64::max);
        let shift_max = config.foot_position_max + config.foot_rotation_max * reach;
        let underside = |foot| Underside::new(model, foot, shift_max);
        Ok(Self {
            targets: world.shapes.iter().map(target).collect::<Result<_, _>>()?,
            undersides: model.feet.iter().map(underside).collect::<Result<_, _>>()?,
            shift_max,
            tilt_cos_min: libm::cos(config.contact_tilt_max),
            slope_cos_min: 1.0 / (1.0 + world.mu * world.mu).sqrt() - 1e-9,
            cache: BTreeMap::new(),
            last_samples: vec![None; model.feet.len()],
        })
    }

    /// The undersides of the feet.
    pub(crate) fn undersides(&self) -> &[Underside] {
        &self.undersides
    }

    /// The support of a declared contact under a centre of mass at `height` (m) over the sole. The
    /// height is rounded up.
    pub fn find(&mut self, contact: &Contact, height: f64) -> SoleSupport {
        let height = (height.max(0.0) / HEIGHT_STEP).ceil() * HEIGHT_STEP;
        let mut bits = [0; 8];
        bits.iter_mut()
            .zip(contact.position.iter().chain(&contact.rotation).chain([&height]))
            .for_each(|(bits, value)| *bits = value.to_bits());
        let key = (contact.limb, bits);
        if let Some(support) = self.cache.get(&key) {
            return support.clone();
        }
        let pose = contact.world_from_sole();
        let support = self.measure(
            contact.limb as usize,
            &Pose::from_parts(pose.translation, pose.rotation.normalize()),
            height,
        );
        if self.cache.len() >= SOLES_CACHED_MAX {
            self.cache.clear();
        }
        self.cache.insert(key, support.clone());
        support
    }

    fn measure(&mut self, limb: usize, world_from_sole: &Pose, height: f64) -> SoleSupport {
        let known = self.last_samples[limb].take().filter(|(pose, _)| pose == world_from_sole);
        let samples = known.map_or_else(
            || self.ray_samples(&self.undersides[limb], world_from_sole),
            |(_, samples)| samples,
        );
        let support = support_of(limb, &samples, world_from_sole, height);
        self.last_samples[limb] = Some((*world_from_sole, samples));
        support
    }

    /// Samples of the whole sole: a coarse grid, and a fine one where the ground is near and no
    /// plane.
    fn ray_samples(&self, underside: &Underside, world_from_sole: &Pose) -> Vec<RaySample> {
        let targets = self.targets_below(&underside.outline, world_from_sole);
        let sample = |point: SolePoint| self.sample(&targets, world_from_sole, point);
        let points = underside.coarse.iter().chain(&underside.edges);
        let coarse: Vec<RaySample> = points.copied().map(sample).collect();
        let least = least_air(&coarse);
        let is_even = |sample: &RaySample| sample.is_carrying && sample.air <= least + EVEN_AIR_MAX;
        if least == f64::INFINITY || coarse.iter().all(is_even) {
            return coarse;
        }
        let near = coarse
            .iter()
            .zip(underside.neighbours())
            .filter(|(sample, _)| sample.air <= least + NEAR_AIR_MAX);
        let (in_plane, others): (Vec<_>, Vec<_>) = near.partition(|(sample, neighbours)| {
            neighbours.iter().all(|&other| sample.is_in_plane(&coarse[other]))
        });
        let grid = underside.fine();
        let around = |samples: &[(&RaySample, &Vec<usize>)], width: f64| {
            grid.around(samples.iter().map(|(sample, _)| sample.point.at), width)
        };
        let even = around(&in_plane, 0.5 * SAMPLE_SPACING);
        let indices = around(&others, grid.width_around());
        let fine: Vec<RaySample> = indices.iter().map(|&index| sample(grid.point(index))).collect();
        let crests = crests(grid, &indices, &fine, sample);
        // A foot beside its place stands on ground beside the sole.
        let beside = grid.beside(indices.iter().copied());
        // The lines of curved ground have samples of their own.
        let edges = if indices.is_empty() { &[] } else { grid.edges() };
        let edges = edges.iter().copied().map(sample).filter(|sample| !sample.is_round);
        let others: Vec<RaySample> = edges.chain(coarse).collect();
        let mut near = NearGround::new(grid);
        even.iter().for_each(|&index| near.leave_out(index));
        for index in beside {
            // It may be missed, but the foot does not touch it in its place.
            let ground = sample(grid.point(index));
            near.set(index, &RaySample { is_carrying: false, ..ground });
        }
        let widened = near.widen(&indices, fine, others);
        [widened, crests].concat()
    }

    fn targets_below(&self, sole: &[DVec2], world_from_sole: &Pose) -> Vec<&Target> {
        let corners = sole.iter().flat_map(|at| {
            [3.0 * RAY_START, -2.0 * RAY_START].map(|z| *world_from_sole * at.extend(z))
        });
        let reached = Bounds::of_points(corners);
        self.targets.iter().filter(|target| target.bounds.distance(&reached) <= 0.0).collect()
    }

    /// One ray down from inside the foot, against the sole's normal. A surface carries if it is
    /// neither tilted from the sole nor too steep for friction.
    fn sample(&self, targets: &[&Target], world_from_sole: &Pose, point: SolePoint) -> RaySample {
        let up = world_from_sole.rotation * DVec3::Z;
        let origin = *world_from_sole * point.at.extend(point.height + RAY_START);
        let void = f64::INFINITY;
        let gradient = DVec2::ZERO;
        let mut sample = RaySample {
            point,
            air: void,
            most_air: void,
            normal: up,
            gradient,
            is_carrying: false,
            is_round: false,
        };
        for target in targets {
            match target.cast(origin, -up) {
                Hit::Inside => sample.air = -RAY_START,
                Hit::Surface { distance, normal }
                    if distance <= 2.0 * RAY_START && distance - RAY_START < sample.air =>
                {
                    let (air, is_round) = (distance - RAY_START, target.is_round());
                    sample = RaySample { air, normal, is_round, ..sample };
                }
                _ => {}
            }
        }
        sample.is_carrying = sample.air.is_finite()
            && sample.normal.dot(up) >= self.tilt_cos_min
            && sample.normal.z >= self.slope_cos_min;
        let normal = world_from_sole.rotation.inverse() * sample.normal;
        sample.gradient = normal.truncate() / normal.z;
        let slope = if sample.is_carrying { sample.gradient.length() } else { 0.0 };
        sample.most_air = sample.air + self.shift_max * slope;
        sample
    }
}

/// The support over samples of the ground under a sole.
fn support_of(
    limb: usize,
    samples: &[RaySample],
    world_from_sole: &Pose,
    height: f64,
) -> SoleSupport {
    let deepest = -least_air(samples);
    let region = certain_region(samples, height);
    let area = polygon::area(&region);
    let is_area = area > 0.0;
    if !is_area {
        return SoleSupport { limb, area: 0.0, deepest, points: Vec::new() };
    }
    let contact_point = |at: DVec2| {
        let nearest = nearest_carrying(samples, at)?;
        let ground = at.extend(nearest.point.height - nearest.air);
        Some(ContactPoint { position: *world_from_sole * ground, normal: nearest.normal })
    };
    let kept = polygon::outermost_vertices(&region, CONTACT_POINTS_MAX);
    let points = kept.into_iter().filter_map(|index| contact_point(region[index])).collect();
    SoleSupport { limb, area, deepest, points }
}

/// The part of the sole that holds both where the foot touches all that is near and where it misses
/// what it may miss.
fn certain_region(samples: &[RaySample], height: f64) -> Vec<DVec2> {
    let region = |air: fn(&RaySample) -> f64| {
        let measured = |sample: &RaySample| AirSample {
            at: sample.point.at,
            air: air(sample),
            is_carrying: sample.is_carrying,
        };
        resting_region(&samples.iter().map(measured).collect::<Vec<_>>(), height)
    };
    let touched = region(|sample| sample.air);
    if samples.iter().all(|sample| sample.air == sample.most_air) {
        return touched;
    }
    let certain = region(|sample| sample.most_air);
    if touched.len() < 3 {
        return Vec::new();
    }
    polygon::sides(&touched).fold(certain, |certain, (a, b)| {
        let outward = -(b - a).perp().normalize_or_zero();
        polygon::clip(&certain, outward, outward.dot(a))
    })
}

fn least_air(samples: &[RaySample]) -> f64 {
    samples.iter().map(|sample| sample.air).fold(f64::INFINITY, f64::min)
}

fn nearest_carrying(samples: &[RaySample], at: DVec2) -> Option<&RaySample> {
    let distance = |sample: &RaySample| sample.point.at.distance_squared(at);
    let carrying = samples.iter().filter(|sample| sample.is_carrying);
    carrying.min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

mod crests;
mod near_ground;
mod ray_sample;
#[cfg(test)]
mod tests;
#[cfg(test)]
pub(crate) use tests::level_soles;
