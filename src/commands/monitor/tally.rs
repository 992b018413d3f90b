//! What a monitor makes of what it hears: events, rates, latencies.

use std::collections::BTreeMap;

use serde::Serialize;
use surefoot_shared_types::message::{
    Check, Feedback, PlanChunk, PlanStatus, RequestState, State, Verdict,
};

use super::motion::{Motion, MotionSummary};
use crate::margins::WorstMargins;

/// Latencies that are remembered for the quantiles.
const LATENCIES_MAX: usize = 4096;

/// Something worth a line.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub(super) enum News {
    /// A planner process speaks that did not before.
    Planner { seconds: f64, session: String },
    /// A controller process speaks that did not before.
    Controller { seconds: f64, instance: String, next_sequence: u64 },
    /// Another plan, or the same planned again.
    Plan { seconds: f64, plan_id: u64, epoch: u64 },
    /// A chunk is refused.
    Refused { seconds: f64, sequence: u64, check: String, waypoint: u32, corrections: u32 },
    /// The last chunk of the plan is accepted.
    Finished { seconds: f64, chunks: u64, margins: WorstMargins },
    /// The state of a request at a planner that stays up.
    Request { seconds: f64, client: String, number: u64, state: String },
    /// What passed since the summary before.
    Summary(Summary),
}

/// A summary.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Summary {
    /// Time since the monitor's start, s.
    seconds: f64,
    /// Chunks accepted so far.
    accepted: u64,
    /// Chunks seen per second.
    chunks_per_second: f64,
    /// The controller's words heard per second.
    words_per_second: f64,
    /// Time from a chunk's publication to its verdict as the monitor saw it, s: median, 95 of 100,
    /// longest.
    verdict_latency: Option<[f64; 3]>,
    /// The worst margins so far.
    margins: WorstMargins,
    /// How the simulated robot was, where the controller tells.
    motion: Option<MotionSummary>,
}

/// What was heard so far.
#[derive(Debug, Default)]
pub(super) struct Tally {
    session: Option<u64>,
    instance: Option<u64>,
    plan: Option<(u64, u64)>,
    request: Option<(u64, u64, u32)>,
    refused: Option<(u64, u64)>,
    finished: Option<(u64, u64)>,
    accepted: u64,
    chunks: u64,
    words: u64,
    published: BTreeMap<u64, f64>,
    latencies: Vec<f64>,
    margins: WorstMargins,
    motion: Motion,
}

impl Tally {
    /// Whether anybody was heard.
    pub(super) fn has_heard(&self) -> bool {
        self.session.is_some() || self.instance.is_some() || self.request.is_some()
    }

    /// Takes in a chunk seen at `seconds`.
    pub(super) fn note_chunk(&mut self, chunk: &PlanChunk, seconds: f64) -> Vec<News> {
        let mut news = vec![];
        self.chunks += 1;
        if self.session.replace(chunk.session) != Some(chunk.session) {
            news.push(News::Planner { seconds, session: format!("{:016x}", chunk.session) });
        }
        news.extend(self.turn_to((chunk.plan_id, chunk.epoch), seconds));
        if chunk.sequence >= self.accepted {
            self.published.entry(chunk.sequence).or_insert(seconds);
        }
        news
    }

    /// Takes in a controller's word heard at `seconds`.
    pub(super) fn note_word(&mut self, word: &Feedback, seconds: f64) -> Vec<News> {
        let mut news = vec![];
        self.words += 1;
        if self.instance.replace(word.instance) != Some(word.instance) {
            news.push(News::Controller {
                seconds,
                instance: format!("{:016x}", word.instance),
                next_sequence: word.next_sequence,
            });
        }
        if word.session == 0 {
            return news;
        }
        let plan = (word.plan_id, word.epoch);
        news.extend(self.turn_to(plan, seconds));
        self.note_progress(word, seconds);
        if word.verdict == Verdict::Refused as u32 && self.refused.replace(plan) != Some(plan) {
            let check = Check::from_wire(word.check).map_or("unknown", Check::word).to_owned();
            let (sequence, waypoint, corrections) =
                (word.refused_sequence, word.refused_waypoint, word.corrections_len);
            news.push(News::Refused { seconds, sequence, check, waypoint, corrections });
        }
        if word.finished == 1 && self.finished.replace(plan) != Some(plan) {
            news.push(News::Finished {
                seconds,
                chunks: word.next_sequence,
                margins: self.margins,
            });
        }
        news
    }

    /// Takes in a word of a planner that stays up.
    pub(super) fn note_status(&mut self, status: &PlanStatus, seconds: f64) -> Option<News> {
        let state = RequestState::from_wire(status.state)?;
        let request = (status.client, status.number, status.state);
        let is_news = status.client != 0 && self.request.replace(request) != Some(request);
        is_news.then(|| News::Request {
            seconds,
            client: format!("{:016x}", status.client),
            number: status.number,
            state: state.word().into(),
        })
    }

    /// Takes in a tick of the simulated robot.
    pub(super) fn note_state(&mut self, state: &State) {
        self.motion.note(state);
    }

    /// What passed in the last `period` (s); starts a new one.
    pub(super) fn summary(&mut self, seconds: f64, period: f64) -> News {
        let rate = |count: u64| if period > 0.0 { count as f64 / period } else { 0.0 };
        let summary = Summary {
            seconds,
            accepted: self.accepted,
            chunks_per_second: rate(self.chunks),
            words_per_second: rate(self.words),
            verdict_latency: quantiles(&mut self.latencies),
            margins: self.margins,
            motion: self.motion.summary(period),
        };
        (self.chunks, self.words) = (0, 0);
        News::Summary(summary)
    }

