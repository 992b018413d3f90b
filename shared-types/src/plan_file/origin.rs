//! What a plan was made from: digests, and the files that it names.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};

use crate::base::text_file::relative_to;
use crate::geometry::shape::Shape;
use crate::message::PlanChunk;
use crate::plan_format::blocks::{OriginBlock, PlanFile};
use crate::robot::model::RobotModel;
use crate::world::world::World;

/// The origin of a stream of chunks; none of an empty one. Paths are relative to `plan_dir`, which
/// is absolute.
pub(crate) fn origin_block(
    robot: &RobotModel,
    world: &World,
    chunks: &[PlanChunk],
    plan_dir: &Path,
) -> Option<OriginBlock> {
    let last = chunks.last()?;
    Some(OriginBlock {
        plan: last.stream_after().to_string(),
        robot: last.robot.to_string(),
        world: last.world.to_string(),
        scenario: last.config.to_string(),
        files: file_digests(robot, world, plan_dir),
    })
}

/// The digests of the files of a robot and a world. A file that cannot be read is left out.
fn file_digests(robot: &RobotModel, world: &World, plan_dir: &Path) -> BTreeMap<String, String> {
    let meshes = world.shapes.iter().filter_map(|shape| match &shape.shape {
        Shape::Mesh { source: Some(source), .. } => Some(source.path.clone()),
        _ => None,
    });
    let paths = [robot.urdf_path.clone()].into_iter().chain(robot.mesh_paths.clone()).chain(meshes);
    let digest = |path: PathBuf| {
        let bytes = std::fs::read(&path).ok()?;
        Some((relative_to(&path, plan_dir), sha256(&bytes)))
    };
    paths.filter_map(digest).collect()
}

/// The digest that `sha256sum` prints.
fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The files of a plan that differ from those that it was made from, one line each. A file that
/// is missing is not among them: loading the plan reports it.
pub fn changed_files(plan: &PlanFile, plan_path: &Path) -> Vec<String> {
    let folder = plan_path.parent().unwrap_or(Path::new(""));
    let stated = plan.origin.iter().flat_map(|origin| &origin.files);
    let changed = |(name, digest): (&String, &String)| {
        let bytes = std::fs::read(folder.join(name)).ok()?;
        (sha256(&bytes) != *digest)
            .then(|| format!("{name}: its content is not what the plan was made from"))
    };
    stated.filter_map(changed).collect()
}
