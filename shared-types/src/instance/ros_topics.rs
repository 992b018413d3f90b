//! ROS 2 messages as iceoryx2 services, as iceoryx2's ROS 2 gateway expects them: the service
//! `ros2://topics/TOPIC` holds the messages of `/TOPIC` as CDR, its payload is a slice of bytes
//! with the type name of the ROS 2 message, and its user header is [`RosHeader`].

use bytemuck::{Pod, Zeroable};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::{AllocationStrategy, ZeroCopySend, ipc};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::instance::error::ChannelError;
use crate::instance::participant::Participant;
use crate::instance::sender::random_id;
use crate::instance::tuning::{BORROWED_MAX, NODES_MAX, ROS_BUFFER, ROS_READERS_MAX, WRITERS_MAX};

/// The user header of the gateway's services.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("RosHeader")]
pub struct RosHeader {
    /// The id of the message's writer.
    pub gid: [u8; 16],
    /// When the message was sent, ns since 1970.
    pub source_timestamp_ns: i64,
    /// Number of the message of its writer, from 1.
    pub sequence_number: u64,
}

const _: () = assert!(size_of::<RosHeader>() == 32 && align_of::<RosHeader>() == 8);

/// A byte of the CDR of one type of ROS 2 message.
pub trait RosByte: Pod + ZeroCopySend + std::fmt::Debug {}

/// Defines the byte of a message: `ros_byte!(Name = "package/msg/Message")`.
macro_rules! ros_byte {
    ($(#[$about:meta])* $name:ident = $type_name:literal) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, Pod, Zeroable)]
        #[repr(transparent)]
        pub struct $name(pub u8);

        // SAFETY: a byte, without pointers.
        unsafe impl ZeroCopySend for $name {
            unsafe fn type_name() -> &'static str {
                $type_name
            }
        }

        impl RosByte for $name {}
    };
}

ros_byte!(
    /// Of the state of joints.
    JointStateByte = "sensor_msgs/msg/JointState"
);
ros_byte!(
    /// Of poses of frames.
    TfByte = "tf2_msgs/msg/TFMessage"
);
ros_byte!(
    /// Of a trajectory of joints.
    JointTrajectoryByte = "trajectory_msgs/msg/JointTrajectory"
);
ros_byte!(
    /// Of a trajectory of frames.
    RootTrajectoryByte = "trajectory_msgs/msg/MultiDOFJointTrajectory"
);

/// The service of a topic.
pub type RosService<B> = PortFactory<ipc::Service, [B], RosHeader>;

/// Publishes the messages of one topic.
#[derive(Debug)]
pub struct RosPublisher<B: RosByte> {
    publisher: Publisher<ipc::Service, [B], RosHeader>,
    gid: [u8; 16],
    sent: u64,
    _service: RosService<B>,
}

/// Opens the service of `/topic`; creates it if it does not exist. Hold the participant's lock
/// `making` meanwhile.
///
/// # Errors
/// The service has another type, or the transport fails.
pub fn open_ros_service<B: RosByte>(
    participant: &Participant,
    topic: &str,
) -> Result<RosService<B>, ChannelError> {
    let name = format!("ros2://topics/{topic}");
    let action = format!("opening service '{name}'");
    let iox_name =
        name.as_str().try_into().map_err(|error| ChannelError::transport(&action, error))?;
    participant
        .node()
        .service_builder(&iox_name)
        .publish_subscribe::<[B]>()
        .user_header::<RosHeader>()
        .enable_safe_overflow(true)
        .subscriber_max_buffer_size(ROS_BUFFER)
        .history_size(0)
        .subscriber_max_borrowed_samples(BORROWED_MAX)
        .max_subscribers(ROS_READERS_MAX)
        .max_publishers(WRITERS_MAX)
        .max_nodes(NODES_MAX)
        .open_or_create()
        .map_err(|error| ChannelError::transport(&action, error))
}

impl<B: RosByte> RosPublisher<B> {
    /// A publisher of `/topic`, whose messages have at most `bytes_max` bytes.
    ///
    /// # Errors
    /// Shared memory is full, the service has another type, or the transport fails.
    pub fn open(
        participant: &Participant,
        topic: &str,
        bytes_max: usize,
    ) -> Result<Self, ChannelError> {
        let _making = participant.making()?;
        let service = open_ros_service(participant, topic)?;
        let publisher = service
            .publisher_builder()
            .initial_max_slice_len(bytes_max)
            .allocation_strategy(AllocationStrategy::Static)
            .create()
            .map_err(|error| ChannelError::transport("creating a publisher for ROS 2", error))?;
        participant.instance.reserve_segments()?;
        let mut gid = [0; 16];
        gid[..8].copy_from_slice(&random_id().to_le_bytes());
        gid[8..].copy_from_slice(&random_id().to_le_bytes());
        Ok(Self { publisher, gid, sent: 0, _service: service })
    }

    /// Publishes an encoded message; `now_ns` is the time in ns since 1970.
    ///
    /// # Errors
    /// The message is longer than announced, or the transport fails.
    pub fn publish(&mut self, cdr: &[u8], now_ns: i64) -> Result<(), ChannelError> {
        let loaned = self.publisher.loan_slice_uninit(cdr.len());
        let mut sample = loaned
            .map_err(|error| ChannelError::transport("loaning shared memory for ROS 2", error))?;
        self.sent += 1;
        *sample.user_header_mut() =
            RosHeader { gid: self.gid, source_timestamp_ns: now_ns, sequence_number: self.sent };
        let sent = sample.write_from_slice(bytemuck::cast_slice(cdr)).send();
        sent.map(drop).map_err(|error| ChannelError::transport("sending to ROS 2", error))
    }
}
