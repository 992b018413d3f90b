//! What kind of file some bytes are, for a hint where another kind is needed.

use std::path::Path;

use crate::base::input_error::InputError;

/// Bytes of a file at whose beginning a text shows its kind.
const HEAD_BYTES: usize = 1 << 16;
/// Bytes of a binary STL file before its triangles, and of each triangle.
const STL_BYTES: [usize; 2] = [84, 50];

/// A kind of file that users hand to the command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FileKind {
    Scenario,
    World,
    Robot,
    Urdf,
    Xacro,
    OtherRobotFormat,
    Plan,
    Report,
    Mesh,
    Picture,
    Archive,
    WebPage,
    LfsPointer,
}

impl FileKind {
    /// The kind of a file; `None` if it shows none.
    pub(crate) fn of(bytes: &[u8]) -> Option<Self> {
        let head = String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD_BYTES)]);
        let head = head.trim_start_matches('\u{feff}').trim_start();
        Self::of_magic(bytes).or_else(|| Self::of_markup(head)).or_else(|| {
            if head.starts_with("solid ") && head.contains("facet") {
                return Some(Self::Mesh);
            }
            let is_obj_line = |line: &str| line.starts_with("v ") || line.starts_with("f ");
            if head.lines().filter(|line| is_obj_line(line.trim_start())).count() > 2 {
                return Some(Self::Mesh);
            }
            Self::of_toml(std::str::from_utf8(bytes).ok()?)
        })
    }

    fn of_magic(bytes: &[u8]) -> Option<Self> {
        let begins = |magic: &[u8]| bytes.starts_with(magic);
        if begins(b"\x89PNG") || begins(b"\xff\xd8\xff") || begins(b"GIF8") {
            return Some(Self::Picture);
        }
        if begins(b"\x1f\x8b") || begins(b"PK\x03\x04") || begins(b"BZh") || begins(b"\xfd7zXZ") {
            return Some(Self::Archive);
        }
        if begins(b"glTF") || begins(b"ply") || begins(b"OFF") {
            return Some(Self::Mesh);
        }
        let [header, triangle] = STL_BYTES;
        let count = bytes.get(header - 4..header)?;
        let count = u32::from_le_bytes(count.try_into().ok()?) as usize;
        (count.checked_mul(triangle)?.checked_add(header)? == bytes.len()).then_some(Self::Mesh)
    }

    /// The kind of an XML or a JSON file.
    fn of_markup(head: &str) -> Option<Self> {
        let holds = |word: &str| head.contains(word);
        match head.chars().next()? {
            '<' if holds("<xacro:") || holds("xmlns:xacro") => Some(Self::Xacro),
            '<' if holds("<robot") => Some(Self::Urdf),
            '<' if holds("<sdf") || holds("<mujoco") => Some(Self::OtherRobotFormat),
            '<' if holds("<COLLADA") => Some(Self::Mesh),
            '<' if is_html(head) => Some(Self::WebPage),
            'v' if head.starts_with("version https://git-lfs") => Some(Self::LfsPointer),
            '{' if holds("\"biped-plan/") => Some(Self::Plan),
            '{' if holds("\"outcome\"") && holds("\"scenario\"") => Some(Self::Report),
            _ => None,
        }
    }

    fn of_toml(text: &str) -> Option<Self> {
        let table: toml::Table = text.parse().ok()?;
        let has = |key: &str| table.contains_key(key);
        if has("robot") && has("world") {
            Some(Self::Scenario)
        } else if has("urdf") {
            Some(Self::Robot)
        } else if has("shapes") {
            Some(Self::World)
        } else {
            None
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Scenario => "a scenario",
            Self::World => "a world",
            Self::Robot => "a robot file",
            Self::Urdf => "a URDF",
            Self::Xacro => "a xacro file",
            Self::OtherRobotFormat => "a robot in SDF or MJCF",
            Self::Plan => "a plan",
            Self::Report => "a report",
            Self::Mesh => "a mesh",
            Self::Picture => "a picture",
            Self::Archive => "a compressed file",
            Self::WebPage => "a web page",
            Self::LfsPointer => "a Git LFS pointer",
        }
    }

    /// What to do with a file of this kind where one of another kind is needed.
    fn advice(self) -> &'static str {
        match self {
            Self::Scenario => "'surefoot walk' and 'surefoot plan --export PLAN.json' take it",
            Self::World => "name it in a scenario: world = \"...\"",
            Self::Robot => "name it in a scenario: robot = \"...\"",
            Self::Urdf => "'surefoot robot add' writes a robot.toml for it, which a scenario names",
            Self::Xacro => "run xacro on it, then 'surefoot robot add' on the result",
            Self::OtherRobotFormat => "convert it to URDF, then run 'surefoot robot add' on that",
            Self::Plan => "'surefoot check', 'surefoot explain' and 'surefoot picture' take it",
            Self::Report => "'surefoot explain' takes it",
            Self::Mesh => "name it in a world: mesh = { path = \"...\" }",
            Self::Picture => "'surefoot picture' writes such files, and none is read",
            Self::Archive => "decompress it first",
            Self::WebPage => "download the file itself (raw), not the page that shows it",
            Self::LfsPointer => "fetch the file itself (git lfs pull)",
        }
    }

    /// The error of a file of a kind other than `self`, if `bytes` show another kind; else `error`.
    pub(crate) fn needed_instead(self, path: &Path, bytes: &[u8], error: InputError) -> InputError {
        match Self::of(bytes) {
            Some(found) if found != self => InputError::file(
                path,
                format!("is {}, and {} is needed; {}", found.name(), self.name(), found.advice()),
            ),
            _ => error,
        }
    }
}

