//! A process of the same user that forges and repeats messages of a running pair.

use std::time::Duration;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::{BackpressureStrategy, ipc};
use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;
use surefoot_shared_types::instance::participant::Participant;
use surefoot_shared_types::message::chunk::FLAG_FIRST;
use surefoot_shared_types::message::{Check, Feedback, PlanChunk, Verdict, WithCrc};

use crate::commands::bench::soak::random::Random;

/// How often forged feedback is sent: more often than a planner has a claim repeated. Each time a
/// planner has [`REPEAT_PAUSE`] to read it, as the next one takes its place.
const REPETITIONS: u64 = 6;
/// See [`REPETITIONS`].
const REPEAT_PAUSE: Duration = Duration::from_millis(1);
/// The forger's id as a controller.
const OTHER_CONTROLLER: u64 = 0xf0f0;
/// The forger's session as a planner.
const OTHER_SESSION: u64 = 0xf0f1;

/// Forges and repeats messages, and watches the controller's own feedback.
pub(crate) struct Forger {
    observer: Observer,
    feedback: Publisher<ipc::Service, Feedback, ()>,
    chunks: Publisher<ipc::Service, PlanChunk, ()>,
    /// The controller's last feedback, and the one before.
    received: [Option<Feedback>; 2],
    last_chunk: Option<Box<PlanChunk>>,
    _participant: Participant,
}

impl Forger {
    /// Joins a running instance.
    pub(crate) fn open(name: &str) -> Result<Self, ChannelError> {
        let instance = Instance::attach(name)?;
        let observer = Observer::open(&instance)?;
        let participant = Participant::open(&instance)?;
        let making = participant.making()?;
        let failed = |error| ChannelError::transport("creating the forger's publisher", error);
        let feedback = participant.feedback.publisher_builder().create().map_err(failed)?;
        let chunks = participant
            .chunks
            .publisher_builder()
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(failed)?;
        drop(making);
        Ok(Self {
            observer,
            feedback,
            chunks,
            received: [None; 2],
            last_chunk: None,
            _participant: participant,
        })
    }

    /// Reads all messages that have arrived. A damaged transport shows in the walk.
    pub(crate) fn listen(&mut self) {
        while let Ok(Some(feedback)) = self.observer.feedback() {
            self.received = [Some(feedback), self.received[0]];
        }
        while let Ok(Some(chunk)) = self.observer.chunk() {
            self.last_chunk = Some(Box::new(chunk));
        }
    }

    /// Listens for a time.
    pub(crate) fn listen_for(&mut self, time: Duration) {
        const PAUSE: Duration = Duration::from_millis(1);
        let mut waited = Duration::ZERO;
        while waited < time {
            self.listen();
            std::thread::sleep(PAUSE);
            waited += PAUSE;
        }
    }

    /// The chunks that the robot has executed, and whether its plan is finished.
    pub(crate) fn walked(&self) -> Option<(u64, bool)> {
        self.received[0].map(|feedback| (feedback.walked, feedback.finished == 1))
    }

    /// Sends one forged or repeated message and says which; nothing if there is nothing to repeat
    /// yet.
    pub(crate) fn disturb(&self, random: &mut Random) -> Option<&'static str> {
        let last = self.received[0]?;
        let (has_sent, event) = match random.below(10) {
            0 => {
                let refusal = Feedback {
                    verdict: Verdict::Refused as u32,
                    check: Check::Torque as u32,
                    refused_sequence: last.next_sequence,
                    ..last
                };
                (self.forge(refusal), "refusal forged")
            }
            1 => {
                let next_sequence = last.next_sequence + 1;
                (self.forge(Feedback { next_sequence, ..last }), "acceptance forged")
            }
            8 => {
                let chunks = last.next_sequence + 1;
                let finished = Feedback { next_sequence: chunks, finished: 1, ..last };
                (self.forge(finished), "end of the plan forged")
            }
            9 => {
                let later = Feedback { epoch: last.epoch + 1, ..last };
                (self.forge(later), "later epoch forged")
            }
            2 => {
                let other = Feedback { controller_id: OTHER_CONTROLLER, ..last };
                (self.forge(other), "other controller forged")
            }
            3 => {
                let repeat = |before| self.forge(before);
                (self.received[1].is_some_and(repeat), "feedback repeated")
            }
            4 => {
                let damaged = |chunk: &PlanChunk| PlanChunk {
                    sequence: chunk.sequence + 1,
                    crc: !chunk.crc,
                    ..*chunk
                };
                (self.send_chunk(damaged), "damaged chunk forged")
            }
            5 => (self.send_chunk(|chunk| next_chunk(chunk, &last)), "next chunk forged"),
            6 => (self.send_chunk(|chunk| other_plan(chunk, &last)), "other plan forged"),
            _ => (self.send_chunk(|chunk| *chunk), "chunk repeated"),
        };
        has_sent.then_some(event)
    }

    /// Publishes forged feedback, repeated as a controller repeats its own.
    fn forge(&self, feedback: Feedback) -> bool {
        let mut forged = feedback;
        let mut has_sent = true;
        for _ in 0..REPETITIONS {
            forged.count += 1;
            forged.write_crc();
            has_sent &= self.feedback.send_copy(forged).is_ok();
            std::thread::sleep(REPEAT_PAUSE);
        }
        has_sent
    }

    /// Sends what `forge` makes of the last chunk; `false` if there is none yet.
    fn send_chunk(&self, forge: impl Fn(&PlanChunk) -> PlanChunk) -> bool {
        let last = self.last_chunk.as_deref();
        last.is_some_and(|chunk| self.chunks.send_copy(forge(chunk)).is_ok())
    }
}

/// A chunk that the controller expects, by everything but its publisher: of the session, with the
/// next number and the right CRC, but where the robot's root is elsewhere.
fn next_chunk(chunk: &PlanChunk, last: &Feedback) -> PlanChunk {
    let (session, sequence, stream) = (last.session, last.next_sequence, last.stream);
    let mut forged = PlanChunk {
        target_controller: last.controller_id,
        plan_id: last.plan_id,
        epoch: last.epoch,
        flags: if sequence == 0 { FLAG_FIRST } else { 0 },
        ..PlanChunk { session, sequence, stream, ..*chunk }
    };
    forged.waypoints.iter_mut().for_each(|waypoint| waypoint.root_position[0] += 1.0);
    forged.write_crc();
    forged
}

/// The first chunk of a plan of a planner that never was.
fn other_plan(chunk: &PlanChunk, last: &Feedback) -> PlanChunk {
    let mut forged = PlanChunk {
        session: OTHER_SESSION,
        plan_id: last.plan_id.wrapping_add(1),
        sequence: 0,
        flags: FLAG_FIRST,
        ..next_chunk(chunk, last)
    };
    forged.write_crc();
    forged
}
