//! Shows a person what the roles tell: bars on a terminal, a few plain lines elsewhere, nothing if
//! quiet.

use indicatif::{ProgressBar, ProgressStyle};

use crate::line::Line;
use crate::terminal;

const PLANNING: &str = "planning {bar:20} {percent:>3}% of work_max  {wide_msg}";
const WALKING: &str = "walking  {bar:20} {pos}/{len} chunks";

/// Shows a person what the roles tell.
#[derive(Debug)]
pub enum Progress {
    /// Not at all.
    Quiet,
    /// In lines on stderr.
    Lines,
    /// As a bar on the terminal, which appears with the first news.
    Bar(Option<ProgressBar>),
}

impl Progress {
    /// What suits the terminal.
    pub fn new(quiet: bool) -> Self {
        match (quiet, terminal::is_watched()) {
            (true, _) => Self::Quiet,
            (false, true) => Self::Bar(None),
            (false, false) => Self::Lines,
        }
    }

    /// Shows a line.
    pub fn show(&mut self, line: &Line) {
        match self {
            Self::Quiet => {}
            Self::Lines => {
                if let Some(text) = milestone(line) {
                    terminal::remark(&text);
                }
            }
            Self::Bar(bar) => show_on_bar(bar, line),
        }
    }

    /// Takes the bar away.
    pub fn clear(&mut self) {
        if let Self::Bar(bar) = self {
            clear(bar);
        }
    }
}

fn milestone(line: &Line) -> Option<String> {
    match line {
        Line::PlannerReady { ready_seconds, arena_bytes } => Some(format!(
            "planner ready in {ready_seconds:.3} s, {:.1} MiB",
            *arena_bytes as f64 / f64::from(1 << 20)
        )),
        Line::Planned(planned) => Some(format!(
            "{} in {:.3} s, {} work units",
            planned.description, planned.plan_seconds, planned.work
        )),
        Line::Replanning { epoch, corrections } => Some(format!(
            "the world differs in {corrections} places: planning again from here, epoch {epoch}"
        )),
        Line::WalkingBack => {
            Some("no plan leads on from here: looking for one that leads back first".to_owned())
        }
        Line::PlannerServes => Some("waiting for requests".to_owned()),
        Line::Holding { accepted } => {
            Some(format!("no planner speaks: the robot holds after {accepted} chunks"))
        }
        Line::Restarted { role, how } => {
            Some(format!("the {role} process ended ({how}) and is started again"))
        }
        Line::Judged(judged) => {
            Some(format!("{} chunks checked in {:.3} s", judged.accepted, judged.check_seconds))
        }
        _ => None,
    }
}

fn show_on_bar(bar: &mut Option<ProgressBar>, line: &Line) {
    match line {
        Line::Planning(searching) => {
            let bar = bar.get_or_insert_with(|| new_bar(searching.work_max, PLANNING));
            bar.set_position(searching.work);
            bar.set_message(format!(
                "{} work, {} sequences, {} transitions, {} motions",
                searching.work, searching.sequences, searching.transitions, searching.motions
            ));
        }
        Line::Delivering { accepted, chunks } => {
            bar.get_or_insert_with(|| new_bar(*chunks, WALKING)).set_position(*accepted)
        }
        Line::Planned(_)
        | Line::Delivered(_)
        | Line::Restarted { .. }
        | Line::Replanning { .. }
        | Line::Failed { .. } => clear(bar),
        Line::WalkingBack
        | Line::PlannerServes
        | Line::Holding { .. }
        | Line::PlannerReady { .. }
        | Line::ControllerReady
        | Line::Judged(_) => {}
    }
}

fn new_bar(length: u64, template: &str) -> ProgressBar {
    let style =
        ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(length).with_style(style)
}

fn clear(bar: &mut Option<ProgressBar>) {
    if let Some(bar) = bar.take() {
        bar.finish_and_clear();
    }
}
