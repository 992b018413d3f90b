//! The floors: the folders of each crate from the lowest to the highest, and what each may import.

/// What a folder may import from its own crate.
#[derive(Debug, Clone, Copy)]
pub enum Imports {
    /// These folders.
    These(&'static [&'static str]),
    /// A folder and all that stand before it, and these.
    UpTo(&'static str, &'static [&'static str]),
}

/// One folder of a crate.
#[derive(Debug, Clone, Copy)]
pub struct Floor {
    /// Its name.
    pub folder: &'static str,
    /// What it may import.
    pub imports: Imports,
}

/// One crate.
#[derive(Debug, Clone, Copy)]
pub struct Crate {
    /// The name that other crates import.
    pub name: &'static str,
    /// The folder of its sources.
    pub sources: &'static str,
    /// The files that may stand at the root of its sources.
    pub root_files: &'static [&'static str],
    /// Its folders, the lowest first.
    pub floors: &'static [Floor],
}

const fn floor(folder: &'static str, imports: Imports) -> Floor {
    Floor { folder, imports }
}

use Imports::{These, UpTo};

/// The crates, the lowest first.
pub const CRATES: [Crate; 4] = [
    Crate {
        name: "surefoot_shared_types",
        sources: "shared-types/src",
        root_files: &["lib.rs"],
        floors: &[
            floor("base", These(&[])),
            floor("geometry", UpTo("base", &[])),
            floor("mesh", UpTo("geometry", &[])),
            floor("plan_format", UpTo("mesh", &[])),
            floor("config", UpTo("plan_format", &[])),
            floor("message", UpTo("config", &[])),
            floor("world", UpTo("message", &[])),
            floor("robot", UpTo("world", &[])),
            floor("scenario", UpTo("robot", &[])),
            floor("robot_draft", UpTo("robot", &[])),
            floor("plan_file", UpTo("robot", &[])),
            floor("instance", UpTo("plan_file", &[])),
        ],
    },
    Crate {
        name: "surefoot_planner",
        sources: "planner/src",
        root_files: &["lib.rs"],
        floors: &[
            floor("base", These(&[])),
            floor("geometry", These(&["base"])),
            floor("kinematics", These(&["base", "geometry"])),
            floor("robot", UpTo("kinematics", &[])),
            floor("collision", UpTo("robot", &[])),
            floor("constraints", UpTo("collision", &[])),
            floor("foot_placement", UpTo("constraints", &[])),
            floor("primitives", UpTo("constraints", &[])),
            floor("timing", UpTo("constraints", &[])),
            floor("plan", UpTo("constraints", &["timing"])),
            floor("preparation", UpTo("foot_placement", &["primitives"])),
            floor("possibility", UpTo("preparation", &[])),
            floor("relaxation", UpTo("foot_placement", &[])),
            floor("motion", UpTo("preparation", &["timing", "plan"])),
            floor("theory", These(&[])),
            floor("methods", UpTo("motion", &[])),
            floor("smooth_path", UpTo("motion", &[])),
            floor("pipeline", UpTo("motion", &["methods", "smooth_path", "relaxation"])),
            floor("channel", These(&[])),
        ],
    },
    Crate {
        name: "surefoot_controller_sim",
        sources: "controller-sim/src",
        root_files: &["lib.rs"],
        floors: &[
            floor("base", These(&[])),
            floor("geometry", UpTo("base", &[])),
            floor("kinematics", UpTo("geometry", &[])),
            floor("statics", UpTo("kinematics", &[])),
            floor("check", UpTo("statics", &[])),
            floor("chunk", UpTo("check", &[])),
            floor("plan", UpTo("chunk", &[])),
            floor("execution", UpTo("plan", &[])),
            floor("channel", UpTo("execution", &[])),
        ],
    },
    Crate {
        name: "surefoot",
        sources: "src",
        root_files: &["lib.rs", "main.rs"],
        floors: &[
            floor("system", These(&[])),
            floor("export", UpTo("system", &[])),
            floor("picture", UpTo("system", &[])),
            floor("cli", UpTo("picture", &[])),
            floor("report", UpTo("cli", &[])),
            floor("input", UpTo("report", &[])),
            floor("supervisor", UpTo("input", &[])),
            floor("commands", UpTo("supervisor", &[])),
            floor("api", These(&["system"])),
        ],
    },
];

/// The folders that the folder at `index` of a crate's floors may import.
pub fn allowed(floors: &[Floor], index: usize) -> Vec<&'static str> {
    let mut found = match floors[index].imports {
        These(folders) => folders.to_vec(),
        UpTo(highest, more) => {
            let end = floors.iter().position(|floor| floor.folder == highest);
            let below = floors.iter().take(end.map_or(0, |end| end + 1)).map(|floor| floor.folder);
            below.chain(more.iter().copied()).collect()
        }
    };
    found.sort_unstable();
    found.dedup();
    found
}