/// Whether a text begins as a web page does.
fn is_html(head: &str) -> bool {
    let begins =
        |word: &str| head.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word));
    begins("<!doctype html") || begins("<html")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_show_their_kind() {
        let stl = [vec![0; 80], 1_u32.to_le_bytes().to_vec(), vec![0; 50]].concat();
        for (bytes, kind) in [
            (&b"robot = \"r\"\nworld = \"w\"\n"[..], Some(FileKind::Scenario)),
            (b"mu = 1.0\n[[shapes]]\nname = \"a\"\n", Some(FileKind::World)),
            (b"urdf = \"a.urdf\"\n", Some(FileKind::Robot)),
            (b"<?xml version=\"1.0\"?>\n<robot name=\"a\">", Some(FileKind::Urdf)),
            (b"<robot xmlns:xacro=\"x\">", Some(FileKind::Xacro)),
            (b"<sdf version=\"1.6\">", Some(FileKind::OtherRobotFormat)),
            (b"<COLLADA>", Some(FileKind::Mesh)),
            (b"<!DOCTYPE HTML><html>", Some(FileKind::WebPage)),
            (b"version https://git-lfs.github.com/spec/v1\n", Some(FileKind::LfsPointer)),
            (b"{\"schema\": \"biped-plan/1\"}", Some(FileKind::Plan)),
            (b"{\"outcome\": 1, \"scenario\": 2}", Some(FileKind::Report)),
            (b"\x89PNG\r\n", Some(FileKind::Picture)),
            (b"PK\x03\x04", Some(FileKind::Archive)),
            (b"solid a\nfacet normal 0 0 1\n", Some(FileKind::Mesh)),
            (b"v 0 0 0\n v 1 0 0\nv 0 1 0\nf 1 2 3\n", Some(FileKind::Mesh)),
            (&stl, Some(FileKind::Mesh)),
            (b"", None),
            (b"hello", None),
            (b"\xff\xfe\x00", None),
        ] {
            assert_eq!(FileKind::of(bytes), kind, "{}", String::from_utf8_lossy(bytes));
        }
    }
}
