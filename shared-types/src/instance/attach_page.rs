#![doc = include_str!("../../../docs/ATTACH.md")]
