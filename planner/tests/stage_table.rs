//! The table of the pipeline's stages: complete, without dead ends, and as ARCHITECTURE draws it.

use std::collections::BTreeSet;

use surefoot_planner::pipeline::{Event, Stage, TRANSITIONS, Transition};

const ARCHITECTURE: &str = include_str!("../../docs/ARCHITECTURE.md");

/// A variant's name in words: `NewRoute` becomes "new route".
fn words(name: &str) -> String {
    let mut words = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.extend(letter.to_lowercase());
    }
    words
}

/// The table as a diagram.
fn diagram() -> String {
    let arrow = |row: &Transition| {
        let event = words(&format!("{:?}", row.event));
        format!("    {:?} --> {:?}: {event}\n", row.stage, row.next)
    };
    let arrows: String = TRANSITIONS.iter().map(arrow).collect();
    format!("```mermaid\nstateDiagram-v2\n    [*] --> {:?}\n{arrows}```\n", Stage::Endpoints)
}

/// The stages that `stage` leads to, directly or not.
fn reachable(stage: Stage) -> BTreeSet<String> {
    let (mut found, mut open) = (BTreeSet::new(), vec![stage]);
    while let Some(stage) = open.pop() {
        if found.insert(format!("{stage:?}")) {
            open.extend(TRANSITIONS.iter().filter(|row| row.stage == stage).map(|row| row.next));
        }
    }
    found
}

#[test]
fn the_diagram_in_architecture_shows_the_table() {
    let (_, after) = ARCHITECTURE.split_once("<!-- stages -->\n").expect("the marker before");
    let (shown, _) = after.split_once("<!-- /stages -->").expect("the marker after");
    assert_eq!(shown, diagram(), "docs/ARCHITECTURE.md needs this diagram:\n{}", diagram());
}

#[test]
fn no_stage_has_two_successors_for_one_event() {
    for (index, row) in TRANSITIONS.iter().enumerate() {
        let same = |other: &&Transition| (other.stage, other.event) == (row.stage, row.event);
        assert_eq!(TRANSITIONS[..index].iter().find(same), None, "{row:?}");
        assert_ne!(row.event, Event::Continue, "it keeps the stage");
    }
}

#[test]
fn the_first_stage_leads_to_all_and_all_lead_to_the_end() {
    let over = format!("{:?}", Stage::Over);
    let all = reachable(Stage::Endpoints);
    for row in &TRANSITIONS {
        assert!(all.contains(&format!("{:?}", row.stage)), "{row:?}");
        assert!(reachable(row.stage).contains(&over), "{row:?}");
    }
}

#[test]
fn only_stages_that_choose_or_count_themselves_have_no_category() {
    for row in &TRANSITIONS {
        let has_none = matches!(row.stage, Stage::Segments | Stage::Recovery | Stage::Method);
        assert_eq!(row.stage.category().is_none(), has_none, "{row:?}");
    }
}
