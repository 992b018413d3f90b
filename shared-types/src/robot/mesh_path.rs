//! Finds the mesh files that a URDF names.

use std::path::{Path, PathBuf};

use crate::base::text_file::folder_of;
use crate::mesh::file_name::readings;
use crate::robot::urdf::{Urdf, package_of};
use crate::robot::urdf_link::Geometry;

/// How many folders, from the URDF's upward, are searched.
const FOLDERS_MAX: usize = 5;
/// Folders of a package that hold URDFs: the one above them is the package.
const URDF_FOLDERS: [&str; 5] = ["urdf", "urdfs", "robots", "xacro", "model"];

/// Why a name leads to no file.
pub(crate) enum MeshError {
    /// The file is not on this machine.
    Missing(String),
    /// The name holds a macro.
    Macro(String),
}

/// The links with a mesh that is not on this machine, as collision shape.
pub(crate) fn links_without_meshes(urdf: &Urdf) -> Vec<usize> {
    let lacks = |link: &usize| {
        urdf.links[*link].collisions.iter().any(|part| match &part.geometry {
            Geometry::Mesh { filename, .. } => {
                matches!(find_mesh(urdf, filename), Err(MeshError::Missing(_)))
            }
            _ => false,
        })
    };
    (0..urdf.links.len()).filter(lacks).collect()
}

/// The file that a name means. A name without a package is looked for below the URDF's folder and
/// the few above it. `package://NAME/` and `model://NAME/` mean the folder that the user states,
/// or the folder NAME there, the folder whose package.xml says NAME, or, where all meshes are in
/// one package that the URDF has left, the URDF's own folder.
pub(crate) fn find_mesh(urdf: &Urdf, name: &str) -> Result<PathBuf, MeshError> {
    if name.contains("$(") || name.contains("${") {
        let message = format!("mesh '{name}' holds a macro; expand the xacro file first");
        return Err(MeshError::Macro(message));
    }
    if name.starts_with("http://") || name.starts_with("https://") {
        let message = format!("mesh '{name}' is not on this machine; fetch it");
        return Err(MeshError::Missing(message));
    }
    let plain = name.strip_prefix("file://").unwrap_or(name);
    let folder = folder_of(&urdf.source.path);
    let folder = std::path::absolute(&folder).unwrap_or(folder);
    let above: Vec<&Path> = folder.ancestors().take(FOLDERS_MAX).collect();
    let (bases, path) = match package_of(plain) {
        Some((package, path)) => (package_folders(urdf, &above, package), path),
        None if Path::new(plain).is_absolute() => (vec![PathBuf::new()], plain),
        None => (above.iter().map(|base| (*base).to_owned()).collect(), plain),
    };
    let found = bases.iter().find_map(|base| {
        readings(path).iter().map(|path| base.join(path)).find(|path| path.is_file())
    });
    found.ok_or_else(|| MeshError::Missing(not_found(name, &bases, &above)))
}

fn not_found(name: &str, bases: &[PathBuf], above: &[&Path]) -> String {
    match package_of(name) {
        // The same for all meshes of the package, so that it is reported once.
        Some((package, _)) if bases.is_empty() => format!(
            "package '{package}' is not found: no folder '{package}', and none whose package.xml says so, below {} or the folders above it up to {}; {}",
            above[0].display(),
            above[above.len() - 1].display(),
            package_advice(above, package)
        ),
        None if Path::new(name.strip_prefix("file://").unwrap_or(name)).is_absolute() => {
            format!("mesh '{name}' not found; put it there")
        }
        _ => {
            let searched: Vec<String> =
                bases.iter().map(|base| base.display().to_string()).collect();
            format!("mesh '{name}' not found below {}; put it there", searched.join(", "))
        }
    }
}

/// How to state where a package is; names a folder that is called so and says another name.
fn package_advice(above: &[&Path], package: &str) -> String {
    let state = format!(
        "state its folder ([packages] in robot.toml; 'surefoot robot add --package {package}=DIR' writes it)"
    );
    let is_called_so = |folder: &PathBuf| folder.file_name().is_some_and(|name| name == package);
    let candidates = above.iter().flat_map(|base| [(*base).to_owned(), base.join(package)]);
    let mut named = candidates.filter(is_called_so);
    let other = named.find_map(|folder| package_name(&folder).map(|name| (folder, name)));
    other.map_or_else(
        || format!("put the package there, or {state}"),
        |(folder, name)| {
            format!(
                "{} has a package.xml that says '{name}'; if it is meant, {state}",
                folder.display()
            )
        },
    )
}

/// The folders that are a package.
fn package_folders(urdf: &Urdf, above: &[&Path], package: &str) -> Vec<PathBuf> {
    let names = readings(package);
    if let Some(stated) = names.iter().find_map(|name| urdf.package_folders.get(name)) {
        return vec![PathBuf::from(stated)];
    }
    // What a package.xml says counts more than the folder's name.
    let is_package = |folder: &Path| match package_name(folder) {
        Some(name) => names.contains(&name),
        None => folder.file_name().is_some_and(|name| names.iter().any(|known| name == &known[..])),
    };
    let mut folders: Vec<PathBuf> = Vec::new();
    for base in above {
        let below = names.iter().map(|name| base.join(name));
        let below = below.filter(|folder| folder.is_dir() && is_package(folder));
        for folder in is_package(base).then(|| (*base).to_owned()).into_iter().chain(below) {
            if !folders.contains(&folder) {
                folders.push(folder);
            }
        }
    }
    if folders.is_empty() {
        folders.extend(above.iter().flat_map(|base| siblings_with_package_name(base, &names)));
    }
    if folders.is_empty() && urdf.packages.len() == 1 && has_left_its_package(above) {
        folders.push(above[0].to_owned());
    }
    folders
}

/// Folders in `base` whose package.xml says one of some names, in the order of their names.
fn siblings_with_package_name(base: &Path, names: &[String]) -> Vec<PathBuf> {
    let Ok(entries) = base.read_dir() else { return Vec::new() };
    let mut folders: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    folders.retain(|folder| package_name(folder).is_some_and(|name| names.contains(&name)));
    folders.sort();
    folders
}

/// Whether nothing shows that the URDF lies in a package: no package.xml, no folder of a package's
/// layout or with a package's name.
fn has_left_its_package(above: &[&Path]) -> bool {
    let name = |at: usize| {
        let base: Option<&&Path> = above.get(at);
        base.and_then(|base| base.file_name()).unwrap_or_default().to_string_lossy().into_owned()
    };
    let is_in_package = above.iter().any(|base| package_name(base).is_some())
        || URDF_FOLDERS.contains(&name(0).as_str())
        || [name(0), name(1)].iter().any(|name| name.ends_with("_description"));
    !is_in_package
}

/// The name that a folder's package.xml says.
fn package_name(folder: &Path) -> Option<String> {
    let text = std::fs::read_to_string(folder.join("package.xml")).ok()?;
    let (_, rest) = text.split_once("<name>")?;
    Some(rest.split_once("</name>")?.0.trim().to_owned())
}
