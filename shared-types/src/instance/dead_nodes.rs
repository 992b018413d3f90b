//! Frees what killed processes of an instance left in iceoryx2's services.
//!
//! iceoryx2 0.10.0 panics while it does so if a file in `/dev/shm` begins with the name of a
//! connection of the killed process, ends like one, and has a path of more than 255 bytes. Another
//! user may put such files there. While they exist, nothing is freed: each killed process keeps its
//! ports, and a service has [`WRITERS_MAX`](crate::instance::tuning::WRITERS_MAX) of them.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use iceoryx2::node::Node;
use iceoryx2::prelude::{Config, ipc};

use crate::instance::directory;

/// Most bytes of a path in iceoryx2.
const PATH_BYTES_MAX: usize = 255;

/// Leaves it to [`free`] when the resources of killed processes are freed.
pub(crate) fn leave_alone(config: &mut Config) {
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
}

/// Frees the resources of killed processes of the instance with this root folder and this prefix,
/// unless a file in shared memory stands in the way. The caller holds the lock `making`.
pub(crate) fn free(node: &Node<ipc::Service>, root: &Path, prefix: &str) {
    let name_bytes_max = PATH_BYTES_MAX - (root.as_os_str().len() + 1);
    if directory::has_longer_name(prefix, name_bytes_max) {
        return;
    }
    // Such a file may appear meanwhile; then the rest is freed another time.
    let _ = catch_unwind(AssertUnwindSafe(|| node.try_cleanup_dead_nodes()));
}
