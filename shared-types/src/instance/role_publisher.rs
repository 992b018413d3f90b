//! The publishers of planner and controller, named in a file for each.
//!
//! Any process of the user may publish chunks and feedback. A reader knows from which publisher a
//! message comes, whatever it contains: iceoryx2 makes one connection for each. That distinguishes
//! the messages of the process that holds a role from those of all others.

use std::fs::File;
use std::os::unix::fs::FileExt;

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{CallbackProgression, PortFactory, ipc};
use iceoryx2::sample::Sample;

use crate::instance::error::{ChannelError, InstanceError, io_error};
use crate::instance::instance::Instance;
use crate::instance::services::Service;
use crate::message::Layout;

/// A role that one process of an instance has at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PublisherRole {
    /// It publishes the chunks.
    Planner,
    /// It publishes the feedback.
    Controller,
}

impl PublisherRole {
    /// The name of the file in the instance's folder that contains the publisher's id. The
    /// planner's is its lock, too; the controller's lock is the robot's journal.
    pub const fn file(self) -> &'static str {
        match self {
            Self::Planner => "planner",
            Self::Controller => "controller",
        }
    }
}

/// Names the publisher of a role, whose lock the caller holds. Call it before the first message.
///
/// # Errors
/// The file is no regular file of this user, or the file system fails.
pub fn name_publisher(
    instance: &Instance,
    role: PublisherRole,
    id: u128,
) -> Result<(), InstanceError> {
    let written = instance.open_file(role.file())?.write_all_at(&id.to_le_bytes(), 0);
    written.map_err(|error| io_error(&instance.root().join(role.file()), error))
}

/// Result of [`RolePublisher::receive`].
#[derive(Debug)]
pub enum Received<M: Layout> {
    /// No message has arrived.
    Nothing,
    /// A message of a publisher other than the role's, which is dropped.
    OfAnother,
    /// A message of the role's publisher.
    Message(Sample<ipc::Service, M, ()>),
}

/// Distinguishes the messages of the process that has a role from those of other publishers.
#[derive(Debug)]
pub struct RolePublisher {
    file: File,
    /// The publisher that was named last.
    id: Option<u128>,
}

impl RolePublisher {
    /// The publisher that processes with this role name, from now on.
    ///
    /// # Errors
    /// The file is no regular file of this user, or the file system fails.
    pub fn open(instance: &Instance, role: PublisherRole) -> Result<Self, InstanceError> {
        Ok(Self { file: instance.open_file(role.file())?, id: None })
    }

    /// Receives one message; one of another publisher is dropped, whatever it contains. `receiving`
    /// names the step in an error.
    ///
    /// # Errors
    /// The transport fails.
    pub fn receive<M: Layout>(
        &mut self,
        subscriber: &Subscriber<ipc::Service, M, ()>,
        receiving: &'static str,
    ) -> Result<Received<M>, ChannelError> {
        let received =
            subscriber.receive().map_err(|error| ChannelError::transport(receiving, error))?;
        Ok(match received {
            None => Received::Nothing,
            Some(sample) if self.is(sample.origin().value()) => Received::Message(sample),
            Some(_) => Received::OfAnother,
        })
    }

    /// Whether a message of the publisher `id` counts. The publisher named last remains the one
    /// until a message of another arrives that is named then. As long as none ever was, all count.
    pub(crate) fn is(&mut self, id: u128) -> bool {
        if self.id == Some(id) {
            return true;
        }
        self.id = self.named();
        self.id.is_none_or(|named| named == id)
    }

    /// Publishers of the service whose messages count. That of a killed process is among them until
    /// a process cleans up.
    pub fn count<M: Layout>(&self, service: &Service<M>) -> usize {
        let Some(named) = self.named() else {
            return service.dynamic_config().number_of_publishers();
        };
        let mut count = 0;
        service.dynamic_config().list_publishers(|publisher| {
            count += usize::from(publisher.publisher_id.value() == named);
            CallbackProgression::Continue
        });
        count
    }

    fn named(&self) -> Option<u128> {
        let mut id = [0; size_of::<u128>()];
        self.file.read_exact_at(&mut id, 0).ok()?;
        Some(u128::from_le_bytes(id))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instance::participant::Participant;

    #[test]
    fn the_publisher_named_last_is_the_one() {
        let base = tempfile::tempdir_in("/dev/shm").unwrap();
        let instance = Instance::create_in(&base.path().join("base"), "publishers").unwrap();
        for role in [PublisherRole::Planner, PublisherRole::Controller] {
            let mut publisher = RolePublisher::open(&instance, role).unwrap();
            assert!([1, 2].into_iter().all(|id| publisher.is(id)), "none was named");
            name_publisher(&instance, role, 1).unwrap();
            assert_eq!([1, 2, 1].map(|id| publisher.is(id)), [true, false, true]);
            name_publisher(&instance, role, 2).unwrap();
            assert_eq!([2, 1].map(|id| publisher.is(id)), [true, false], "{role:?}");
        }
    }

    #[test]
    fn other_publishers_do_not_stand_for_the_one_that_left() {
        let base = tempfile::tempdir_in("/dev/shm").unwrap();
        let instance = Instance::create_in(&base.path().join("base"), "publishers").unwrap();
        let participant = Participant::open(&instance).unwrap();
        let service = &participant.chunks;
        let planner = RolePublisher::open(&instance, PublisherRole::Planner).unwrap();
        let [own, other] = [(); 2].map(|()| service.publisher_builder().create().unwrap());
        assert_eq!(planner.count(service), 2, "none was named");
        name_publisher(&instance, PublisherRole::Planner, own.id().value()).unwrap();
        assert_eq!(planner.count(service), 1);
        drop(own);
        assert_eq!(planner.count(service), 0);
        drop(other);
    }
}
