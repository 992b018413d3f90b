use bytemuck::Zeroable;

use super::*;

const ME: u64 = 9;

fn stream(session: u64, plan_id: u64, len: u64, time: f64) -> Vec<PlanChunk> {
    let mut chunks: Vec<PlanChunk> = Vec::new();
    for sequence in 0..len {
        let stream = chunks.last().map_or(Digest::default(), PlanChunk::stream_after);
        let flags = if sequence + 1 == len { FLAG_LAST } else { 0 };
        let mut chunk = PlanChunk {
            session,
            target_instance: ME,
            plan_id,
            sequence,
            stream,
            flags,
            ..PlanChunk::zeroed()
        };
        chunk.waypoints[0].time = time;
        chunk.seal();
        chunks.push(chunk);
    }
    chunks
}

fn walk(position: &mut Position, chunk: &PlanChunk) -> Admission {
    let admission = position.admit(chunk);
    match admission {
        Admission::Judge => {
            position.accept(chunk, chunk.stream_after(), &Margins::UNMEASURED, chunk)
        }
        Admission::Refuse(check) => position.refuse(check, 0, None),
        Admission::Ignore => {}
    }
    admission
}

#[test]
fn duplicates_gaps_and_foreign_chunks_are_counted_and_not_judged() {
    let chunks = stream(1, 1, 4, 0.0);
    let mut position = Position::new(ME);
    let mut foreign = chunks[1];
    foreign.target_instance = 8;
    foreign.seal();
    let given = [
        &chunks[1], &chunks[0], &chunks[0], &foreign, &chunks[3], &chunks[1], &chunks[2],
        &chunks[3], &chunks[3],
    ];
    let judged: Vec<u64> = given
        .into_iter()
        .filter(|chunk| walk(&mut position, chunk) == Admission::Judge)
        .map(|chunk| chunk.sequence)
        .collect();
    assert_eq!(judged, [0, 1, 2, 3]);
    assert!(position.is_finished());
    assert_eq!(
        position.tally(),
        Tally { received: 9, accepted: 4, duplicates: 2, gaps: 2, leftovers: 0, foreign: 1 }
    );
    assert_eq!(position.feedback(1).stream, chunks[3].stream_after());
}

