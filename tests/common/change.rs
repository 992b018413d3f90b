//! Changes of valid inputs, for fuzz tests.

use crate::random::Random;

/// Text that readers meet seldom.
const WORDS: [&str; 20] = [
    "nan",
    "inf",
    "-1",
    "0",
    "1e999",
    "-0.0",
    "99999999999999999999",
    "4294967295",
    "1e-320",
    "\0",
    "\u{feff}",
    "\"",
    "<!--",
    "]]>",
    "&amp;",
    "{",
    "[",
    "\\",
    "\r\n",
    "é",
];
/// Numbers in binary files, little-endian.
const NUMBERS: [u32; 6] = [0, 1, u32::MAX, 0x7fc0_0000, 0x7f7f_ffff, 0x8000_0000];
/// Most changes of one input.
const CHANGES_MAX: u64 = 4;
/// Largest input that a change makes, bytes.
const BYTES_MAX: usize = 1 << 20;

/// A copy of one seed with some changes.
pub fn changed(seeds: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let pick = |random: &mut Random| &seeds[random.below(seeds.len() as u64) as usize];
    let mut bytes = pick(random).clone();
    for _ in 0..=random.below(CHANGES_MAX) {
        let other = pick(random);
        change(&mut bytes, other, random);
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    let at = random.below(bytes.len() as u64 + 1) as usize;
    let end = (at + random.below(64) as usize).min(bytes.len());
    match random.below(9) {
        0 => bytes.truncate(at),
        1 => drop(bytes.drain(at..end)),
        2 => insert(bytes, at, &[random.next() as u8]),
        3 => insert(bytes, at, WORDS[random.below(WORDS.len() as u64) as usize].as_bytes()),
        4 => replace_word(bytes, at, random),
        5 => {
            let copy = bytes[at..end].repeat(1 + random.below(40) as usize);
            insert(bytes, at, &copy);
        }
        6 => {
            let from = random.below(other.len() as u64 + 1) as usize;
            let until = (from + random.below(400) as usize).min(other.len());
            insert(bytes, at, &other[from..until]);
        }
        7 => write_number(bytes, at, random),
        _ => {
            if let Some(byte) = bytes.get_mut(at) {
                *byte = random.next() as u8;
            }
        }
    }
}

fn insert(bytes: &mut Vec<u8>, at: usize, new: &[u8]) {
    if bytes.len() + new.len() <= BYTES_MAX {
        bytes.splice(at..at, new.iter().copied());
    }
}

/// Replaces the word or number after a place.
fn replace_word(bytes: &mut Vec<u8>, at: usize, random: &mut Random) {
    let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-._".contains(byte);
    let Some(first) = bytes[at..].iter().position(is_word).map(|offset| at + offset) else {
        return;
    };
    let len = bytes[first..].iter().take_while(|byte| is_word(byte)).count();
    let new = WORDS[random.below(WORDS.len() as u64) as usize];
    bytes.splice(first..first + len, new.bytes());
}

fn write_number(bytes: &mut [u8], at: usize, random: &mut Random) {
    let number = NUMBERS[random.below(NUMBERS.len() as u64) as usize];
    if let Some(space) = bytes.get_mut(at..at + 4) {
        space.copy_from_slice(&number.to_le_bytes());
    }
}
