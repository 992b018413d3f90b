use bytemuck::Zeroable;
use surefoot_shared_types::message::feedback::FEEDBACK_SCHEMA;

use surefoot_shared_types::message::Sealed;

use super::*;

const SESSION: u64 = 77;

fn stream(len: u64) -> Vec<PlanChunk> {
    let mut chunks: Vec<PlanChunk> = Vec::new();
    for sequence in 0..len {
        let stream = chunks.last().map_or(Digest::default(), PlanChunk::stream_after);
        chunks.push(PlanChunk { plan_id: 1, sequence, stream, ..PlanChunk::zeroed() });
    }
    chunks
}

fn word(instance: u64, count: u64, accepted: u64, chunks: &[PlanChunk]) -> Feedback {
    let stream = if accepted == 0 {
        Digest::default()
    } else {
        chunks[accepted as usize - 1].stream_after()
    };
    sealed(Feedback {
        schema: FEEDBACK_SCHEMA,
        instance,
        count,
        session: SESSION,
        plan_id: 1,
        next_sequence: accepted,
        stream,
        ..Feedback::zeroed()
    })
}

fn sealed(mut feedback: Feedback) -> Feedback {
    feedback.seal();
    feedback
}

fn send_all(window: &mut Window<'_>) -> Vec<u64> {
    let mut sent = Vec::new();
    while let Some((place, _)) = window.to_send() {
        sent.push(window.chunk(place).sequence);
        window.note_sent();
    }
    sent
}

#[test]
fn the_window_waits_for_a_controller_and_never_exceeds_its_credit() {
    let chunks = stream(20);
    let mut window = Window::new(&chunks, SESSION, 8).unwrap();
    assert!(window.to_send().is_none());
    assert!(window.hear(&word(5, 1, 0, &chunks)));
    assert_eq!(window.to_send().unwrap().1, 5);
    assert_eq!(send_all(&mut window), (0..8).collect::<Vec<_>>());
    window.hear(&word(5, 2, 3, &chunks));
    assert_eq!(send_all(&mut window), [8, 9, 10]);
    window.hear(&word(5, 3, 20, &chunks));
    assert_eq!(window.outcome(), Some(Outcome::Accepted));
}

#[test]
fn only_an_idle_controller_is_sent_chunks_again() {
    let chunks = stream(4);
    let mut window = Window::new(&chunks, SESSION, 8).unwrap();
    window.hear(&word(5, 1, 0, &chunks));
    send_all(&mut window);
    assert!(!window.go_back(), "a silent controller may be walking");
    window.hear(&word(5, 2, 1, &chunks));
    for count in 3..3 + IDLE_HEARTBEATS {
        assert!(!window.go_back());
        window.hear(&word(5, count, 1, &chunks));
    }
    assert!(window.go_back());
    assert_eq!(send_all(&mut window), [1, 2, 3]);
    assert_eq!(window.counts(), (7, 3));
}

#[test]
fn a_new_controller_starts_at_its_own_place_and_the_old_one_is_not_heard_again() {
    let chunks = stream(6);
    let mut window = Window::new(&chunks, SESSION, 8).unwrap();
    window.hear(&word(5, 1, 0, &chunks));
    send_all(&mut window);
    window.hear(&word(5, 2, 4, &chunks));
    window.hear(&word(6, 1, 0, &chunks));
    assert_eq!(window.acknowledged(), 0);
    assert!(!window.hear(&word(5, 3, 6, &chunks)));
    assert_eq!(window.outcome(), None);
    assert_eq!(send_all(&mut window), (0..6).collect::<Vec<_>>());
}

#[test]
fn a_new_planner_goes_on_where_the_stream_stands_but_not_in_another_one() {
    let chunks = stream(6);
    let mut foreign = stream(6);
    foreign[2].waypoints[0].time = 1.0;
    for index in 3..6 {
        foreign[index].stream = foreign[index - 1].stream_after();
    }
    let mut window = Window::new(&chunks, SESSION, 8).unwrap();
    window.hear(&sealed(Feedback { session: 1, ..word(5, 1, 4, &chunks) }));
    assert_eq!(send_all(&mut window), [4, 5]);
    let mut window = Window::new(&chunks, SESSION, 8).unwrap();
    window.hear(&sealed(Feedback { session: 1, finished: 1, ..word(5, 1, 6, &foreign) }));
    assert_eq!((window.outcome(), window.acknowledged()), (None, 0));
    assert_eq!(send_all(&mut window), (0..6).collect::<Vec<_>>());
}

