//! Fixed sizes of messages and of the arrays in them.

/// Most moving joints of a robot.
pub const JOINTS_MAX: usize = 48;
/// Limits that a chunk names as those that bind its motion, at most.
pub const CHUNK_BINDINGS_MAX: usize = 8;
/// Most waypoints of one chunk.
pub const CHUNK_WAYPOINTS_MAX: usize = 32;
/// Most contacts of one chunk. A biped uses 2.
pub const CONTACTS_MAX: usize = 4;
/// Most vertices of a sole or support polygon.
pub const POLYGON_VERTICES_MAX: usize = 16;
/// Most world corrections that a controller can report.
pub const CORRECTIONS_MAX: usize = 32;
/// Links of a robot that are kept apart. Of more, those that are fixed to each other become one.
pub const LINKS_KEPT_MAX: usize = 192;
/// Most ended requests that a status names.
pub const REQUEST_ENDS_MAX: usize = 16;
/// Longest reason of a request's end, bytes.
pub const REASON_BYTES_MAX: usize = 160;
/// Longest name of a joint, a link or a robot in a message, bytes.
pub const NAME_BYTES_MAX: usize = 88;
