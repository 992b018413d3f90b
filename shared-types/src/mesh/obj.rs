//! Reads the vertices and polygons of OBJ files.
//!
//! A reader of its own: what it does not know it refuses with the line, where libraries pass over
//! it.

use std::borrow::Cow;

use glam::DVec3;

use crate::base::text_file::{IS_UTF16, has_utf16_mark, plain_lines};
use crate::mesh::raw_mesh::{MeshError, Welder};

/// Words that state no surface: texture, normals, names, materials, lines and points, and what
/// belongs to free-form curves.
const WITHOUT_SURFACE: &[&str] = &[
    "vt",
    "vn",
    "vp",
    "g",
    "o",
    "s",
    "mg",
    "usemtl",
    "mtllib",
    "usemap",
    "maplib",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "shadow_obj",
    "trace_obj",
    "l",
    "p",
    "cstype",
    "deg",
    "bmat",
    "step",
    "curv",
    "curv2",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "ctech",
    "stech",
];
/// Words that state a surface of another kind.
const PATCHES: &[&str] = &["surf", "bsp", "bzp", "cdc", "cdp", "res"];
/// Characters of the file that a complaint repeats at most.
const QUOTED_MAX: usize = 24;

/// A face before all vertices are known.
struct Face {
    line: usize,
    /// Indices of vertices, from 0.
    corners: Vec<usize>,
}

/// Reads a file.
pub(crate) fn read(bytes: &[u8], welder: &mut Welder) -> Result<(), MeshError> {
    if has_utf16_mark(bytes) {
        return Err(IS_UTF16.into());
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (line, text) in logical_lines(&plain_lines(&String::from_utf8_lossy(bytes))) {
        text.and_then(|text| read_line(&text, line, &mut vertices, &mut faces))
            .map_err(|message| MeshError::at(line, message))?;
    }
    let mut corners = Vec::new();
    for face in faces {
        corners.clear();
        for at in face.corners {
            let known = vertices.len();
            let vertex: &DVec3 = vertices.get(at).ok_or_else(|| {
                MeshError::at(face.line, format!("has a face with vertex {} of {known}", at + 1))
            })?;
            corners.push(*vertex);
        }
        welder
            .push_polygon(&corners, Some(face.line))
            .map_err(|message| MeshError::at(face.line, message))?;
    }
    Ok(())
}

/// The lines with their numbers, from 1; one that ends in `\` goes on in the next. A remark or a
/// name may end so by chance, as a path does, and would then swallow the vertex or face behind it:
/// programs differ there, so it is refused.
fn logical_lines(text: &str) -> impl Iterator<Item = (usize, Result<Cow<'_, str>, String>)> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (at, first) = lines.next()?;
        let mut line = Cow::Borrowed(first);
        while let Some(head) = line.trim_end().strip_suffix('\\') {
            let next = lines.next().map_or("", |(_, next)| next);
            if !states_surface(first) && states_surface(next) {
                let goes_on = "ends in '\\', as if the vertex or face in the next line belonged to it; remove the '\\'";
                return Some((at + 1, Err(goes_on.into())));
            }
            line = Cow::Owned(format!("{head} {next}"));
        }
        Some((at + 1, Ok(line)))
    })
}

/// Whether a line states a part of a surface.
fn states_surface(line: &str) -> bool {
    let word = line.split_whitespace().next().unwrap_or_default();
    ["v", "f", "fo"].contains(&word) || PATCHES.contains(&word)
}

fn read_line(
    text: &str,
    line: usize,
    vertices: &mut Vec<DVec3>,
    faces: &mut Vec<Face>,
) -> Result<(), String> {
    let mut words = text.split_whitespace().take_while(|word| !word.starts_with('#'));
    match words.next() {
        None => {}
        Some("v") => vertices.push(vertex(words)?),
        Some("f" | "fo") => {
            let corners = words.map(|word| corner(word, vertices.len()));
            let corners: Vec<usize> = corners.collect::<Result<_, _>>()?;
            if corners.len() < 3 {
                return Err(format!("has a face of {} corners; it needs 3 or more", corners.len()));
            }
            faces.push(Face { line, corners });
        }
        Some(word) if WITHOUT_SURFACE.contains(&word) => {}
        Some(word) if PATCHES.contains(&word) => {
            return Err(format!("has a free-form surface ({word}); export it as polygons"));
        }
        Some(word) => {
            return Err(format!("begins with '{}', which is no word of OBJ", quoted(word)));
        }
    }
    Ok(())
}

/// A vertex: three coordinates, then a weight, a colour or both.
fn vertex<'a>(words: impl Iterator<Item = &'a str>) -> Result<DVec3, String> {
    let mut numbers = Vec::with_capacity(3);
    for word in words {
        let number: Result<f32, _> = word.parse();
        numbers.push(number.map_err(|_| format!("has '{}' for a number", quoted(word)))?);
    }
    match *numbers {
        [x, y, z] | [x, y, z, 1.0] | [x, y, z, _, _, _] | [x, y, z, 1.0, _, _, _] => {
            let vertex = DVec3::new(x.into(), y.into(), z.into());
            if !vertex.is_finite() {
                return Err(format!("has a vertex that is not finite: {vertex}"));
            }
            Ok(vertex)
        }
        [_, _, _, weight] => Err(format!("has a vertex of weight {weight}; only 1 is read")),
        _ => Err(format!("has a vertex of {} numbers; 3 belong there", numbers.len())),
    }
}

/// The vertex of a face's corner, from 0; `known` vertices stand before it.
fn corner(word: &str, known: usize) -> Result<usize, String> {
    let input_error = || format!("has a face with the corner '{}'", quoted(word));
    let mut parts = word.split('/');
    let index: i64 = parts.next().unwrap_or_default().parse().map_err(|_| input_error())?;
    // Texture and normal say nothing of the surface, but must be indices.
    let others: Vec<&str> = parts.collect();
    let is_index = |part: &&str| part.is_empty() || part.parse::<i64>().is_ok_and(|at| at != 0);
    if others.len() > 2 || !others.iter().all(is_index) {
        return Err(input_error());
    }
    match index {
        0 => Err(format!("{}; vertices count from 1", input_error())),
        1.. => usize::try_from(index - 1).map_err(|_| input_error()),
        _ => usize::try_from(index.unsigned_abs())
            .ok()
            .and_then(|back| known.checked_sub(back))
            .ok_or_else(|| format!("{}, but {known} vertices before it", input_error())),
    }
}

fn quoted(text: &str) -> String {
    text.chars().take(QUOTED_MAX).collect()
}
