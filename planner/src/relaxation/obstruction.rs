//! Why there is no plan, where the relaxed problem or the world's friction shows it.

use glam::{DVec2, DVec3};

use crate::collision::model::CollisionModel;

/// Why no plan leads from start to goal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Obstruction {
    /// Ground that no step connects.
    Gap(GroundGap),
    /// The root cannot pass.
    Blockage(Blockage),
    /// The legs do not hold the root where it could pass.
    Enclosure(Enclosure),
    /// Without friction, ground that carries pushes straight up: the centre of mass cannot be moved
    /// from over one foot to over the other.
    NoFriction,
}

/// The missing ground between two parts that no step connects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundGap {
    /// Where the ground that is reached from the start ends, m.
    pub from: DVec3,
    /// The nearest ground from which the goal is reached, m.
    pub to: DVec3,
    /// Upper bound of the distance between points that the feet of a stance touch in the steps that
    /// the search makes, m.
    pub span_max: f64,
    /// Ground between both that is too steep to stand on.
    pub steep: Option<SteepGround>,
    /// Ground between both on which no sole rests.
    pub bare: Option<BareGround>,
}

/// Ground on which no sole rests: too small alone, and together with all that a sole would touch
/// beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BareGround {
    /// Where it is, seen from above, m.
    pub at: DVec2,
    /// Greatest distance between two points of a sole, m.
    pub sole_length: f64,
    /// Distance to the nearest ground that a sole would also touch, infinite without any, m.
    pub spacing: f64,
}

/// Ground that is too steep to stand on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteepGround {
    /// Its angle from the horizontal, rad.
    pub angle: f64,
    /// The greatest angle of ground that supports a sole, rad.
    pub limit: f64,
}

/// A shape that closes all ways.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blockage {
    /// The shape of the world.
    pub shape: usize,
    /// Where it blocks, as near to the goal as the root comes, m.
    pub at: DVec3,
    /// Radius of a ball that the root contains, m.
    pub radius: f64,
    /// Greatest distance of the ball's centre from the ground, m.
    pub reach: f64,
}

/// A shape that closes all ways on which a leg connects the root with the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Enclosure {
    /// The shape of the world.
    pub shape: usize,
    /// Where it blocks, as near to the start as the root comes from the goal, m.
    pub at: DVec3,
    /// Upper bound of the length from a touched point along a leg to the root, m.
    pub leg: f64,
}

impl Obstruction {
    /// The obstruction as a clause for messages.
    pub fn describe(&self, collision: &CollisionModel) -> String {
        match self {
            Self::Gap(gap) => gap.describe(),
            Self::Blockage(blockage) => blockage.describe(collision),
            Self::Enclosure(enclosure) => enclosure.describe(collision),
            Self::NoFriction => "the world has no friction (mu = 0), so the ground only pushes \
                                 straight up, and the robot cannot move its weight from one foot \
                                 to the other"
                .into(),
        }
    }
}

impl GroundGap {
    /// Horizontal distance and rise, m.
    pub fn size(&self) -> [f64; 2] {
        let offset = self.to - self.from;
        [offset.truncate().length(), offset.z]
    }

    fn describe(&self) -> String {
        let [width, rise] = self.size();
        let steep = self.steep.as_ref().map(SteepGround::describe).unwrap_or_default();
        let bare = self.bare.as_ref().map(BareGround::describe).unwrap_or_default();
        let missing = self.from.distance(self.to) - self.span_max;
        let missing = match missing >= 5e-3 {
            true => format!(", {missing:.2} m less than that takes"),
            false => String::new(),
        };
        format!(
            "from {} no step leads on to {}, the nearest ground that leads to the goal, \
             {width:.2} m away and {:.2} m {}: in the longest steps of the search the feet touch \
             points {:.2} m apart{missing}{steep}{bare}",
            point(self.from),
            point(self.to),
            rise.abs(),
            if rise < 0.0 { "lower" } else { "higher" },
            self.span_max
        )
    }
}

impl SteepGround {
    fn describe(&self) -> String {
        format!(
            "; the ground between is {:.1} degrees steep, and the friction holds {:.1}",
            self.angle.to_degrees(),
            self.limit.to_degrees()
        )
    }
}

impl BareGround {
    fn describe(&self) -> String {
        let (place, length) = (place(self.at), self.sole_length);
        let near = match self.spacing {
            spacing if spacing > self.sole_length && spacing.is_finite() => format!(
                "and from there to the next ground it is {spacing:.3} m, more than the length of a \
                 sole, {length:.3} m"
            ),
            spacing if spacing > self.sole_length => {
                format!("and no other is near that a sole, {length:.3} m long, would touch")
            }
            _ => format!("even with all that is within the length of a sole, {length:.3} m"),
        };
        format!("; no sole rests on the ground between, as at {place} m: it is too small, {near}")
    }
}

impl Blockage {
    fn describe(&self, collision: &CollisionModel) -> String {
        format!(
            "'{}' closes every way, here near {}: a ball of {:.2} m radius in the robot's root \
             passes nowhere within {:.2} m of the ground that steps reach",
            collision.shape_name(self.shape).unwrap_or_default(),
            point(self.at),
            self.radius,
            self.reach
        )
    }
}

impl Enclosure {
    fn describe(&self, collision: &CollisionModel) -> String {
        format!(
            "'{}' closes every way, here near {}: past it the robot's root passes nowhere from \
             which a leg, {:.2} m from sole to root, leads around all shapes to ground that steps \
             reach",
            collision.shape_name(self.shape).unwrap_or_default(),
            point(self.at),
            self.leg
        )
    }
}

fn point(at: DVec3) -> String {
    let z = unsigned_zero(at.z);
    format!("{}, z {z:.2} m", place(at.truncate()))
}

fn place(at: DVec2) -> String {
    let [x, y] = at.to_array().map(unsigned_zero);
    format!("x {x:.2}, y {y:.2}")
}

/// A coordinate that rounds to zero has no sign.
fn unsigned_zero(value: f64) -> f64 {
    if value.abs() < 5e-3 { 0.0 } else { value }
}
