//! Markers, as RViz and others draw them.

use crate::export::ros::messages::{ColorRgba, Duration, Header, Point, Pose, Vector3};
use crate::export::ros::ros_type::message;

/// Marker type: a box, `scale` long.
pub const CUBE: i32 = 1;
/// Marker type: an ellipsoid, `scale` wide.
pub const SPHERE: i32 = 2;
/// Marker type: a cylinder along z, `scale` wide and high.
pub const CYLINDER: i32 = 3;
/// Marker type: a line through `points`, `scale.x` wide.
pub const LINE_STRIP: i32 = 4;
/// Marker type: each three of `points` are a triangle.
pub const TRIANGLE_LIST: i32 = 11;

message!(
    /// An image in a compressed format.
    CompressedImage = "sensor_msgs" / "CompressedImage" {
        /// Time and frame.
        header: Header,
        /// The format.
        format: String,
        /// The content.
        data: Vec<u8>,
    }
);
message!(
    /// A place in a texture.
    UvCoordinate = "visualization_msgs" / "UVCoordinate" {
        /// Across.
        u: f32,
        /// Along.
        v: f32,
    }
);
message!(
    /// A mesh file.
    MeshFile = "visualization_msgs" / "MeshFile" {
        /// Its name.
        filename: String,
        /// Its content.
        data: Vec<u8>,
    }
);
message!(
    /// A marker.
    Marker = "visualization_msgs" / "Marker" {
        /// Time and frame.
        header: Header,
        /// A name for a group of markers.
        ns: String,
        /// Its number within the group.
        id: i32,
        /// Its type.
        r#type: i32,
        /// 0: add.
        action: i32,
        /// Its pose.
        pose: Pose,
        /// Its size.
        scale: Vector3,
        /// Its colour.
        color: ColorRgba,
        /// How long it stays; 0: for ever.
        lifetime: Duration,
        /// Whether it moves with its frame.
        frame_locked: bool,
        /// Points of lines and triangles.
        points: Vec<Point>,
        /// Their colours, if they differ.
        colors: Vec<ColorRgba>,
        /// A texture's address.
        texture_resource: String,
        /// A texture.
        texture: CompressedImage,
        /// Places in the texture.
        uv_coordinates: Vec<UvCoordinate>,
        /// Text.
        text: String,
        /// A mesh's address.
        mesh_resource: String,
        /// A mesh.
        mesh_file: MeshFile,
        /// Whether the mesh has its own colours.
        mesh_use_embedded_materials: bool,
    }
);
message!(
    /// Markers.
    MarkerArray = "visualization_msgs" / "MarkerArray" {
        /// The markers.
        markers: Vec<Marker>,
    }
);
