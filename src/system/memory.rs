//! The process's memory: locking it, and its resident size.

/// Keeps all of this process's memory, now and later, from being paged out.
///
/// # Errors
/// The system's reason, usually that the limit of locked memory is too low.
pub fn lock() -> Result<(), String> {
    // SAFETY: mlockall touches no memory of ours.
    let answer = unsafe { libc::mlockall(libc::MCL_CURRENT | libc::MCL_FUTURE) };
    if answer == 0 { Ok(()) } else { Err(std::io::Error::last_os_error().to_string()) }
}

/// Memory of this process that is in use at this moment, bytes; 0 where the system does not say.
pub fn resident_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let kib = status.lines().find_map(|line| {
        line.strip_prefix("VmRSS:")?.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()
    });
    kib.unwrap_or(0) * 1024
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_in_use_grows_with_written_pages() {
        let before = resident_bytes();
        let block = std::hint::black_box(vec![1_u8; 64 << 20]);
        assert!(before > 0 && resident_bytes() > before + (32 << 20), "{} {}", before, block.len());
    }
}
