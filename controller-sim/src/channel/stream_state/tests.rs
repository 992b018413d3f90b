use bytemuck::Zeroable;

use crate::channel::stream_state::*;

const ME: u64 = 9;

fn stream(session: u64, plan_id: u64, len: u64, time: f64) -> Vec<PlanChunk> {
    let mut chunks: Vec<PlanChunk> = Vec::new();
    for sequence in 0..len {
        let stream = chunks.last().map_or(Digest::default(), PlanChunk::stream_after);
        let flags = if sequence + 1 == len { FLAG_LAST } else { 0 };
        let mut chunk = PlanChunk {
            session,
            target_controller: ME,
            plan_id,
            sequence,
            stream,
            flags,
            waypoints_len: 1,
            ..PlanChunk::zeroed()
        };
        chunk.waypoints[0].time = time;
        chunk.write_crc();
        chunks.push(chunk);
    }
    chunks
}

fn walk(state: &mut StreamState, chunk: &PlanChunk) -> ChunkTriage {
    let triage = state.triage(chunk);
    match triage {
        ChunkTriage::Check => {
            state.accept(chunk, chunk.stream_after(), &Margins::UNMEASURED, chunk)
        }
        ChunkTriage::Refuse(check) => state.refuse(check, 0, None),
        ChunkTriage::Ignore => {}
    }
    triage
}

#[test]
fn duplicates_gaps_and_foreign_chunks_are_counted_and_not_checked() {
    let chunks = stream(1, 1, 4, 0.0);
    let mut state = StreamState::new(ME);
    let mut foreign = chunks[1];
    foreign.target_controller = 8;
    foreign.write_crc();
    let given = [
        &chunks[1], &chunks[0], &chunks[0], &foreign, &chunks[3], &chunks[1], &chunks[2],
        &chunks[3], &chunks[3],
    ];
    let checked: Vec<u64> = given
        .into_iter()
        .filter(|chunk| walk(&mut state, chunk) == ChunkTriage::Check)
        .map(|chunk| chunk.sequence)
        .collect();
    assert_eq!(checked, [0, 1, 2, 3]);
    assert!(state.is_finished());
    assert_eq!(
        state.stats(),
        ReceiverStats {
            received: 9,
            accepted: 4,
            duplicates: 2,
            gaps: 2,
            stale: 0,
            foreign: 1,
            damaged: 0,
            other_senders: 0,
        }
    );
    assert_eq!(state.feedback(1, WalkProgress::default()).stream, chunks[3].stream_after());
}

