//! The fields of a world file.

use serde::Deserialize;
use toml::Spanned;

use crate::base::exactly::Exactly;
use crate::base::spatial::rotation_from_rpy;
use crate::base::text_file::check_angles;
use crate::plan_format::blocks::{PoseBlock, SceneShapeBlock, ShapeBlock};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawWorld {
    pub(crate) mu: Spanned<f64>,
    #[serde(default)]
    pub(crate) shapes: Vec<Spanned<RawShape>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawShape {
    pub(crate) name: String,
    #[serde(default)]
    xyz: Exactly<f64, 3>,
    rpy: Option<Exactly<f64, 3>>,
    quat_xyzw: Option<Exactly<f64, 4>>,
    r#box: Option<RawBox>,
    sphere: Option<RawSphere>,
    cylinder: Option<RawRod>,
    capsule: Option<RawRod>,
    convex: Option<RawConvex>,
    mesh: Option<RawMesh>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawBox {
    half_extents: Exactly<f64, 3>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSphere {
    radius: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRod {
    radius: f64,
    length: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawConvex {
    points: Option<Vec<Exactly<f64, 3>>>,
    path: Option<String>,
    scale: Option<Scale>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMesh {
    path: String,
    scale: Option<Scale>,
}

/// A scale, written as one number or as three.
struct Scale([f64; 3]);

impl<'de> Deserialize<'de> for Scale {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrThree;
        impl<'de> serde::de::Visitor<'de> for OneOrThree {
            type Value = Scale;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a number or three numbers")
            }

            fn visit_f64<E>(self, number: f64) -> Result<Scale, E> {
                Ok(Scale([number; 3]))
            }

            fn visit_i64<E>(self, number: i64) -> Result<Scale, E> {
                Ok(Scale([number as f64; 3]))
            }

            fn visit_seq<A: serde::de::SeqAccess<'de>>(
                self,
                numbers: A,
            ) -> Result<Scale, A::Error> {
                Exactly::deserialize(serde::de::value::SeqAccessDeserializer::new(numbers))
                    .map(|Exactly(numbers)| Scale(numbers))
            }
        }
        deserializer.deserialize_any(OneOrThree)
    }
}

impl RawShape {
    /// The same shape as a block of the plan format; the message names the problem of it.
    pub(crate) fn into_block(self) -> Result<SceneShapeBlock, String> {
        let pose = PoseBlock { xyz: self.xyz.0, quat_xyzw: self.quaternion()? };
        let geometries = [
            self.r#box.map(|raw| ShapeBlock::Box { half_extents: raw.half_extents.0 }),
            self.sphere.map(|raw| ShapeBlock::Sphere { radius: raw.radius }),
            self.cylinder
                .map(|raw| ShapeBlock::Cylinder { radius: raw.radius, length: raw.length }),
            self.capsule.map(|raw| ShapeBlock::Capsule { radius: raw.radius, length: raw.length }),
            self.convex.map(|raw| ShapeBlock::Convex {
                points: raw.points.map(|of| of.into_iter().map(|point| point.0).collect()),
                path: raw.path,
                scale: raw.scale.map(|scale| scale.0),
            }),
            self.mesh.map(|raw| ShapeBlock::Mesh {
                path: raw.path,
                scale: raw.scale.map(|scale| scale.0),
            }),
        ];
        let mut present = geometries.into_iter().flatten();
        match (present.next(), present.next()) {
            (Some(shape), None) => Ok(SceneShapeBlock { name: self.name, pose, shape }),
            (None, _) => Err("needs one of box, sphere, cylinder, capsule, convex, mesh".into()),
            (Some(_), Some(_)) => Err("has more than one geometry; give each its own shape".into()),
        }
    }

    fn quaternion(&self) -> Result<[f64; 4], String> {
        match (self.rpy, self.quat_xyzw) {
            (Some(_), Some(_)) => Err("has both rpy and quat_xyzw; keep one".into()),
            (None, Some(Exactly(quaternion))) => Ok(quaternion),
            (Some(Exactly([roll, pitch, yaw])), None) => {
                check_angles("rpy", &[roll, pitch, yaw])?;
                Ok(rotation_from_rpy(roll, pitch, yaw).to_array())
            }
            (None, None) => Ok([0.0, 0.0, 0.0, 1.0]),
        }
    }
}
