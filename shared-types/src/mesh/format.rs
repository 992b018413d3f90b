//! The format of a mesh file: by its name or, if the name shows no known format, by its content.

use std::path::Path;

/// A format that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Format {
    Stl,
    Obj,
    Collada,
}

/// What to do about any other format.
const UNKNOWN_FORMAT: &str = "is not read; convert it to STL, OBJ or COLLADA";
/// How files of other formats begin.
const BEGINNINGS: &[(&[u8], &str)] = &[
    (b"version https://git-lfs", "a Git LFS pointer"),
    (b"<!DOCTYPE html", "a web page"),
    (b"<!doctype html", "a web page"),
    (b"<html", "a web page"),
    (b"ply", "a PLY"),
    (b"OFF", "an OFF"),
    (b"COFF", "an OFF"),
    (b"NOFF", "an OFF"),
    (b"STOFF", "an OFF"),
    (b"glTF", "a binary glTF"),
    (b"#VRML", "a VRML"),
    (b"#X3D", "an X3D"),
    (b"Kaydara FBX", "an FBX"),
    (b"; FBX", "an FBX"),
    (b"ISO-10303-21", "a STEP"),
    (b"BLENDER", "a Blender"),
    (b"PXR-USDC", "a USD"),
    (b"#usda", "a USD"),
    (b"PK\x03\x04", "a ZIP"),
    (b"\x1f\x8b", "a gzip"),
    (b"BZh", "a bzip2"),
    (b"\xfd7zXZ\0", "an xz"),
    (b"\x28\xb5\x2f\xfd", "a zstd"),
    (b"7z\xbc\xaf", "a 7z"),
    (b"MM\0", "a 3DS"),
    (b"solid", "an STL"),
    (b"v ", "an OBJ"),
    (b"mtllib ", "an OBJ"),
];
/// The endings of other formats, in small letters.
const ENDINGS: &[(&str, &str)] = &[
    ("ply", "a PLY"),
    ("off", "an OFF"),
    ("glb", "a binary glTF"),
    ("gltf", "a glTF"),
    ("wrl", "a VRML"),
    ("vrml", "a VRML"),
    ("x3d", "an X3D"),
    ("fbx", "an FBX"),
    ("step", "a STEP"),
    ("stp", "a STEP"),
    ("iges", "an IGES"),
    ("igs", "an IGES"),
    ("blend", "a Blender"),
    ("usd", "a USD"),
    ("usda", "a USD"),
    ("usdc", "a USD"),
    ("usdz", "a USD"),
    ("3mf", "a 3MF"),
    ("3ds", "a 3DS"),
    ("zae", "a ZAE"),
    ("msh", "an MSH"),
    ("pcd", "a PCD"),
    ("mesh", "an Ogre"),
];

/// The format of a file; the message says what an unknown one is.
pub(crate) fn format_of(path: &Path, bytes: &[u8]) -> Result<Format, String> {
    if bytes.is_empty() {
        return Err("is empty; copy or export it again".into());
    }
    let ending = ending(path);
    match ending.as_str() {
        "stl" => Ok(Format::Stl),
        "obj" => Ok(Format::Obj),
        "dae" => Ok(Format::Collada),
        _ => match foreign(path, bytes) {
            Some(name) => Err(name),
            None if is_xml(bytes) => Ok(Format::Collada),
            None if ending.is_empty() => Err(format!("has no ending, and {UNKNOWN_FORMAT}")),
            None => Err(format!("ends in '.{ending}', which {UNKNOWN_FORMAT}")),
        },
    }
}

/// What a file is, if it is of a format that is not read.
pub(crate) fn foreign(path: &Path, bytes: &[u8]) -> Option<String> {
    let begun = BEGINNINGS.iter().find(|(beginning, _)| bytes.starts_with(beginning));
    let ending = ending(path);
    let ended = || ENDINGS.iter().find(|(known, _)| *known == ending).map(|(_, name)| *name);
    let name = match (begun.map(|(_, name)| *name), ended()) {
        // Several formats are archives of their own.
        (Some("a ZIP"), Some(name)) => name,
        (begun, ended) => begun.or(ended)?,
    };
    if name == "an OBJ" && ending == "obj" {
        return None;
    }
    Some(match name {
        "a ZIP" | "a gzip" | "a bzip2" | "an xz" | "a zstd" | "a 7z" => {
            format!("is {name} archive; unpack it")
        }
        "an OBJ" => format!("is {name} file by its content; name it .obj"),
        "a Git LFS pointer" => format!("is {name}, not the mesh itself; fetch it (git lfs pull)"),
        "a web page" => format!("is {name}, not the mesh itself; fetch the file"),
        "an STL" => format!("is {name} file by its content; name it .stl"),
        _ => format!("is {name} file, which {UNKNOWN_FORMAT}"),
    })
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

fn is_xml(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    bytes.trim_ascii_start().first() == Some(&b'<')
}
