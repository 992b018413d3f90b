//! The JSON schemas of plans and exports. `SUREFOOT_BLESS=1 cargo test --release --test exports`
//! rewrites them.

use std::path::{Path, PathBuf};

use schemars::{JsonSchema, schema_for};
use surefoot::export::contact_sequence::ContactSequence;
use surefoot::export::footsteps::FootstepList;
use surefoot_shared_types::plan_format::blocks::PlanFile;

/// The schema file of a format.
pub fn schema_file(format: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("docs/schemas/{format}.schema.json"))
}

fn assert_committed<T: JsonSchema>(format: &str) {
    let schema = serde_json::to_string_pretty(&schema_for!(T)).unwrap() + "\n";
    let path = schema_file(format);
    if std::env::var_os("SUREFOOT_BLESS").is_some() {
        std::fs::write(&path, &schema).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(committed == schema, "{} is out of date: SUREFOOT_BLESS=1", path.display());
}

#[test]
fn the_schemas_are_those_of_the_types_that_read_the_files() {
    assert_committed::<PlanFile>("biped-plan-1");
    assert_committed::<FootstepList>("surefoot-footsteps-1");
    assert_committed::<ContactSequence>("surefoot-contact-sequence-1");
}
