//! Applies the corrections of a controller to a world.

use crate::base::digest::Digest;
use crate::geometry::shape::Shape;
use crate::message::{CorrectionKind, WorldCorrection};
use crate::world::world::{World, WorldShape};

/// Why a correction cannot be applied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum CorrectionError {
    /// It refers to a shape that the world does not have.
    #[error("a correction concerns shape {shape}, the world has {shapes}")]
    UnknownShape {
        /// The index of the shape.
        shape: u32,
        /// Number of shapes in the world.
        shapes: usize,
    },
    /// Its kind or its numbers are invalid.
    #[error("correction {index} is malformed")]
    Malformed {
        /// Its index in the list.
        index: usize,
    },
}

impl World {
    /// The world after corrections, oldest first. Their indices refer to the shapes of this world,
    /// also after a shape is missing. A missing contact changes no shape: the planner keeps out of
    /// its area. The digest is [`corrected_digest`]. Without corrections the world is unchanged.
    ///
    /// # Errors
    /// A correction refers to no shape of this world, or is malformed.
    pub fn corrected(&self, corrections: &[WorldCorrection]) -> Result<Self, CorrectionError> {
        let mut shapes: Vec<Option<WorldShape>> = self.shapes.iter().cloned().map(Some).collect();
        let mut added = vec![];
        for (index, correction) in corrections.iter().enumerate() {
            let malformed = CorrectionError::Malformed { index };
            let kind =
                correction.known_kind().filter(|_| correction.is_well_formed()).ok_or(malformed)?;
            let unknown = CorrectionError::UnknownShape {
                shape: correction.shape,
                shapes: self.shapes.len(),
            };
            match kind {
                CorrectionKind::Moved => {
                    let slot = shapes.get_mut(correction.shape as usize).ok_or(unknown)?;
                    let known = &self.shapes[correction.shape as usize];
                    *slot =
                        Some(WorldShape { world_from_shape: correction.pose(), ..known.clone() });
                }
                CorrectionKind::Missing => {
                    *shapes.get_mut(correction.shape as usize).ok_or(unknown)? = None
                }
                CorrectionKind::Extra => added.push(extra_box(index, correction)),
                CorrectionKind::ContactMissing => {}
            }
        }
        let shapes = shapes.into_iter().flatten().chain(added).collect();
        Ok(Self { mu: self.mu, shapes, digest: corrected_digest(&self.digest, corrections) })
    }
}

/// The digest of a world after corrections, which the chunks of a plan in the corrected world hold.
pub fn corrected_digest(world: &Digest, corrections: &[WorldCorrection]) -> Digest {
    corrections
        .iter()
        .fold(*world, |digest, correction| digest.chain(bytemuck::bytes_of(correction)))
}

fn extra_box(index: usize, correction: &WorldCorrection) -> WorldShape {
    let shape = Shape::Box { half_extents: correction.half_extents.into() };
    WorldShape { name: format!("correction_{index}"), world_from_shape: correction.pose(), shape }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::base::spatial::Pose;

    fn world() -> World {
        let cube = |name: &str, x: f64| WorldShape {
            name: name.into(),
            world_from_shape: Pose::from_parts(DVec3::new(x, 0.0, 0.0), glam::DQuat::IDENTITY),
            shape: Shape::Box { half_extents: DVec3::splat(0.1) },
        };
        World { mu: 0.6, shapes: vec![cube("a", 0.0), cube("b", 1.0)], digest: Digest([7; 32]) }
    }

    #[test]
    fn corrections_accumulate_and_change_the_digest() {
        let world = world();
        assert_eq!(world.corrected(&[]).unwrap(), world);
        let place = Pose::from_parts(DVec3::new(3.0, 0.0, 0.5), glam::DQuat::IDENTITY);
        let list = [
            WorldCorrection::moved(1, &place),
            WorldCorrection::missing(0),
            WorldCorrection::extra(&place, [0.1, 0.2, 0.3]),
            WorldCorrection::contact_missing(&place, [0.1, 0.05]),
        ];
        let corrected = world.corrected(&list).unwrap();
        let names: Vec<&str> = corrected.shapes.iter().map(|shape| shape.name.as_str()).collect();
        assert_eq!(names, ["b", "correction_2"]);
        assert_eq!(corrected.shapes[0].world_from_shape, place);
        let digests: Vec<Digest> =
            (0..=4).map(|count| world.corrected(&list[..count]).unwrap().digest).collect();
        assert!((0..4).all(|index| !digests[index + 1..].contains(&digests[index])));
        assert_eq!(digests[4], corrected_digest(&world.digest, &list));
    }

    #[test]
    fn corrections_of_unknown_shapes_are_refused() {
        let world = world();
        let unknown = world.corrected(&[WorldCorrection::missing(2)]);
        assert_eq!(unknown, Err(CorrectionError::UnknownShape { shape: 2, shapes: 2 }));
        let malformed = WorldCorrection { rotation: [0.0; 4], ..WorldCorrection::missing(1) };
        assert_eq!(
            world.corrected(&[WorldCorrection::missing(0), malformed]),
            Err(CorrectionError::Malformed { index: 1 })
        );
    }
}