    fn turn_to(&mut self, plan: (u64, u64), seconds: f64) -> Option<News> {
        if self.plan >= Some(plan) {
            return None;
        }
        self.plan = Some(plan);
        self.accepted = 0;
        self.published.clear();
        Some(News::Plan { seconds, plan_id: plan.0, epoch: plan.1 })
    }

    fn note_progress(&mut self, word: &Feedback, seconds: f64) {
        while self
            .published
            .first_key_value()
            .is_some_and(|(sequence, _)| *sequence < word.next_sequence)
        {
            if let Some((_, published)) = self.published.pop_first()
                && self.latencies.len() < LATENCIES_MAX
            {
                self.latencies.push(seconds - published);
            }
        }
        self.accepted = word.next_sequence;
        self.margins = WorstMargins::from(&word.margins);
    }
}

fn quantiles(latencies: &mut [f64]) -> Option<[f64; 3]> {
    latencies.sort_by(f64::total_cmp);
    let last = latencies.len().checked_sub(1)?;
    Some([last / 2, last * 95 / 100, last].map(|index| latencies[index]))
}

impl News {
    /// One line for a person.
    pub(super) fn line(&self) -> String {
        match self {
            Self::Planner { seconds, session } => {
                format!("{seconds:9.3} s  planner {session} speaks")
            }
            Self::Controller { seconds, instance, next_sequence } => {
                format!(
                    "{seconds:9.3} s  controller {instance} speaks, {next_sequence} chunks behind it"
                )
            }
            Self::Plan { seconds, plan_id, epoch } => {
                format!("{seconds:9.3} s  plan {plan_id}, epoch {epoch}")
            }
            Self::Refused { seconds, sequence, check, waypoint, corrections } => {
                format!(
                    "{seconds:9.3} s  refused: {check} at waypoint {waypoint} of chunk {sequence}, {corrections} corrections so far"
                )
            }
            Self::Finished { seconds, chunks, margins } => {
                format!(
                    "{seconds:9.3} s  finished: {chunks} chunks accepted; margins: {}",
                    margins.describe()
                )
            }
            Self::Request { seconds, client, number, state } => {
                format!("{seconds:9.3} s  request {number} of client {client}: {state}")
            }
            Self::Summary(summary) => summary.line(),
        }
    }

    /// One JSON object in a line.
    pub(super) fn json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

impl Summary {
    fn line(&self) -> String {
        let rates =
            format!("{:.1} chunks/s, {:.0} words/s", self.chunks_per_second, self.words_per_second);
        let latency = self.verdict_latency.map_or(String::new(), |[p50, p95, max]| {
            format!(
                ", verdict after {:.2} ms (p95 {:.2}, max {:.2})",
                1000.0 * p50,
                1000.0 * p95,
                1000.0 * max
            )
        });
        let margins = self.margins.describe();
        let margins = if margins.is_empty() { margins } else { format!("; margins: {margins}") };
        let motion = self.motion.map_or(String::new(), |motion| format!("; {}", motion.describe()));
        format!(
            "{:9.3} s  {} accepted, {rates}{latency}{margins}{motion}",
            self.seconds, self.accepted
        )
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    #[test]
    fn latencies_run_from_a_chunks_first_sight_to_its_verdict() {
        let mut tally = Tally::default();
        let chunk =
            |sequence| PlanChunk { session: 5, plan_id: 1, sequence, ..PlanChunk::zeroed() };
        let word = |next_sequence| Feedback {
            instance: 6,
            session: 5,
            plan_id: 1,
            next_sequence,
            ..Feedback::zeroed()
        };
        assert_eq!(tally.note_chunk(&chunk(0), 1.0).len(), 2, "a planner and a plan");
        assert_eq!(tally.note_chunk(&chunk(1), 1.1).len(), 0);
        tally.note_chunk(&chunk(0), 1.2);
        assert_eq!(tally.note_word(&word(0), 1.25).len(), 1, "a controller");
        tally.note_word(&word(2), 1.5);
        let News::Summary(summary) = tally.summary(2.0, 1.0) else { panic!("no summary") };
        let [p50, _, max] = summary.verdict_latency.unwrap();
        assert!((p50 - 0.4).abs() < 1e-9 && (max - 0.5).abs() < 1e-9, "{summary:?}");
        assert_eq!(
            (summary.accepted, summary.chunks_per_second, summary.words_per_second),
            (2, 3.0, 2.0)
        );
    }

    #[test]
    fn ends_are_told_once_in_each_epoch() {
        let mut tally = Tally::default();
        let refused = Feedback {
            instance: 6,
            session: 5,
            plan_id: 1,
            verdict: 2,
            check: 16,
            ..Feedback::zeroed()
        };
        let told = |tally: &mut Tally, word: &Feedback| {
            tally
                .note_word(word, 1.0)
                .into_iter()
                .filter(|news| matches!(news, News::Refused { .. } | News::Finished { .. }))
                .count()
        };
        assert_eq!((told(&mut tally, &refused), told(&mut tally, &refused)), (1, 0));
        let again = Feedback { epoch: 1, ..refused };
        assert_eq!(told(&mut tally, &again), 1);
        let finished = Feedback { verdict: 1, finished: 1, ..again };
        assert_eq!((told(&mut tally, &finished), told(&mut tally, &finished)), (1, 0));
    }
}
