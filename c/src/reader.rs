//! A reader of an instance behind a pointer.

use std::ffi::{CStr, CString, c_char, c_int};
use std::time::Instant;

use surefoot_shared_types::instance::observer::Observer;
use surefoot_shared_types::instance::{ChannelError, Instance};
use surefoot_shared_types::message::{Description, Feedback, PlanChunk, SetPoint, SimulationState};

/// A reader of all messages of an instance.
pub struct Reader {
    observer: Observer,
    /// The last error.
    error: CString,
}

/// Attaches to an instance, which may appear within `wait_seconds`.
fn open(name: &str, wait_seconds: f64) -> Result<Observer, ChannelError> {
    let start = now();
    let mut may_wait = || start.elapsed().as_secs_f64() < wait_seconds;
    Observer::open(&Instance::attach_once_made(name, &mut may_wait)?)
}

/// Copies a text with its zero byte into `size` bytes at `out`, and cuts it if need be.
///
/// # Safety
/// `out` is null or has `size` bytes.
unsafe fn write_text(text: &str, out: *mut c_char, size: usize) {
    if out.is_null() || size == 0 {
        return;
    }
    let used = text.len().min(size - 1);
    // SAFETY: both ranges have `used` bytes, and one more follows at `out`.
    unsafe {
        std::ptr::copy_nonoverlapping(text.as_ptr().cast::<c_char>(), out, used);
        *out.add(used) = 0;
    }
}

/// Attaches to the instance `name` and waits up to `wait_seconds` for it to appear. Null on an
/// error, whose text is written to the `error_size` bytes at `error`.
///
/// # Safety
/// `name` is a text that ends with a zero byte; `error` is null or has `error_size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn surefoot_reader_open(
    name: *const c_char,
    wait_seconds: f64,
    error: *mut c_char,
    error_size: usize,
) -> *mut Reader {
    if name.is_null() {
        // SAFETY: as the caller promises.
        unsafe { write_text("the instance's name is null", error, error_size) };
        return std::ptr::null_mut();
    }
    // SAFETY: as the caller promises.
    let name = unsafe { CStr::from_ptr(name) }.to_string_lossy();
    match open(&name, wait_seconds) {
        Ok(observer) => Box::into_raw(Box::new(Reader { observer, error: CString::default() })),
        Err(failure) => {
            // SAFETY: as the caller promises.
            unsafe { write_text(&failure.to_string(), error, error_size) };
            std::ptr::null_mut()
        }
    }
}

/// Lets go of an instance. Null is allowed.
///
/// # Safety
/// `reader` is null, or from [`surefoot_reader_open`] and not closed yet.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn surefoot_reader_close(reader: *mut Reader) {
    if !reader.is_null() {
        // SAFETY: as the caller promises, it was made by `Box::into_raw`.
        drop(unsafe { Box::from_raw(reader) });
    }
}

/// Writes a message to `out`: 1 if one has come, 0 if none has, -1 on an error.
///
/// # Safety
/// `reader` is an open reader and `out` has space for the message.
unsafe fn next<M>(
    reader: *mut Reader,
    out: *mut M,
    receive: impl Fn(&Observer) -> Result<Option<M>, ChannelError>,
) -> c_int {
    // SAFETY: as the caller promises.
    let reader = unsafe { &mut *reader };
    match receive(&reader.observer) {
        Ok(Some(message)) => {
            // SAFETY: as the caller promises.
            unsafe { out.write(message) };
            1
        }
        Ok(None) => 0,
        Err(error) => {
            reader.error = CString::new(error.to_string()).unwrap_or_default();
            -1
        }
    }
}

/// The next chunk of a plan: 1 if one has come, 0 if none has, -1 on an error.
///
/// # Safety
/// `reader` is an open reader, `out` has space for a chunk.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn surefoot_reader_next_chunk(
    reader: *mut Reader,
    out: *mut PlanChunk,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { next(reader, out, Observer::chunk) }
}

/// The controller's next feedback: 1 if one has come, 0 if none has, -1 on an error.
///
/// # Safety
/// `reader` is an open reader, `out` has space for a feedback.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn surefoot_reader_next_feedback(
    reader: *mut Reader,
    out: *mut Feedback,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { next(reader, out, Observer::feedback) }
}

/// The simulated robot's next state: 1 if one has come, 0 if none has, -1 on an error.
///
/// # Safety
/// `reader` is an open reader, `out` has space for a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn surefoot_reader_next_state(
    reader: *mut Reader,
    out: *mut SimulationState,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { next(reader, out, Observer::state) }
}

/// A sampler's next set-point: 1 if one has come, 0 if none has, -1 on an error.
///
/// # Safety
/// `reader` is an open reader, `out` has space for a set-point.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn surefoot_reader_next_set_point(
    reader: *mut Reader,
    out: *mut SetPoint,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { next(reader, out, Observer::set_point) }
}

/// The description of the walk, once from each of planner and controller: 1 if one has come, 0 if
/// none has, -1 on an error.
///
/// # Safety
/// `reader` is an open reader, `out` has space for a description.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn surefoot_reader_next_description(
    reader: *mut Reader,
    out: *mut Description,
) -> c_int {
    // SAFETY: as the caller promises.
    unsafe { next(reader, out, Observer::description) }
}

/// The number of chunks that were sent and not received. Read feedback, then chunks until none is
/// left, so that the last ones count.
///
/// # Safety
/// `reader` is an open reader.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn surefoot_reader_missed_chunks(reader: *const Reader) -> u64 {
    // SAFETY: as the caller promises.
    unsafe { &*reader }.observer.missed_chunks()
}

/// 1 while a planner or a controller is attached, else 0.
///
/// # Safety
/// `reader` is an open reader.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn surefoot_reader_is_attended(reader: *const Reader) -> c_int {
    // SAFETY: as the caller promises.
    c_int::from(unsafe { &*reader }.observer.publisher_count() > 0)
}

/// The text of the last error; empty if there was none. It is valid until the next call.
///
/// # Safety
/// `reader` is an open reader.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn surefoot_reader_error(reader: *const Reader) -> *const c_char {
    // SAFETY: as the caller promises.
    unsafe { &*reader }.error.as_ptr()
}

#[allow(clippy::disallowed_methods, reason = "a reader may wait; the search may not")]
fn now() -> Instant {
    Instant::now()
}
