//! Shows the events of the roles: bars on a terminal, a few lines elsewhere, nothing if quiet.

use indicatif::{ProgressBar, ProgressStyle};

use crate::report::event::{CheckSummary, RoleEvent};
use crate::system::terminal;

const PLANNING: &str = "planning {bar:20} {percent:>3}% of work_max  {wide_msg}";
const WALKING: &str = "walking  {bar:20} {pos}/{len} chunks";

/// Display of the events of the roles.
#[derive(Debug)]
pub enum Progress {
    /// Not at all.
    Quiet,
    /// In lines on stderr.
    Lines,
    /// As a bar on the terminal, which appears with the first event.
    Bar(Option<ProgressBar>),
}

impl Progress {
    /// A bar on a terminal, lines elsewhere, nothing if `quiet`.
    pub fn new(quiet: bool) -> Self {
        match (quiet, terminal::is_watched()) {
            (true, _) => Self::Quiet,
            (false, true) => Self::Bar(None),
            (false, false) => Self::Lines,
        }
    }

    /// Shows an event.
    pub fn show(&mut self, event: &RoleEvent) {
        match self {
            Self::Quiet => {}
            Self::Lines => {
                if let Some(text) = milestone(event) {
                    terminal::print_note(&text);
                }
            }
            Self::Bar(bar) => show_on_bar(bar, event),
        }
    }

    /// Removes the bar.
    pub fn clear(&mut self) {
        if let Self::Bar(bar) = self {
            clear(bar);
        }
    }
}

fn milestone(event: &RoleEvent) -> Option<String> {
    match event {
        RoleEvent::PlannerReady { ready_seconds, arena_bytes } => Some(format!(
            "planner ready in {ready_seconds:.3} s, {:.1} MiB",
            *arena_bytes as f64 / f64::from(1 << 20)
        )),
        RoleEvent::Improving { first_seconds } => Some(format!(
            "improving a plan of {first_seconds:.1} s; a signal ends that with the best one"
        )),
        RoleEvent::Planned(planned) => Some(format!(
            "search of {:.3} s and {} work units: {}",
            planned.plan_seconds, planned.work, planned.description
        )),
        RoleEvent::Replanning { epoch, corrections } => Some(format!(
            "replanning from the rest state: {corrections} differences of the world, epoch {epoch}"
        )),
        RoleEvent::Retracing => Some(
            "no plan found from the rest state; searching for one that retraces first".to_owned(),
        ),
        RoleEvent::PlannerServes => Some("waiting for requests".to_owned()),
        RoleEvent::Holding { accepted } => Some(format!(
            "no planner is connected: the robot holds its position after {accepted} chunks"
        )),
        RoleEvent::Restarted { role, how } => {
            Some(format!("the {role} process ended ({how}) and is started again"))
        }
        RoleEvent::Checked(checked) => {
            let stops = checked.stops().map_or(String::new(), |stops| format!("; {stops}"));
            let dropped = checked.dropped().map_or(String::new(), |dropped| format!("; {dropped}"));
            let CheckSummary { accepted, check_seconds, .. } = checked;
            Some(format!("{accepted} chunks checked in {check_seconds:.3} s{stops}{dropped}"))
        }
        _ => None,
    }
}

fn show_on_bar(bar: &mut Option<ProgressBar>, event: &RoleEvent) {
    match event {
        RoleEvent::Planning(progress) => {
            let bar = bar.get_or_insert_with(|| new_bar(progress.work_max, PLANNING));
            bar.set_position(progress.work);
            bar.set_message(format!(
                "{} work, {} sequences, {} transitions, {} motions",
                progress.work, progress.sequences, progress.transitions, progress.motions
            ));
        }
        RoleEvent::Delivering { accepted, chunks } => {
            let bar = bar.get_or_insert_with(|| new_bar(*chunks, WALKING));
            bar.set_length(*chunks);
            bar.set_position(*accepted);
        }
        RoleEvent::Planned(_)
        | RoleEvent::Delivered(_)
        | RoleEvent::Restarted { .. }
        | RoleEvent::Replanning { .. }
        | RoleEvent::Failed { .. } => clear(bar),
        RoleEvent::Alive
        | RoleEvent::Retracing
        | RoleEvent::Improving { .. }
        | RoleEvent::PlannerServes
        | RoleEvent::Holding { .. }
        | RoleEvent::PlannerReady { .. }
        | RoleEvent::ControllerReady
        | RoleEvent::Checked(_) => {}
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
