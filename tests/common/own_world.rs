//! A scenario of the shipped robot in a world of a test's own.

use std::path::Path;

/// Writes a world and a scenario in it, with these blocks after the robot and the world; returns
/// the scenario's path.
pub fn write_scenario(folder: &Path, world: &str, blocks: &str) -> String {
    std::fs::write(folder.join("world.toml"), world).unwrap();
    let robot = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/robots/hubo/robot.toml");
    let path = folder.join("scenario.toml");
    std::fs::write(&path, format!("robot = {robot:?}\nworld = \"world.toml\"\n{blocks}")).unwrap();
    path.to_str().unwrap().to_owned()
}
