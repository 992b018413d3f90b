//! Cycles between files.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::house::House;
use crate::imports::Arrows;

/// The sets of files that import each other, the largest first.
pub fn circles(arrows: &Arrows<'_>) -> Vec<Vec<usize>> {
    let mut next: BTreeMap<usize, BTreeSet<usize>> = BTreeMap::new();
    for &(from, to) in arrows.keys() {
        next.entry(from).or_default().insert(to);
        next.entry(to).or_default();
    }
    let reached: BTreeMap<usize, BTreeSet<usize>> =
        next.keys().map(|&from| (from, reachable(&next, from))).collect();
    let mut circles = vec![];
    let mut seen = BTreeSet::new();
    for &file in next.keys() {
        if reached[&file].contains(&file) && !seen.contains(&file) {
            let circle: Vec<usize> = reached[&file]
                .iter()
                .copied()
                .filter(|other| reached[other].contains(&file))
                .collect();
            seen.extend(circle.iter().copied());
            circles.push(circle);
        }
    }
    circles.sort_by_key(|circle| std::cmp::Reverse(circle.len()));
    circles
}

/// The files that can be reached from a file by one arrow or more.
fn reachable(next: &BTreeMap<usize, BTreeSet<usize>>, from: usize) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let mut open = vec![from];
    while let Some(file) = open.pop() {
        for &to in &next[&file] {
            if found.insert(to) {
                open.push(to);
            }
        }
    }
    found
}

/// The shortest round through the first file of a circle.
fn shortest_round(arrows: &Arrows<'_>, circle: &[usize]) -> Vec<usize> {
    let mut best: Option<Vec<usize>> = None;
    for &begin in circle {
        let mut before: BTreeMap<usize, usize> = BTreeMap::new();
        let mut open = VecDeque::from([begin]);
        'search: while let Some(file) = open.pop_front() {
            for &(_, to) in arrows.range((file, 0)..=(file, usize::MAX)).map(|(key, _)| key) {
                if to == begin {
                    let mut round = vec![file];
                    while let Some(&earlier) = before.get(round.last().unwrap_or(&begin)) {
                        round.push(earlier);
                    }
                    round.reverse();
                    if best.as_ref().is_none_or(|best| round.len() < best.len()) {
                        best = Some(round);
                    }
                    break 'search;
                }
                if circle.contains(&to) && to != begin && !before.contains_key(&to) {
                    before.insert(to, file);
                    open.push_back(to);
                }
            }
        }
    }
    best.unwrap_or_default()
}

/// A circle as text: its files, and the imports of its shortest round.
pub fn shown(house: &House, arrows: &Arrows<'_>, circle: &[usize]) -> String {
    let path = |file: usize| house.files[file].path.as_str();
    let names: Vec<&str> = circle.iter().map(|&file| path(file)).collect();
    let round = shortest_round(arrows, circle);
    let mut text = format!("{} files import each other: {}", circle.len(), names.join(", "));
    for (at, &from) in round.iter().enumerate() {
        let to = round[(at + 1) % round.len()];
        let mention = arrows[&(from, to)];
        text += &format!("\n    {}:{}: {}", path(from), mention.line, mention.shown());
    }
    text
}

/// The arrows without those between a module and its direct children.
pub fn without_families<'a>(house: &House, arrows: &Arrows<'a>) -> Arrows<'a> {
    let is_parent = |parent: usize, child: usize| {
        let (parent, child) = (&house.files[parent], &house.files[child]);
        let above = child.module.split_last().map(|(_, above)| above);
        parent.krate == child.krate && above == Some(&parent.module[..])
    };
    let kept = |(from, to): (usize, usize)| !is_parent(from, to) && !is_parent(to, from);
    arrows.iter().filter(|(key, _)| kept(**key)).map(|(key, one)| (*key, *one)).collect()
}
