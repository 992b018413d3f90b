//! Whole-body walk planning for legged robots on arbitrary geometry.
//!
//! A walk is found in two stages, as in Grey's Randomized Possibility Graph. Stage P explores where
//! the robot's root could go, with conditions that are cheap to test, and returns a guide route.
//! Stage M places feet along the route and finds configurations and motions of the whole body
//! between them: balanced, free of collision, within the limits of joints and torques. The search
//! is deterministic: the same robot, world, stances and seed give the same plan, whatever the
//! number of threads. It is bounded: it ends at a named budget of work, and allocates before it
//! begins, not while it runs. A plan is a list of chunks with at most 32 waypoints each. Every
//! waypoint is statically stable, and within each chunk the robot can brake and stand. A [`Checker`]
//! with code of its own checks each chunk, and a [`Publisher`] delivers them to a controller over
//! shared memory.
//!
//! ```text
//! Robot + Parameters ─► Prepared ─┐
//!                                 ├─► Planner ─► Plan ─► footholds, samples, chunks ─► Publisher
//! World, Stance, Goal ────────────┘                                            └─► Checker
//! ```
//!
//! # A walk in twenty lines
//! ```no_run
#![doc = include_str!("../examples/twenty_lines.rs")]
//! ```
//!
//! # Where to go
//! - A robot: [`Robot::load`]; a world: [`World::load`] or [`World::builder`].
//! - A plan as a file: [`Plan::save`] and [`Plan::load`].
//! - A search inside a control loop: [`Planner::begin`] and [`Planner::step`].
//! - The rest of a walk after something happened: [`Planner::replan`].
//! - Plans by other programs: [`Checker::check`] and [`Checker::check_file`].
//! - Other processes: [`Publisher`] and [`Subscriber`].
//!
//! `examples/` has a program for each. `docs/ARCHITECTURE.md` is the map of the code, and
//! `docs/EQUATIONS.md` leads from the thesis to it.

mod api;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod commands;
#[cfg(feature = "export")]
#[doc(hidden)]
pub mod export;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod input;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod picture;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod report;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod supervisor;
#[doc(hidden)]
pub mod system;

pub use api::{
    AnswerError, BuildError, CheckError, Checker, CheckerConfig, Contacts, Delivery,
    DeliveryOutcome, Digest, Event, ExecutionConfig, Foot, FootLoad, Foothold, Goal, HeightMap,
    Improvement, Load, LoadError, Margins, Message, MotionKind, Parameters, Plan, PlanChunk,
    PlanError, Planner, PlannerBuilder, PlannerConfig, Pose, PrepareError, Prepared, Publisher,
    ReplanError, Robot, SaveError, SearchStats, SearchTrace, Shape, Stance, StartError, State,
    Step, Subscriber, TransportError, World, WorldBuilder, WorldCorrection, WorldError,
};
