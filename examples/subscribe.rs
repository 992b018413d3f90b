//! Receives the messages of a running walk in another process, without taking part.
//!
//! `surefoot walk SCENARIO --rate 1 & cargo run --release --example subscribe walk-$!`

#![allow(clippy::print_stdout, reason = "an example prints")]

use std::time::Duration;

use surefoot::{Message, Subscriber};

/// Time between two looks where no message comes.
const PAUSE: Duration = Duration::from_millis(1);
/// Attempts to attach, a tenth of a second apart.
const ATTEMPTS_MAX: usize = 100;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let Some(name) = std::env::args().nth(1) else {
        println!("usage: subscribe INSTANCE");
        return Ok(());
    };
    let mut subscriber = attach(&name)?;
    let mut missed = 0;
    let mut next_sequence = 0;
    loop {
        match subscriber.next()? {
            Some(Message::Chunk(chunk)) => {
                missed += chunk.sequence.saturating_sub(next_sequence);
                next_sequence = chunk.sequence + 1;
                println!("chunk {}: {} waypoints", chunk.sequence, chunk.waypoints().len());
            }
            Some(Message::Feedback(feedback)) => println!("accepted {}", feedback.next_sequence),
            Some(Message::Status(_) | Message::State(_)) => {}
            None if subscriber.is_attended() => std::thread::sleep(PAUSE),
            None => break,
        }
    }
    println!("the walk is over; {missed} chunks were missed");
    Ok(())
}

/// Attaches once the walk has created its instance.
fn attach(name: &str) -> Result<Subscriber, surefoot::TransportError> {
    for _ in 1..ATTEMPTS_MAX {
        match Subscriber::open(name) {
            Ok(subscriber) if subscriber.is_attended() => return Ok(subscriber),
            _ => std::thread::sleep(100 * PAUSE),
        }
    }
    Subscriber::open(name)
}
