//! Sizes and times of the transport. They decide how fast messages travel and how much shared
//! memory they take; no plan depends on them.

use std::time::Duration;

// Flow control.

/// Most chunks sent and not yet acknowledged; also the size of a subscriber's buffer.
pub const WINDOW_CHUNKS: usize = 8;
/// Most subscribers of a service: the peer, monitors and loggers.
pub const READERS_MAX: usize = 8;
/// Most messages that a subscriber holds at a time.
pub const BORROWED_MAX: usize = 2;
/// Most publishers of a service: one alive, and dead ones that are not cleaned yet.
pub(crate) const WRITERS_MAX: usize = 8;
/// Most processes in a service, dead ones included.
pub(crate) const NODES_MAX: usize = 64;
/// Most clients of a planner that serves, at a time, dead ones that are not cleaned yet included.
pub(crate) const CLIENTS_AT_ONCE_MAX: usize = 32;

// Pools of messages in shared memory.

/// Messages that a publisher keeps loaned ahead.
pub const LOANS_AHEAD: usize = 48;
/// Most chunks of a publisher in use at a time: those in all subscribers' buffers and hands, and
/// its loan pool.
pub const CHUNK_POOL: usize = READERS_MAX * (WINDOW_CHUNKS + BORROWED_MAX) + LOANS_AHEAD;
/// Most feedback messages of a controller in use at a time: as [`CHUNK_POOL`], with a buffer of
/// one and a history of one.
pub const FEEDBACK_POOL: usize = READERS_MAX * (1 + BORROWED_MAX) + 1 + LOANS_AHEAD;
/// Ticks that a subscriber of the state may be behind before it loses the oldest.
pub const STATE_BUFFER: usize = 256;
/// Most states of a controller in use at a time: as [`FEEDBACK_POOL`], with [`STATE_BUFFER`].
pub const STATE_POOL: usize = READERS_MAX * (STATE_BUFFER + BORROWED_MAX) + 1 + LOANS_AHEAD;
/// Messages that a reader of a ROS 2 topic may be behind before it loses the oldest.
pub(crate) const ROS_BUFFER: usize = 8;
/// Most readers of a ROS 2 topic: the gateway and others.
pub(crate) const ROS_READERS_MAX: usize = 4;
/// Shared memory that one process takes at most, KiB: its pool of chunks, its feedback and
/// iceoryx2's own tables.
pub(crate) const NEEDED_KIB: u64 = 12 * 1024;

// Waiting for a peer.

/// Time that a process without input polls before it blocks on its wake pipe. Waking it takes
/// about 50 µs.
pub(crate) const POLLING_TIME: Duration = Duration::from_micros(500);
/// Part of the polling time that spins; the rest yields the core.
pub(crate) const SPINNING_TIME: Duration = Duration::from_micros(50);
/// A peer that received a message within this time still polls. Later it may block and has to be
/// notified. Half of the polling time, so that a delayed sender errs on the side of notifying.
pub const PEER_POLLING_TIME: Duration = Duration::from_micros(250);

// Opening instances and services.

/// Attempts to create a base folder with a random name.
pub(crate) const BASE_ATTEMPTS_MAX: usize = 20;
/// Attempts to lock the folder that holds it, and the pause between them: half a second in all.
pub(crate) const BASE_LOCK_ATTEMPTS_MAX: usize = 100;
/// See [`BASE_LOCK_ATTEMPTS_MAX`].
pub(crate) const BASE_LOCK_PAUSE: Duration = Duration::from_millis(5);

/// Attempts to lock an instance that another process creates or removes.
pub(crate) const LOCK_ATTEMPTS_MAX: usize = 20;
/// Time between two of these attempts.
pub(crate) const LOCK_PAUSE: Duration = Duration::from_millis(5);
/// Time between two attempts to find an instance that may appear.
pub(crate) const ATTACH_PAUSE: Duration = Duration::from_millis(2);
/// Attempts to open a service that another process creates or removes.
pub(crate) const OPEN_ATTEMPTS_MAX: usize = 20;
/// Time between two of these attempts.
pub(crate) const OPEN_PAUSE: Duration = Duration::from_millis(5);

// Unfinished segments and services.

/// Longest wait for the lock `making`. A process holds it for some milliseconds, and for
/// [`UNFINISHED_AGE_MIN`] longer after another process was killed.
pub(crate) const MAKING_WAIT_MAX: Duration = Duration::from_secs(25);
/// Time between two attempts to lock `making`.
pub(crate) const MAKING_PAUSE: Duration = Duration::from_millis(2);
/// A connection that stays unfinished for this time belongs to a dead process. A running process
/// finishes it in microseconds, or some scheduler slices later.
pub(crate) const UNFINISHED_AGE_MIN: Duration = Duration::from_secs(1);
/// Time between two scans for a connection that may still be finished.
pub(crate) const UNFINISHED_POLL_INTERVAL: Duration = Duration::from_millis(10);
/// Most unfinished connections that one scan records.
pub(crate) const UNFINISHED_MAX: usize = 64;
/// Stack of the thread that watches for unfinished connections, bytes.
pub(crate) const WATCH_STACK_BYTES: usize = 128 << 10;

// Requests.

/// Attempts to take a role whose last process is being reaped.
pub(crate) const ROLE_ATTEMPTS_MAX: usize = 40;
/// Time between two of these attempts.
pub(crate) const ROLE_PAUSE: Duration = Duration::from_millis(5);
/// Clients whose last request number is remembered, so that a repeated request is recognized.
pub(crate) const CLIENTS_MAX: usize = 64;
/// Stale sender ids that are remembered.
pub(crate) const STALE_SENDERS_MAX: usize = 32;
