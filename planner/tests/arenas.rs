//! Arenas. The test is alone in its file because page faults are counted for the whole process.

#![allow(clippy::unwrap_used, reason = "the test fails on a system without /proc")]

use surefoot_planner::base::arena::{filled, reserve};

/// Minor page faults of this process so far.
fn page_faults() -> u64 {
    let status = std::fs::read_to_string("/proc/self/stat").unwrap();
    status.rsplit(')').next().unwrap().split_whitespace().nth(7).unwrap().parse().unwrap()
}

#[test]
fn an_arena_has_its_capacity_and_its_first_pages_cause_no_faults() {
    for capacity in [0, 1, 5_000] {
        assert!(reserve::<[u64; 3]>(capacity).capacity() >= capacity);
        assert_eq!(filled(7_u16, capacity), vec![7; capacity]);
    }
    let mut arena = reserve::<u64>(1 << 20);
    let before = page_faults();
    arena.extend(0..60_000);
    assert!(page_faults() - before < 30, "{} page faults in 117 pages", page_faults() - before);
    assert_eq!(arena.iter().max(), Some(&59_999));
}
