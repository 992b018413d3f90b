//! iceoryx2 publish-subscribe as its defaults have it, both sides spinning, without anything that
//! makes it lossless.

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use iceoryx2::node::Node;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{Config, FileName, NodeBuilder, SemanticString, SignalHandlingMode, ipc};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::instance::remove_segments;
use surefoot_shared_types::message::{Feedback, PlanChunk};

use crate::commands::bench::ipc::drive;
use crate::commands::bench::ipc::drive::{Far, Measured, Near, feedback};
use crate::report::command_error::CommandError;

/// The default buffer of a reader: with more chunks on their way the oldest vanish.
const WINDOW: u64 = 2;

/// Measures it.
pub(crate) fn measure(rounds: usize) -> Result<Measured, CommandError> {
    let folder = tempfile::Builder::new()
        .prefix("sfbench")
        .permissions(Permissions::from_mode(0o700))
        .tempdir_in("/dev/shm");
    let folder = folder.map_err(failed)?;
    let measured = drive::measure(
        rounds,
        WINDOW,
        || IoxNear::open(folder.path()),
        || IoxFar::open(folder.path()),
    );
    remove_segments(&prefix()).map_err(failed)?;
    measured
}

/// Prefix of the names of its segments.
fn prefix() -> String {
    format!("sfbench-{}-", std::process::id())
}

fn failed(error: impl std::fmt::Debug) -> CommandError {
    ChannelError::transport("measuring iceoryx2", error).into()
}

/// Services with everything as the library's defaults have it, in a folder of their own.
struct Plain {
    chunks: PortFactory<ipc::Service, PlanChunk, ()>,
    feedback: PortFactory<ipc::Service, Feedback, ()>,
    _node: Node<ipc::Service>,
}

impl Plain {
    fn open(folder: &Path) -> Result<Self, CommandError> {
        let mut config = Config::default();
        let root = folder.to_str().unwrap_or_default().as_bytes();
        config.global.set_root_path(&iceoryx2::prelude::Path::new(root).map_err(failed)?);
        config.global.prefix = FileName::new(prefix().as_bytes()).map_err(failed)?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>();
        let node = node.map_err(failed)?;
        let open = |name: &str| name.try_into().map_err(failed);
        let chunks = node
            .service_builder(&open("chunks")?)
            .publish_subscribe::<PlanChunk>()
            .open_or_create()
            .map_err(failed)?;
        let feedback = node
            .service_builder(&open("feedback")?)
            .publish_subscribe::<Feedback>()
            .open_or_create()
            .map_err(failed)?;
        Ok(Self { chunks, feedback, _node: node })
    }
}

struct IoxNear {
    chunks: Publisher<ipc::Service, PlanChunk, ()>,
    feedback: Subscriber<ipc::Service, Feedback, ()>,
    _plain: Plain,
    answered: u64,
}

impl IoxNear {
    fn open(folder: &Path) -> Result<Self, CommandError> {
        let plain = Plain::open(folder)?;
        let chunks = plain.chunks.publisher_builder().create().map_err(failed)?;
        let feedback = plain.feedback.subscriber_builder().create().map_err(failed)?;
        Ok(Self { chunks, feedback, _plain: plain, answered: 0 })
    }
}

impl Near for IoxNear {
    fn send(&mut self, chunk: &PlanChunk, number: u64) -> Result<(), CommandError> {
        // The first chunks vanish until the far end has arrived.
        loop {
            let mut sample = self.chunks.loan_uninit().map_err(failed)?;
            sample.payload_mut().write(*chunk).sequence = number;
            // SAFETY: `write` above initialised the payload.
            if unsafe { sample.assume_init() }.send().map_err(failed)? > 0 {
                return Ok(());
            }
        }
    }

    fn answered(&mut self) -> Result<u64, CommandError> {
        while let Some(sample) = self.feedback.receive().map_err(failed)? {
            self.answered = std::hint::black_box(*sample).next_sequence;
        }
        Ok(self.answered)
    }
}

struct IoxFar {
    chunks: Subscriber<ipc::Service, PlanChunk, ()>,
    feedback: Publisher<ipc::Service, Feedback, ()>,
    _plain: Plain,
}

impl IoxFar {
    fn open(folder: &Path) -> Result<Self, CommandError> {
        let plain = Plain::open(folder)?;
        let feedback = plain.feedback.publisher_builder().create().map_err(failed)?;
        let chunks = plain.chunks.subscriber_builder().create().map_err(failed)?;
        Ok(Self { chunks, feedback, _plain: plain })
    }
}

impl Far for IoxFar {
    fn serve(&mut self) -> Result<(), CommandError> {
        let Some(sample) = self.chunks.receive().map_err(failed)? else { return Ok(()) };
        let chunk = std::hint::black_box(*sample);
        self.feedback.send_copy(feedback(chunk.sequence)).map(drop).map_err(failed)
    }
}
