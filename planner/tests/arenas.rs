//! The memory that everything is reserved in. Alone in its file: page faults are counted for the
//! whole process.

#![allow(clippy::unwrap_used, reason = "a test ends where the system tells nothing of itself")]

use surefoot_planner::base::arena::{filled, reserve};

/// Pages that this process met for the first time.
fn faults() -> u64 {
    let status = std::fs::read_to_string("/proc/self/stat").unwrap();
    status.rsplit(')').next().unwrap().split_whitespace().nth(7).unwrap().parse().unwrap()
}

#[test]
fn an_arena_has_the_room_that_was_asked_for_and_no_page_of_its_beginning_is_new() {
    for capacity in [0, 1, 5_000] {
        assert!(reserve::<[u64; 3]>(capacity).capacity() >= capacity);
        assert_eq!(filled(7_u16, capacity), vec![7; capacity]);
    }
    let mut arena = reserve::<u64>(1 << 20);
    let before = faults();
    arena.extend(0..60_000);
    assert!(faults() - before < 30, "of 117 pages {} were new", faults() - before);
    assert_eq!(arena.iter().max(), Some(&59_999));
}
