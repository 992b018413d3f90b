//! `surefoot plan`: plans, and delivers the plan where an instance is named. Also the planner process of a walk.

use std::num::NonZeroUsize;

use surefoot_planner::Planner;
use surefoot_planner::channel::ChunkSender;
use surefoot_shared_types::instance::draw_id;
use surefoot_shared_types::message::PlanChunk;
use surefoot_shared_types::plan_file::PlanFile;
use surefoot_shared_types::plan_file::write::{plan_from_chunks, save};

use super::{conclude, enter, settle};
use crate::arguments::PlanArguments;
use crate::audience::Audience;
use crate::clock::Stopwatch;
use crate::failure::{Ending, Failure};
use crate::inputs::Inputs;
use crate::line::{Delivered, Line, PlanEnd};
use crate::report::Report;
use crate::{outputs, search, signals, verdict};

/// Runs the command.
///
/// # Errors
/// When an input cannot be used, an output cannot be written, the transport fails, or a signal comes.
pub fn run(arguments: &PlanArguments) -> Result<Ending, Failure> {
    settle(&arguments.role);
    let inputs = Inputs::load(&arguments.search.scenario, arguments.search.seed)?;
    outputs::check(&arguments.outputs)?;
    let report = Report::new(&inputs, arguments.search.threads());
    let audience = Audience::new(arguments.role.report_lines, arguments.outputs.quiet);
    let mut run = Run { arguments, inputs, report, audience };
    run.plan_and_deliver()?;
    let ending = conclude(&run.report, arguments.outputs.json.as_deref())?;
    run.audience.say(|| verdict::text(&run.report));
    Ok(ending)
}

struct Run<'a> {
    arguments: &'a PlanArguments,
    inputs: Inputs,
    report: Report,
    audience: Audience,
}

impl Run<'_> {
    fn plan_and_deliver(&mut self) -> Result<(), Failure> {
        let mut sender = match &self.arguments.instance {
            Some(name) => Some(ChunkSender::open(&enter(name)?, draw_id())?),
            None => None,
        };
        let mut planner = self.get_ready()?;
        let work_max = self.inputs.scenario.planner.work_max;
        let planned = search::run(&mut planner, work_max, &mut |line| self.tell(line))?;
        let found = planned.end == PlanEnd::Found;
        self.tell(&Line::Planned(planned))?;
        if !found {
            return Ok(());
        }
        self.export(planner.chunks())?;
        if let Some(sender) = &mut sender {
            self.deliver(sender, planner.chunks())?;
        }
        self.draw(planner.chunks())
    }

    fn get_ready(&mut self) -> Result<Planner, Failure> {
        let watch = Stopwatch::start();
        let Inputs { scenario, model, world } = &self.inputs;
        let threads = NonZeroUsize::new(self.arguments.search.threads()).unwrap_or(NonZeroUsize::MIN);
        let planner = Planner::new(model, world, scenario, threads)?;
        let arena_bytes = planner.arena_bytes().iter().map(|(_, bytes)| *bytes as u64).sum();
        self.tell(&Line::PlannerReady { ready_seconds: watch.seconds(), arena_bytes })?;
        Ok(planner)
    }

    fn deliver(&mut self, sender: &mut ChunkSender, chunks: &[PlanChunk]) -> Result<(), Failure> {
        let mut accepted = 0;
        let total = chunks.len() as u64;
        let delivery = sender.deliver(
            chunks,
            &mut |feedback| {
                if feedback.next_sequence != accepted {
                    accepted = feedback.next_sequence;
                    // Whoever does not hear this does not hear the end either, and that one counts.
                    let _ = self.tell(&Line::Delivering { accepted, chunks: total });
                }
            },
            &|| signals::raised().is_none(),
        )?;
        self.tell(&Line::Delivered(Delivered::from(&delivery)))
    }

    fn export(&self, chunks: &[PlanChunk]) -> Result<(), Failure> {
        match &self.arguments.outputs.export {
            Some(path) => Ok(save(&self.plan_file(chunks, path), path)?),
            None => Ok(()),
        }
    }

    fn draw(&self, chunks: &[PlanChunk]) -> Result<(), Failure> {
        match &self.arguments.outputs.picture {
            Some(path) => outputs::draw(&self.inputs, &self.plan_file(chunks, path), path),
            None => Ok(()),
        }
    }

    /// The plan as a file that stands beside `path`.
    fn plan_file(&self, chunks: &[PlanChunk], path: &std::path::Path) -> PlanFile {
        let Inputs { scenario, model, world } = &self.inputs;
        plan_from_chunks(model, world, scenario, chunks, &outputs::folder_of(path))
    }

    fn tell(&mut self, line: &Line) -> Result<(), Failure> {
        self.report.note(line);
        self.audience.tell(line)
    }
}