#[test]
fn damage_is_detected_before_any_field_is_used() {
    let chunks = stream(1, 1, 2, 0.0);
    for bit in 0..8 * std::mem::offset_of!(PlanChunk, contacts) {
        let mut state = StreamState::new(ME);
        let mut damaged = chunks[0];
        bytemuck::bytes_of_mut(&mut damaged)[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(walk(&mut state, &damaged), ChunkTriage::Ignore, "header bit {bit}");
        assert_eq!((state.stats().damaged, state.refusal()), (1, None));
        let feedback = state.feedback(1, WalkProgress::default());
        assert_eq!((feedback.verdict, feedback.session), (Verdict::Waiting as u32, 0));
        assert_eq!(walk(&mut state, &chunks[0]), ChunkTriage::Check, "the planner's own follows");
    }
}

#[test]
fn another_stream_under_the_same_name_is_refused() {
    let mut state = StreamState::new(ME);
    walk(&mut state, &stream(1, 1, 3, 0.0)[0]);
    assert_eq!(walk(&mut state, &stream(1, 1, 3, 5.0)[1]), ChunkTriage::Refuse(Check::Stream));
    assert_eq!(walk(&mut state, &stream(1, 1, 3, 0.0)[1]), ChunkTriage::Ignore);
    assert_eq!(state.refusal(), Some(Refusal { sequence: 1, check: Check::Stream, waypoint: 0 }));
}

#[test]
fn a_restarted_planner_continues_and_its_predecessor_is_stale() {
    let (old, new) = (stream(1, 1, 4, 0.0), stream(2, 1, 4, 0.0));
    let mut state = StreamState::new(ME);
    walk(&mut state, &old[0]);
    walk(&mut state, &old[1]);
    assert_eq!(
        walk(&mut state, &new[0]),
        ChunkTriage::Ignore,
        "the same first chunk is not walked again"
    );
    assert_eq!(walk(&mut state, &old[2]), ChunkTriage::Ignore, "the old session is over");
    assert_eq!(walk(&mut state, &new[2]), ChunkTriage::Check);
    assert_eq!(
        state.stats(),
        ReceiverStats {
            received: 5,
            accepted: 3,
            duplicates: 1,
            gaps: 0,
            stale: 1,
            foreign: 0,
            damaged: 0,
            other_senders: 0,
        }
    );
}

#[test]
fn a_restarted_planner_with_another_plan_starts_over() {
    let mut state = StreamState::new(ME);
    walk(&mut state, &stream(1, 1, 4, 0.0)[0]);
    let new = stream(2, 1, 4, 5.0);
    assert!(new.iter().all(|chunk| walk(&mut state, chunk) == ChunkTriage::Check));
    assert!(state.is_finished());
}

#[test]
fn a_new_epoch_clears_the_refusal_and_an_old_plan_is_stale() {
    let mut state = StreamState::new(ME);
    let first = stream(1, 3, 3, 0.0);
    walk(&mut state, &first[0]);
    state.refuse(Check::Balance, 4, None);
    assert_eq!(walk(&mut state, &first[1]), ChunkTriage::Ignore);
    let mut replanned = first[0];
    replanned.epoch = 1;
    replanned.write_crc();
    assert_eq!(walk(&mut state, &replanned), ChunkTriage::Check);
    assert_eq!(state.refusal(), None);
    assert_eq!(walk(&mut state, &stream(1, 2, 3, 0.0)[0]), ChunkTriage::Ignore);
    assert_eq!(state.stats().stale, 1);
}

#[test]
fn margins_are_those_of_the_plan_in_execution() {
    let mut state = StreamState::new(ME);
    let mut accept = |chunk: &PlanChunk, balance: f64| {
        assert_eq!(state.triage(chunk), ChunkTriage::Check);
        state.accept(
            chunk,
            chunk.stream_after(),
            &Margins { balance, ..Margins::UNMEASURED },
            chunk,
        );
        state.feedback(1, WalkProgress::default()).margins.balance
    };
    let (first, second) = (stream(1, 1, 2, 0.0), stream(1, 2, 1, 0.0));
    assert_eq!([accept(&first[0], 0.01), accept(&first[1], 0.02)], [0.01, 0.01]);
    assert_eq!(accept(&second[0], 0.03), 0.03, "another plan");
    let mut replanned = PlanChunk { epoch: 1, ..second[0] };
    replanned.write_crc();
    assert_eq!(accept(&replanned, 0.04), 0.04, "another epoch, as the executor counts");
}

#[test]
fn a_successor_starts_from_the_last_rest_state() {
    let chunks = stream(1, 1, 4, 0.0);
    let mut state = StreamState::new(ME);
    walk(&mut state, &chunks[0]);
    walk(&mut state, &chunks[1]);
    state.refuse(Check::WorldDiffers, 2, Some(WorldCorrection::missing(3)));
    let record = JournalRecord {
        stream_after_first: state.stream_after_first(),
        feedback: state.feedback(5, WalkProgress::default()),
        ..JournalRecord::zeroed()
    };
    let mut next = StreamState::take_over(10, &record, None);
    let (before, after) =
        (state.feedback(6, WalkProgress::default()), next.feedback(1, WalkProgress::default()));
    assert_eq!(
        (after.controller_id, after.next_sequence, after.walked, after.stream),
        (10, 2, 2, before.stream)
    );
    assert_eq!(
        (after.verdict, after.check, after.corrections()),
        (before.verdict, before.check, before.corrections())
    );
    assert_eq!(walk(&mut next, &chunks[2]), ChunkTriage::Ignore, "meant for the one before");
    let mut chunk = PlanChunk { target_controller: 10, session: 2, epoch: 1, ..chunks[0] };
    chunk.write_crc();
    assert_eq!(walk(&mut next, &chunk), ChunkTriage::Check, "a new epoch goes on");
    assert_eq!(
        (
            next.feedback(2, WalkProgress::default()).walked,
            next.feedback(2, WalkProgress::default()).corrections().len()
        ),
        (3, 1)
    );
}

#[test]
fn corrections_accumulate_up_to_the_limit() {
    let mut state = StreamState::new(ME);
    for shape in 0..CORRECTIONS_MAX as u32 + 8 {
        state.refuse(Check::WorldDiffers, 0, Some(WorldCorrection::missing(shape)));
        assert!(state.feedback(1, WalkProgress::default()).is_well_formed());
    }
    assert_eq!(state.feedback(1, WalkProgress::default()).corrections().len(), CORRECTIONS_MAX);
}
