//! Rigid motions, digests, text files, input errors and the sizes of messages.

pub mod digest;
pub mod input_error;
pub mod limits;
pub mod spatial;
pub mod text_file;
pub(crate) mod xml;