#[test]
fn refusals_end_it_unless_they_are_of_another_session() {
    let chunks = stream(6);
    let refused = |session| {
        sealed(Feedback {
            verdict: 2,
            check: 3,
            refused_waypoint: 9,
            session,
            ..word(5, 1, 0, &chunks)
        })
    };
    let mut window = Window::new(&chunks, SESSION, 8).unwrap();
    window.hear(&refused(1));
    assert_eq!(window.outcome(), None);
    window.hear(&refused(SESSION));
    assert_eq!(
        window.outcome(),
        Some(Outcome::Refused { sequence: 0, check: Check::Collision, waypoint: 9 })
    );
    assert!(window.to_send().is_none());
}

#[test]
fn lies_do_not_move_the_window() {
    let chunks = stream(6);
    let mut window = Window::new(&chunks, SESSION, 8).unwrap();
    window.hear(&word(5, 1, 2, &chunks));
    let good = word(5, 2, 4, &chunks);
    let lies = [
        Feedback { next_sequence: 7, ..good },
        Feedback { next_sequence: u64::MAX, ..good },
        Feedback { next_sequence: 3, ..good },
        Feedback { plan_id: 2, ..good },
        Feedback { stream: Digest([9; 32]), ..good },
        Feedback { schema: 0, ..good },
        word(5, 2, 1, &chunks),
    ];
    for lie in &lies {
        window.hear(&sealed(*lie));
        assert_eq!(window.acknowledged(), 2);
    }
    assert!(!window.hear(&Feedback { next_sequence: 5, ..good }), "a damaged word");
    window.hear(&good);
    assert_eq!(window.acknowledged(), 4);
}

#[test]
fn a_broken_stream_is_not_sent() {
    let index_of = |chunks: &[PlanChunk]| match Window::new(chunks, SESSION, 8) {
        Err(ChannelError::Stream { index }) => Some(index),
        _ => None,
    };
    assert_eq!(index_of(&[]), Some(0));
    assert_eq!(index_of(&stream(3)[1..]), Some(0));
    let mut chunks = stream(4);
    chunks.swap(1, 2);
    assert_eq!(index_of(&chunks), Some(1));
    let mut chunks = stream(4);
    chunks[2].waypoints[1].time = 3.0;
    assert_eq!(index_of(&chunks), Some(3));
    let mut chunks = stream(4);
    chunks[3].epoch = 1;
    assert_eq!(index_of(&chunks), Some(3));
}

#[test]
fn a_controller_that_never_takes_anything_is_given_up() {
    let chunks = stream(2);
    let mut window = Window::new(&chunks, SESSION, 8).unwrap();
    let mut rounds = 0;
    for count in 1.. {
        window.hear(&word(5, count, 0, &chunks));
        if window.outcome().is_some() {
            break;
        }
        send_all(&mut window);
        rounds += u32::from(window.go_back());
    }
    assert_eq!((window.outcome(), rounds), (Some(Outcome::ControllerLost), GO_BACKS_MAX));
}

#[test]
fn a_controller_that_judges_is_not_idle() {
    let chunks = stream(4);
    let mut window = Window::new(&chunks, SESSION, 8).unwrap();
    window.hear(&word(5, 1, 0, &chunks));
    send_all(&mut window);
    for count in 2..20 {
        window.hear(&sealed(Feedback { busy: 1, ..word(5, count, 0, &chunks) }));
        assert!(!window.go_back());
    }
}

#[test]
fn a_plan_that_was_made_again_meanwhile_is_out_of_date() {
    let chunks = stream(4);
    let mut window = Window::new(&chunks, SESSION, 8).unwrap();
    window.hear(&sealed(Feedback { epoch: 2, session: 1, ..word(5, 1, 3, &chunks) }));
    assert_eq!(window.outcome(), Some(Outcome::Superseded));
    assert!(window.to_send().is_none());
}
