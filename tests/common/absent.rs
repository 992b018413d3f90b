//! Skips tests on machines that lack a requirement.

/// Prints that a test is skipped because `what` is absent. Fails instead if `SUREFOOT_REQUIRE_ALL`
/// is set.
pub fn skip(what: &str) {
    assert!(
        std::env::var_os("SUREFOOT_REQUIRE_ALL").is_none(),
        "{what}, and SUREFOOT_REQUIRE_ALL is set: nothing may be skipped"
    );
    println!("skipped: {what}");
}
