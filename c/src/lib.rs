//! Reads the messages of a running walk from C and C++. `include/surefoot.h` declares the
//! functions, `tools/mirrors/surefoot_messages.h` the messages.

mod reader;

pub use reader::{
    Reader, surefoot_reader_close, surefoot_reader_error, surefoot_reader_is_attended,
    surefoot_reader_missed_chunks, surefoot_reader_next_chunk, surefoot_reader_next_description,
    surefoot_reader_next_feedback, surefoot_reader_next_set_point, surefoot_reader_next_state,
    surefoot_reader_open,
};
