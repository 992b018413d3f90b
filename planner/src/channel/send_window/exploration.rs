//! Explores every order of events, up to a depth, of a window over a stream that grows, a lossy
//! channel, a controller and a planner that are killed and started again, and one forged
//! acceptance. From every state reached, a channel that loses nothing more must complete the
//! delivery.

use std::collections::BTreeSet;
use std::time::Duration;

use surefoot_shared_types::message::PlanChunk;

use crate::channel::chunk_source::SourceState;
use crate::channel::send_window::tests::{SESSION, feedback, stream};
use crate::channel::send_window::{DeliveryOutcome, SendWindow};
use crate::channel::tuning::{CONTRADICTIONS_MAX, TAKEOVER_SILENCE};

/// Chunks of the plan.
const CHUNKS: usize = 3;
/// Chunks in flight.
const WINDOW: usize = 2;
/// Events of an order.
const DEPTH: usize = 7;
/// Rounds in which a channel without losses must complete the delivery.
const ROUNDS_MAX: usize = 60;
/// Time between two feedback messages.
const TICK: Duration = Duration::from_millis(1);

/// The window, the channel in both directions, and the controller.
#[derive(Clone)]
struct World {
    window: SendWindow,
    chunks: &'static [PlanChunk],
    /// Chunks that the planner has made.
    made: usize,
    at: Duration,
    controller: u64,
    count: u64,
    /// Chunks that the robot has executed; the journal keeps it.
    executed: usize,
    /// Chunks on their way, with the controller that they are for.
    sent: Vec<(usize, u64)>,
    /// The latest feedback on its way: controller, count and acknowledged chunks.
    feedback: Option<(u64, u64, usize)>,
    is_forged: bool,
}

/// An event.
#[derive(Debug, Clone, Copy)]
enum Event {
    Send,
    ReceiveChunk,
    LoseChunk,
    RepeatChunk,
    Heartbeat,
    ReceiveFeedback,
    LoseFeedback,
    Timeout,
    RestartController,
    MakeChunk,
    RestartPlanner,
    Forge,
}

const EVENTS: [Event; 12] = [
    Event::Send,
    Event::ReceiveChunk,
    Event::LoseChunk,
    Event::RepeatChunk,
    Event::Heartbeat,
    Event::ReceiveFeedback,
    Event::LoseFeedback,
    Event::Timeout,
    Event::RestartController,
    Event::MakeChunk,
    Event::RestartPlanner,
    Event::Forge,
];

impl World {
    fn new() -> Self {
        let chunks: &'static [PlanChunk] = Vec::leak(stream(CHUNKS as u64));
        let window = SendWindow::new(SESSION, WINDOW);
        let (at, sent) = (Duration::ZERO, vec![]);
        let mut world = Self {
            window,
            chunks,
            made: 0,
            at,
            controller: 1,
            count: 0,
            executed: 0,
            sent,
            feedback: None,
            is_forged: false,
        };
        world.heartbeat();
        world
    }

    fn apply(&mut self, event: Event) {
        match event {
            Event::Send => self.send(),
            Event::ReceiveChunk => self.receive_chunk(),
            Event::LoseChunk => drop((!self.sent.is_empty()).then(|| self.sent.remove(0))),
            Event::RepeatChunk => self.sent.extend(self.sent.first().copied()),
            Event::Heartbeat => self.heartbeat(),
            Event::ReceiveFeedback => self.receive_feedback(),
            Event::LoseFeedback => self.feedback = None,
            Event::Timeout => drop(self.window.go_back()),
            Event::RestartController => {
                (self.controller, self.count) = (self.controller + 1, 0);
                self.heartbeat();
            }
            Event::MakeChunk => self.make_chunk(),
            Event::RestartPlanner => {
                (self.window, self.made) = (SendWindow::new(SESSION, WINDOW), 0)
            }
            Event::Forge if !self.is_forged => {
                self.is_forged = true;
                self.feedback = Some((self.controller, self.count, CHUNKS));
            }
            Event::Forge => {}
        }
    }

    fn send(&mut self) {
        if let Some((index, controller)) = self.window.to_send() {
            self.window.record_sent();
            self.sent.push((index, controller));
        }
    }

    fn make_chunk(&mut self) {
        self.made = (self.made + 1).min(CHUNKS);
        let state = if self.made == CHUNKS { SourceState::Complete } else { SourceState::Open };
        self.window.extend(&self.chunks[..self.made], state).unwrap();
    }

    fn receive_chunk(&mut self) {
        if self.sent.is_empty() {
            return;
        }
        let (index, controller) = self.sent.remove(0);
        if controller == self.controller {
            self.executed += usize::from(index == self.executed);
            self.heartbeat();
        }
    }

    fn heartbeat(&mut self) {
        self.count += 1;
        self.feedback = Some((self.controller, self.count, self.executed));
    }

    fn receive_feedback(&mut self) {
        let Some((controller, count, accepted)) = self.feedback.take() else { return };
        self.at += TICK;
        let feedback = feedback(controller, count, accepted as u64, self.chunks);
        // The controller before has been killed, so it is silent.
        self.window.receive(&feedback, self.at, TAKEOVER_SILENCE);
    }

    fn check(&self) {
        let progress = self.window.progress;
        assert!(progress.next <= progress.acknowledged + WINDOW);
        if !self.is_forged {
            assert!(progress.acknowledged <= self.executed, "acknowledged before it is executed");
            assert_eq!(self.window.disputes.contradictions, 0);
        }
    }

    /// Whether the delivery completes if nothing more is lost.
    fn completes(mut self) -> bool {
        for _ in 0..ROUNDS_MAX {
            self.make_chunk();
            self.heartbeat();
            self.receive_feedback();
            self.window.go_back();
            while self.window.to_send().is_some() {
                self.send();
            }
            while !self.sent.is_empty() {
                self.receive_chunk();
            }
            if self.window.outcome(self.at) == Some(DeliveryOutcome::Accepted) {
                return self.executed == CHUNKS;
            }
        }
        false
    }

    /// The part of the state that decides what follows, with controllers relative to the current.
    fn key(&self) -> Vec<u64> {
        let progress = self.window.progress;
        let relative = |controller: u64| self.controller - controller;
        let mut key = vec![
            self.executed as u64,
            self.made as u64,
            u64::from(self.window.is_behind),
            progress.acknowledged as u64,
            progress.next as u64,
            self.window.stall.idle_heartbeats.min(9),
            u64::from(self.window.disputes.lower_acknowledgements),
            u64::from(self.window.disputes.contradictions),
            self.window.controllers.current().map_or(99, relative),
            u64::from(self.is_forged),
        ];
        let on_its_way =
            self.feedback.map_or([9, 9], |(id, _, accepted)| [relative(id), accepted as u64]);
        key.extend(on_its_way);
        key.extend(self.sent.iter().flat_map(|(index, id)| [*index as u64, relative(*id)]));
        key
    }
}

#[test]
fn every_order_of_events_completes_without_a_chunk_lost_or_executed_twice() {
    let mut seen = BTreeSet::new();
    let mut reached = vec![World::new()];
    for _ in 0..DEPTH {
        let mut next = vec![];
        for world in &reached {
            for event in EVENTS {
                let mut after = world.clone();
                after.apply(event);
                after.check();
                if seen.insert(after.key()) {
                    assert!(after.clone().completes(), "{event:?} after {:?}", world.key());
                    next.push(after);
                }
            }
        }
        reached = next;
    }
    assert!(seen.len() > 500, "{}", seen.len());
    const { assert!(CONTRADICTIONS_MAX > 2) };
}