#[test]
fn damage_is_seen_before_any_field_is_believed() {
    let chunks = stream(1, 1, 2, 0.0);
    for bit in 0..8 * std::mem::offset_of!(PlanChunk, contacts) {
        let mut position = Position::new(ME);
        let mut damaged = chunks[0];
        bytemuck::bytes_of_mut(&mut damaged)[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(
            walk(&mut position, &damaged),
            Admission::Refuse(Check::Crc),
            "header bit {bit}"
        );
        assert_eq!(walk(&mut position, &damaged), Admission::Ignore, "a refusal stays");
        let word = position.feedback(1);
        assert_eq!(
            (word.verdict, word.check, word.session),
            (Verdict::Refused as u32, Check::Crc as u32, 0)
        );
    }
}

#[test]
fn another_stream_under_the_same_name_is_refused() {
    let mut position = Position::new(ME);
    walk(&mut position, &stream(1, 1, 3, 0.0)[0]);
    assert_eq!(walk(&mut position, &stream(1, 1, 3, 5.0)[1]), Admission::Refuse(Check::Stream));
    assert_eq!(walk(&mut position, &stream(1, 1, 3, 0.0)[1]), Admission::Ignore);
    assert_eq!(
        position.refusal(),
        Some(Refusal { sequence: 1, check: Check::Stream, waypoint: 0 })
    );
}

#[test]
fn a_restarted_planner_goes_on_and_its_predecessor_is_silenced() {
    let (old, new) = (stream(1, 1, 4, 0.0), stream(2, 1, 4, 0.0));
    let mut position = Position::new(ME);
    walk(&mut position, &old[0]);
    walk(&mut position, &old[1]);
    assert_eq!(
        walk(&mut position, &new[0]),
        Admission::Ignore,
        "the same first chunk is not walked again"
    );
    assert_eq!(walk(&mut position, &old[2]), Admission::Ignore, "the old session is over");
    assert_eq!(walk(&mut position, &new[2]), Admission::Judge);
    assert_eq!(
        position.tally(),
        Tally { received: 5, accepted: 3, duplicates: 1, gaps: 0, leftovers: 1, foreign: 0 }
    );
}

#[test]
fn a_restarted_planner_with_another_plan_starts_over() {
    let mut position = Position::new(ME);
    walk(&mut position, &stream(1, 1, 4, 0.0)[0]);
    let new = stream(2, 1, 4, 5.0);
    assert!(new.iter().all(|chunk| walk(&mut position, chunk) == Admission::Judge));
    assert!(position.is_finished());
}

#[test]
fn a_new_epoch_clears_the_refusal_and_an_old_plan_is_a_leftover() {
    let mut position = Position::new(ME);
    let first = stream(1, 3, 3, 0.0);
    walk(&mut position, &first[0]);
    position.refuse(Check::Balance, 4, None);
    assert_eq!(walk(&mut position, &first[1]), Admission::Ignore);
    let mut replanned = first[0];
    replanned.epoch = 1;
    replanned.seal();
    assert_eq!(walk(&mut position, &replanned), Admission::Judge);
    assert_eq!(position.refusal(), None);
    assert_eq!(walk(&mut position, &stream(1, 2, 3, 0.0)[0]), Admission::Ignore);
    assert_eq!(position.tally().leftovers, 1);
}

#[test]
fn the_margins_are_those_of_the_plan_that_is_walked() {
    let mut position = Position::new(ME);
    let mut accept = |chunk: &PlanChunk, balance: f64| {
        assert_eq!(position.admit(chunk), Admission::Judge);
        position.accept(
            chunk,
            chunk.stream_after(),
            &Margins { balance, ..Margins::UNMEASURED },
            chunk,
        );
        position.feedback(1).margins.balance
    };
    let (first, second) = (stream(1, 1, 2, 0.0), stream(1, 2, 1, 0.0));
    assert_eq!([accept(&first[0], 0.01), accept(&first[1], 0.02)], [0.01, 0.01]);
    assert_eq!(accept(&second[0], 0.03), 0.03, "another plan");
    let mut replanned = PlanChunk { epoch: 1, ..second[0] };
    replanned.seal();
    assert_eq!(accept(&replanned, 0.04), 0.04, "another epoch, as the walker counts");
}

#[test]
fn a_successor_stands_where_the_robot_was_left() {
    let chunks = stream(1, 1, 4, 0.0);
    let mut position = Position::new(ME);
    walk(&mut position, &chunks[0]);
    walk(&mut position, &chunks[1]);
    position.refuse(Check::WorldDiffers, 2, Some(Correction::missing(3)));
    let record = RobotRecord {
        stream_after_first: position.stream_after_first(),
        word: position.feedback(5),
        ..RobotRecord::zeroed()
    };
    let mut next = Position::take_over(10, &record);
    let (before, after) = (position.feedback(6), next.feedback(1));
    assert_eq!(
        (after.instance, after.next_sequence, after.walked, after.stream),
        (10, 2, 2, before.stream)
    );
    assert_eq!(
        (after.verdict, after.check, after.corrections()),
        (before.verdict, before.check, before.corrections())
    );
    assert_eq!(walk(&mut next, &chunks[2]), Admission::Ignore, "meant for the one before");
    let mut chunk = PlanChunk { target_instance: 10, session: 2, epoch: 1, ..chunks[0] };
    chunk.seal();
    assert_eq!(walk(&mut next, &chunk), Admission::Judge, "a new epoch goes on");
    assert_eq!((next.feedback(2).walked, next.feedback(2).corrections().len()), (3, 1));
}

#[test]
fn corrections_add_up_until_there_is_no_room() {
    let mut position = Position::new(ME);
    for shape in 0..CORRECTIONS_MAX as u32 + 8 {
        position.refuse(Check::WorldDiffers, 0, Some(Correction::missing(shape)));
        assert!(position.feedback(1).is_well_formed());
    }
    assert_eq!(position.feedback(1).corrections().len(), CORRECTIONS_MAX);
}
