//! Foxglove's scene and frames as ROS 2 messages of its package `foxglove_msgs`.

use crate::export::ros::messages::{Duration, Point, Pose, Quaternion, Time, Vector3};
use crate::export::ros::ros_type::message;

message!(
    /// A colour, each part 0 to 1.
    Color = "foxglove_msgs" / "Color" {
        /// Red.
        r: f64,
        /// Green.
        g: f64,
        /// Blue.
        b: f64,
        /// Opacity.
        a: f64,
    }
);
message!(
    /// A name and a value.
    KeyValuePair = "foxglove_msgs" / "KeyValuePair" {
        /// The name.
        key: String,
        /// The value.
        value: String,
    }
);
message!(
    /// An arrow along x.
    ArrowPrimitive = "foxglove_msgs" / "ArrowPrimitive" {
        /// The pose of its tail.
        pose: Pose,
        /// m.
        shaft_length: f64,
        /// m.
        shaft_diameter: f64,
        /// m.
        head_length: f64,
        /// m.
        head_diameter: f64,
        /// Its colour.
        color: Color,
    }
);
message!(
    /// A box.
    CubePrimitive = "foxglove_msgs" / "CubePrimitive" {
        /// The pose of its middle.
        pose: Pose,
        /// Its sides, m.
        size: Vector3,
        /// Its colour.
        color: Color,
    }
);
message!(
    /// An ellipsoid.
    SpherePrimitive = "foxglove_msgs" / "SpherePrimitive" {
        /// The pose of its middle.
        pose: Pose,
        /// Its diameters, m.
        size: Vector3,
        /// Its colour.
        color: Color,
    }
);
message!(
    /// A cylinder along z, or a part of a cone.
    CylinderPrimitive = "foxglove_msgs" / "CylinderPrimitive" {
        /// The pose of its middle.
        pose: Pose,
        /// Its diameters and its height, m.
        size: Vector3,
        /// Share of the diameter at the lower end.
        bottom_scale: f64,
        /// Share of the diameter at the upper end.
        top_scale: f64,
        /// Its colour.
        color: Color,
    }
);
message!(
    /// Lines.
    LinePrimitive = "foxglove_msgs" / "LinePrimitive" {
        /// 0: through the points, 1: closed, 2: each two points.
        r#type: u8,
        /// The pose of the points' frame.
        pose: Pose,
        /// m, or pixels.
        thickness: f64,
        /// Whether the thickness is in pixels.
        scale_invariant: bool,
        /// The points.
        points: Vec<Point>,
        /// Their colour.
        color: Color,
        /// Their colours, if they differ.
        colors: Vec<Color>,
        /// The order of the points, if they repeat.
        indices: Vec<u32>,
    }
);
message!(
    /// Triangles.
    TriangleListPrimitive = "foxglove_msgs" / "TriangleListPrimitive" {
        /// The pose of the points' frame.
        pose: Pose,
        /// The corners.
        points: Vec<Point>,
        /// Their colour.
        color: Color,
        /// Their colours, if they differ.
        colors: Vec<Color>,
        /// Each three are a triangle.
        indices: Vec<u32>,
    }
);
message!(
    /// A text in the scene.
    TextPrimitive = "foxglove_msgs" / "TextPrimitive" {
        /// The pose of its middle.
        pose: Pose,
        /// Whether it turns to the camera.
        billboard: bool,
        /// m, or pixels.
        font_size: f64,
        /// Whether the size is in pixels.
        scale_invariant: bool,
        /// Its colour.
        color: Color,
        /// The text.
        text: String,
    }
);
message!(
    /// A model of another file format.
    ModelPrimitive = "foxglove_msgs" / "ModelPrimitive" {
        /// Its pose.
        pose: Pose,
        /// Factors on its axes.
        scale: Vector3,
        /// Its colour.
        color: Color,
        /// Whether the colour replaces its own ones.
        override_color: bool,
        /// Its address.
        url: String,
        /// Its media type.
        media_type: String,
        /// Its content.
        data: Vec<u8>,
    }
);
message!(
    /// Primitives with one frame.
    SceneEntity = "foxglove_msgs" / "SceneEntity" {
        /// Time.
        timestamp: Time,
        /// The frame.
        frame_id: String,
        /// It replaces the entity with the same name.
        id: String,
        /// How long it stays; 0: until it is replaced.
        lifetime: Duration,
        /// Whether it moves with its frame.
        frame_locked: bool,
        /// More about it.
        metadata: Vec<KeyValuePair>,
        /// Arrows.
        arrows: Vec<ArrowPrimitive>,
        /// Boxes.
        cubes: Vec<CubePrimitive>,
        /// Ellipsoids.
        spheres: Vec<SpherePrimitive>,
        /// Cylinders.
        cylinders: Vec<CylinderPrimitive>,
        /// Lines.
        lines: Vec<LinePrimitive>,
        /// Triangles.
        triangles: Vec<TriangleListPrimitive>,
        /// Texts.
        texts: Vec<TextPrimitive>,
        /// Models.
        models: Vec<ModelPrimitive>,
    }
);
message!(
    /// Removes an entity.
    SceneEntityDeletion = "foxglove_msgs" / "SceneEntityDeletion" {
        /// Time.
        timestamp: Time,
        /// 0: the entity with this name, 1: all.
        r#type: u8,
        /// The name.
        id: String,
    }
);
message!(
    /// A change of the scene.
    SceneUpdate = "foxglove_msgs" / "SceneUpdate" {
        /// The removed entities.
        deletions: Vec<SceneEntityDeletion>,
        /// The added entities.
        entities: Vec<SceneEntity>,
    }
);
message!(
    /// The pose of a frame in another.
    FrameTransform = "foxglove_msgs" / "FrameTransform" {
        /// Time.
        timestamp: Time,
        /// The parent frame.
        parent_frame_id: String,
        /// The child frame.
        child_frame_id: String,
        /// The child's position in the parent.
        translation: Vector3,
        /// The child's rotation in the parent.
        rotation: Quaternion,
    }
);
message!(
    /// Poses of frames.
    FrameTransforms = "foxglove_msgs" / "FrameTransforms" {
        /// The poses.
        transforms: Vec<FrameTransform>,
    }
);
