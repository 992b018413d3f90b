//! Rigid motions, digests, input and output files, input errors, the process's user and the sizes
//! of messages.

pub mod closest;
pub mod digest;
pub(crate) mod exactly;
pub(crate) mod file_kind;
pub mod input_error;
pub mod limits;
pub mod spatial;
pub(crate) mod temporary_file;
pub mod text_file;
pub mod user;
pub mod whole_file;
pub(crate) mod xml;
