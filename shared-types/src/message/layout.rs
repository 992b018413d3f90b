//! Memory layouts of messages: name, type, offset and size of every field, and a hash of them.
//!
//! Two programs share a service only if their hashes are equal: type name and size alone do not
//! show that fields changed places. The mirrors of the messages in other languages are generated
//! from this table.

use bytemuck::Pod;
use iceoryx2::prelude::ZeroCopySend;

/// One field of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Its name in Rust.
    pub name: &'static str,
    /// Its type in Rust syntax.
    pub type_name: &'static str,
    /// Offset in the message, bytes.
    pub offset: usize,
    /// Size, bytes.
    pub size: usize,
}

/// A message with a table of its fields.
pub trait Layout: Pod + ZeroCopySend + std::fmt::Debug {
    /// All fields, in order of their offsets.
    const FIELDS: &'static [Field];
    /// The hash of the message's size, of [`Self::FIELDS`] and of the hashes of messages inside it.
    const HASH: u64;
}

/// The 64-bit FNV-1a hash of `bytes`, continuing from `hash`.
pub(crate) const fn fnv(mut hash: u64, bytes: &[u8]) -> u64 {
    let mut at = 0;
    while at < bytes.len() {
        hash = (hash ^ bytes[at] as u64).wrapping_mul(0x0000_0100_0000_01b3);
        at += 1;
    }
    hash
}

/// The layout hash of a message of `size` bytes with these fields. `parts` are the layout hashes of
/// the messages inside it.
pub(crate) const fn hash_of(size: usize, fields: &[Field], parts: &[u64]) -> u64 {
    let mut hash = fnv(0xcbf2_9ce4_8422_2325, &(size as u64).to_le_bytes());
    let mut at = 0;
    while at < fields.len() {
        hash = fnv(hash, fields[at].name.as_bytes());
        hash = fnv(hash, b":");
        hash = fnv(hash, fields[at].type_name.as_bytes());
        hash = fnv(hash, &(fields[at].offset as u64).to_le_bytes());
        hash = fnv(hash, &(fields[at].size as u64).to_le_bytes());
        at += 1;
    }
    let mut at = 0;
    while at < parts.len() {
        hash = fnv(hash, &parts[at].to_le_bytes());
        at += 1;
    }
    hash
}

/// Implements [`Layout`]: `layout!(Name { field: type, ... } with [Message, ...])`. The brackets
/// hold the messages inside the message. A missing field or another type is a compile error.
macro_rules! layout {
    ($message:ident { $($field:ident: $type:ty),+ $(,)? } with [$($part:ty),*]) => {
        impl $crate::message::layout::Layout for $message {
            const FIELDS: &'static [$crate::message::layout::Field] = {
                const fn _all_fields_are_listed(message: &$message) {
                    let $message { $($field),+ } = message;
                    $(let _: &$type = $field;)+
                }
                &[$($crate::message::layout::Field {
                    name: stringify!($field),
                    type_name: stringify!($type),
                    offset: std::mem::offset_of!($message, $field),
                    size: size_of::<$type>(),
                }),+]
            };
            const HASH: u64 = $crate::message::layout::hash_of(
                size_of::<$message>(),
                <$message as $crate::message::layout::Layout>::FIELDS,
                &[$(<$part as $crate::message::layout::Layout>::HASH),*],
            );
        }
    };
}
pub(crate) use layout;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::binding::ChunkBinding;
    use crate::message::chunk::{Contact, PlanChunk, Waypoint};
    use crate::message::correction::WorldCorrection;
    use crate::message::description::Description;
    use crate::message::feedback::{Feedback, Margins};
    use crate::message::journal_record::JournalRecord;
    use crate::message::request::{PlanRequest, PlanStatus, StancePoseData};
    use crate::message::request_record::RequestRecord;
    use crate::message::rest_state::RestState;
    use crate::message::set_point::SetPoint;
    use crate::message::walk_record::WalkRecord;

    fn assert_no_gaps<M: Layout>() {
        let mut end = 0;
        for field in M::FIELDS {
            assert_eq!(field.offset, end, "{} does not follow its predecessor", field.name);
            end += field.size;
        }
        assert_eq!(end, size_of::<M>());
        assert_eq!(align_of::<M>(), 8);
    }

    #[test]
    fn no_message_has_padding() {
        assert_no_gaps::<Waypoint>();
        assert_no_gaps::<Contact>();
        assert_no_gaps::<ChunkBinding>();
        assert_no_gaps::<PlanChunk>();
        assert_no_gaps::<Margins>();
        assert_no_gaps::<Feedback>();
        assert_no_gaps::<RestState>();
        assert_no_gaps::<WorldCorrection>();
        assert_no_gaps::<StancePoseData>();
        assert_no_gaps::<PlanRequest>();
        assert_no_gaps::<RequestRecord>();
        assert_no_gaps::<PlanStatus>();
        assert_no_gaps::<JournalRecord>();
        assert_no_gaps::<Description>();
        assert_no_gaps::<SetPoint>();
        assert_no_gaps::<WalkRecord>();
    }

    #[test]
    fn the_wire_offsets_are_fixed() {
        let offset = |fields: &[Field], name: &str| {
            fields.iter().find(|field| field.name == name).unwrap().offset
        };
        let chunk = PlanChunk::FIELDS;
        let expected = [
            ("schema", 0),
            ("session", 8),
            ("target_controller", 16),
            ("sequence", 40),
            ("flags", 48),
            ("crc", 68),
            ("interpolation", 72),
            ("brake_at", 80),
            ("robot", 104),
            ("stream", 200),
            ("contacts", 232),
            ("waypoints", 1512),
            ("goal", 80_360),
        ];
        for (name, at) in expected {
            assert_eq!(offset(chunk, name), at, "{name}");
        }
        let expected = [
            ("schema", 0),
            ("controller_id", 8),
            ("next_sequence", 40),
            ("verdict", 56),
            ("finished", 76),
            ("duplicated", 80),
            ("gaps", 88),
            ("walked", 96),
            ("busy", 120),
            ("crc", 132),
            ("stream", 136),
            ("margins", 168),
            ("rest_state", 232),
            ("corrections", 3984),
        ];
        for (name, at) in expected {
            assert_eq!(offset(Feedback::FIELDS, name), at, "{name}");
        }
        assert_eq!((size_of::<PlanChunk>(), size_of::<Feedback>()), (80_528, 6800));
    }

    #[test]
    fn the_hash_covers_names_types_offsets_and_parts() {
        let field = Field { name: "a", type_name: "u64", offset: 0, size: 8 };
        let base = hash_of(16, &[field], &[1]);
        let others = [
            hash_of(24, &[field], &[1]),
            hash_of(16, &[Field { name: "b", ..field }], &[1]),
            hash_of(16, &[Field { type_name: "f64", ..field }], &[1]),
            hash_of(16, &[Field { offset: 8, ..field }], &[1]),
            hash_of(16, &[field], &[2]),
        ];
        assert!(others.iter().all(|other| *other != base));
        assert_ne!(PlanChunk::HASH, Feedback::HASH);
    }
}
