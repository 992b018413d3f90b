//! A role process's sign of life for its supervisor, and the signal that asks it to end.

use std::io::Write;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::system::clock::Stopwatch;
use crate::system::signals;

/// Time between two signs of life, ms.
const INTERVAL_MILLIS: u64 = 1000;

static HAS_SUPERVISOR: AtomicBool = AtomicBool::new(false);
static CLOCK: OnceLock<Stopwatch> = OnceLock::new();
static EMITTED_AT_MILLIS: AtomicU64 = AtomicU64::new(0);

/// Lets [`keep_going`] emit signs of life on stdout.
pub(crate) fn start() {
    CLOCK.get_or_init(Stopwatch::start);
    HAS_SUPERVISOR.store(true, Ordering::Relaxed);
}

/// Whether no signal has asked the process to end. The loops of a role call it. Once a second it
/// emits a sign of life, without allocation.
pub(crate) fn keep_going() -> bool {
    if HAS_SUPERVISOR.load(Ordering::Relaxed) {
        emit_if_due();
    }
    signals::raised().is_none()
}

fn emit_if_due() {
    let Some(clock) = CLOCK.get() else { return };
    let now = (1e3 * clock.seconds()) as u64;
    let emitted_at = EMITTED_AT_MILLIS.load(Ordering::Relaxed);
    if now < emitted_at + INTERVAL_MILLIS {
        return;
    }
    EMITTED_AT_MILLIS.store(now, Ordering::Relaxed);
    let mut out = std::io::stdout().lock();
    // The next event reports that the supervisor is gone.
    let _ = out.write_all(b"{\"event\":\"alive\"}\n").and_then(|()| out.flush());
}

#[cfg(test)]
mod tests {
    use crate::report::event::RoleEvent;

    #[test]
    fn the_sign_of_life_is_an_event() {
        let event: RoleEvent = serde_json::from_str("{\"event\":\"alive\"}").unwrap();
        assert_eq!(event, RoleEvent::Alive);
    }
}
