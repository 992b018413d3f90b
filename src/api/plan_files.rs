//! Plans as files.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use glam::DVec3;
use surefoot_shared_types::base::whole_file;
use surefoot_shared_types::geometry::shape::MeshSource;
use surefoot_shared_types::plan_file::chunks::chunks_from_plan;
use surefoot_shared_types::plan_file::read::{load_plan, robot_and_world};
use surefoot_shared_types::plan_file::write::{plan_with_ends, plan_without_origin, save};
use surefoot_shared_types::plan_format::blocks::PlanFile;
use surefoot_shared_types::world::world::World as WorldModel;
use surefoot_shared_types::{InputError, Shape};

use crate::api::error::{LoadError, SaveError};
use crate::api::plan::{Digest, Plan};
use crate::api::plan_inputs::PlanInputs;
use crate::api::robot::Robot;
use crate::api::world::World;

impl Plan {
    /// Saves the plan as a file of the format `biped-plan/1`. The file names the URDF and the
    /// meshes by relative paths; a mesh in memory becomes an OBJ file beside it, in single
    /// precision: `PLAN.1.obj` for the second shape of `PLAN.json`.
    ///
    /// # Errors
    /// A file cannot be written, or a path is no text.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), SaveError> {
        let path = path.as_ref();
        let mut world = self.world().model().clone();
        save_meshes(&mut world, path)?;
        Ok(save(&self.file(&world, path.parent().unwrap_or(Path::new(""))), path)?)
    }

    /// Loads a plan file with its robot and its world. It need not come from Surefoot. Contacts
    /// cover the whole sole.
    ///
    /// # Errors
    /// A file cannot be read, or something in it is out of order: file, line and element are named.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, LoadError> {
        let path = path.as_ref();
        let file = load_plan(path)?;
        let (model, world) = robot_and_world(&file, path)?;
        let chunks = chunks_from_plan(&file, &model, &world, path)?;
        let digest = chunks.last().map_or_else(Digest::default, |chunk| chunk.stream_after());
        let ends = [file.start, file.goal];
        let inputs = PlanInputs { robot: Robot::new(model), world: World::new(world), ends };
        Ok(Self::new(&chunks, digest, inputs))
    }

    /// The plan as a file that is not saved: it does not state what the plan was made from.
    pub(crate) fn unsaved(&self) -> PlanFile {
        let (robot, world) = (self.robot().model(), self.world().model());
        plan_without_origin(robot, world, self.inputs().ends.clone(), self.chunks(), Path::new(""))
    }

    /// The plan as it is saved in a folder, with a world whose meshes have files.
    fn file(&self, world: &WorldModel, folder: &Path) -> PlanFile {
        let ends = self.inputs().ends.clone();
        plan_with_ends(self.robot().model(), world, ends, self.chunks(), folder)
    }
}

/// Writes the meshes in memory beside a plan file, and names their files in the world.
fn save_meshes(world: &mut WorldModel, plan_path: &Path) -> Result<(), InputError> {
    for (index, shape) in world.shapes.iter_mut().enumerate() {
        let Shape::Mesh { vertices, triangles, source: source @ None } = &mut shape.shape else {
            continue;
        };
        let path = beside(plan_path, index);
        whole_file::write(&path, obj_text(vertices, triangles).as_bytes())
            .map_err(|reason| InputError::file(&path, format!("cannot be written: {reason}")))?;
        let path = std::path::absolute(&path).unwrap_or(path);
        *source = Some(MeshSource { path, scale: DVec3::ONE });
    }
    Ok(())
}

fn beside(plan_path: &Path, index: usize) -> PathBuf {
    let stem = plan_path.file_stem().unwrap_or_default().to_string_lossy();
    plan_path.with_file_name(format!("{stem}.{index}.obj"))
}

fn obj_text(vertices: &[DVec3], triangles: &[[u32; 3]]) -> String {
    let mut text = String::new();
    for DVec3 { x, y, z } in vertices {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for [a, b, c] in triangles.iter().map(|corners| corners.map(|corner| corner + 1)) {
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}
