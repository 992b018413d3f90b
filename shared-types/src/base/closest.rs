//! The name that was probably meant.

use std::path::Path;

/// Most letters of a name, per letter to change.
const LETTERS_PER_CHANGE: usize = 3;

/// The name among `names` that differs least from `name`, if it differs little.
pub fn closest<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let changes_max = (name.chars().count() / LETTERS_PER_CHANGE).max(1);
    let near = names.map(|other| (changes(name, other), other));
    near.filter(|(changes, _)| *changes <= changes_max).min().map(|(_, other)| other)
}

/// A question for the file that was meant where there is none at `path`; empty if none is alike.
/// A link that leads nowhere is named.
pub(crate) fn question(path: &Path) -> String {
    if let Ok(target) = path.read_link() {
        return format!("; it is a link to '{}', which leads to no file", target.display());
    }
    let is_there = |path: &&Path| path.as_os_str().is_empty() || path.exists();
    let Some(folder) = path.ancestors().skip(1).find(is_there) else { return String::new() };
    let missing = path.strip_prefix(folder).ok().and_then(|rest| rest.components().next());
    let missing = missing.map(|name| name.as_os_str().to_string_lossy().into_owned());
    let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(listed).into_iter().flatten().flatten();
    let mut names: Vec<String> =
        entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort();
    let meant = missing.as_ref().and_then(|name| {
        closest(name, names.iter().map(String::as_str)).map(|meant| folder.join(meant))
    });
    match meant {
        Some(meant) => format!("; did you mean '{}'?", meant.display()),
        None if path.parent().is_some_and(|parent| is_there(&parent)) => String::new(),
        None => format!("; '{}' holds no '{}'", listed.display(), missing.unwrap_or_default()),
    }
}

/// The fewest letters to insert, remove, replace or swap with their neighbour that make `a` into
/// `b`; capitals count as small letters.
fn changes(a: &str, b: &str) -> usize {
    strsim::osa_distance(&a.to_lowercase(), &b.to_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_counted() {
        for (a, b, expected) in [
            ("", "", 0),
            ("seed", "seed", 0),
            ("sead", "seed", 1),
            ("wrok", "work", 1),
            ("Work", "work", 0),
            ("kitten", "sitting", 3),
            ("", "abc", 3),
        ] {
            assert_eq!((changes(a, b), changes(b, a)), (expected, expected), "{a} {b}");
        }
    }

    #[test]
    fn only_a_name_that_is_alike_is_proposed() {
        let names = ["flat_walk.toml", "stairs.toml", "beam.toml"];
        assert_eq!(closest("flat_wlak.toml", names.into_iter()), Some("flat_walk.toml"));
        assert_eq!(closest("beams.toml", names.into_iter()), Some("beam.toml"));
        assert_eq!(closest("gauntlet.toml", names.into_iter()), None);
    }

    #[test]
    fn the_first_missing_part_of_a_path_is_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("scenarios")).unwrap();
        std::fs::write(folder.path().join("scenarios/stairs.toml"), "").unwrap();
        let ask = |path: &str| question(&folder.path().join(path));
        assert!(ask("scenarios/stair.toml").ends_with("scenarios/stairs.toml'?"));
        assert!(ask("scenario/stairs.toml").ends_with("scenarios'?"));
        assert!(ask("elsewhere/stairs.toml").ends_with("holds no 'elsewhere'"));
        assert_eq!(ask("elsewhere.toml"), "");
    }
}
