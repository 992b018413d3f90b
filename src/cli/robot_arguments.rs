//! The options of `surefoot robot`.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

/// `surefoot robot`.
#[derive(Debug, Subcommand)]
pub enum RobotCommand {
    /// Write the robot.toml of a URDF: legs, soles, standing posture, locked joints
    Add(RobotAddArguments),
    /// Show a robot as it is read, with a picture
    Inspect(RobotInspectArguments),
}

/// `surefoot robot add`.
#[derive(Debug, Args)]
pub struct RobotAddArguments {
    /// The URDF
    #[arg(value_name = "ROBOT.urdf")]
    pub urdf: PathBuf,
    /// The folder for robot.toml; it is made if it does not exist [default: the URDF's name]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// The links of the feet, where they cannot be found
    #[arg(long, value_name = "LEFT,RIGHT", value_parser = feet)]
    pub feet: Option<Feet>,
    /// The folder of a package that the URDF's package:// names, where it cannot be found; may be
    /// repeated
    #[arg(long = "package", value_name = "NAME=DIR", value_parser = package)]
    pub packages: Vec<Package>,
    /// Leave out shapes whose mesh files are missing: nothing keeps these links from colliding
    #[arg(long)]
    pub skip_missing_meshes: bool,
    /// Show no progress, only the summary
    #[arg(long)]
    pub quiet: bool,
}

/// The links of the left and of the right foot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Feet(pub [String; 2]);

/// A package's name and its folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Package(pub String, pub PathBuf);

/// `surefoot robot inspect`.
#[derive(Debug, Args)]
pub struct RobotInspectArguments {
    /// The robot file, its folder, a URDF that has none yet, or the name of a robot that the
    /// program carries
    #[arg(value_name = "ROBOT.toml|DIR|ROBOT.urdf|NAME")]
    pub robot: PathBuf,
    /// Draw the standing robot with its soles
    #[arg(long, value_name = "OUT.png")]
    pub picture: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

fn package(text: &str) -> Result<Package, String> {
    match text.split_once('=') {
        Some((name, folder)) if !name.is_empty() && Path::new(folder).is_dir() => {
            Ok(Package(name.to_owned(), PathBuf::from(folder)))
        }
        Some((name, folder)) if !name.is_empty() => Err(format!("'{folder}' is no folder")),
        _ => Err("a name, '=' and a folder are needed: --package my_robot=../my_robot".into()),
    }
}

fn feet(text: &str) -> Result<Feet, String> {
    let names: Vec<&str> = text.split(',').map(str::trim).collect();
    match names[..] {
        [left, right] if !left.is_empty() && !right.is_empty() => {
            Ok(Feet([left.to_owned(), right.to_owned()]))
        }
        _ => Err("two names of links with a comma between are needed, the left foot first".into()),
    }
}
