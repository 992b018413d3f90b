//! The search: stages that lead from a start and a goal to the chunks of a plan.
//!
//! `planner` names the stages in order, `stage_table` says which stage follows which. This is
//! the only folder that imports both stage P (`possibility`) and stage M (`motion`).
//!
//! A file `*_stage` is a stage, `segment_cycle` holds two. The files beside it are its parts:
//!
//! | what | files |
//! | --- | --- |
//! | the frame of all stages | `planner_builder`, `planner`, `stage`, `stage_table`, `search` |
//! | how a search ends | `outcome`, `outcome_text`, `search_trace` |
//! | start and goal | `endpoint_stage`, `endpoints`, `goal_postures`, `retrace` |
//! | direct steps to a near goal | `direct_stage`, `direct_steps` |
//! | guide routes | `route_stage`, `relaxation_stage`, `live_routes`, `uniform_rounds` |
//! | footholds along a route | `foothold_stage`, `foothold_order`, `foothold_sampling` |
//! | transitions between footholds | `connection_stage`, `primitive_stage` |
//! | segments of a route | `segmentation_stage`, `segmentation`, `segment_searches` |
//! | stage M along a segment | `segment_stage`, `sequence_stage`, `transition_estimates`, `segment_cycle`, `step_removal` |
//! | failures | `recovery_stage`, `recovery_policy`, `bottlenecks`, `resorts` |
//! | the motion of a complete plan | `shortcut_stage`, `smooth_path_stage` |
//! | its chunks | `chunk_stage`, `timed_chunks` |
//! | faster walks | `improvement_stage`, `improvement`, `improvement_walk`, `improvement_window`, `trial_motion` |
//! | other methods | `method_stage` |

mod bottlenecks;
mod chunk_stage;
mod connection_stage;
mod direct_stage;
mod direct_steps;
mod endpoint_stage;
mod endpoints;
mod foothold_order;
mod foothold_sampling;
mod foothold_stage;
mod goal_postures;
mod improvement;
mod improvement_stage;
mod improvement_walk;
mod improvement_window;
mod live_routes;
mod method_stage;
pub mod outcome;
mod outcome_text;
mod planner;
mod planner_builder;
mod primitive_stage;
mod recovery_policy;
mod recovery_stage;
mod relaxation_stage;
pub mod resorts;
mod retrace;
mod route_stage;
mod search;
mod search_trace;
mod segment_cycle;
mod segment_searches;
mod segment_stage;
mod segmentation;
mod segmentation_stage;
mod sequence_stage;
mod shortcut_stage;
mod smooth_path_stage;
mod stage;
mod stage_table;
mod step_removal;
mod timed_chunks;
mod transition_estimates;
mod trial_motion;
mod uniform_rounds;

pub use bottlenecks::Bottleneck;
pub use endpoints::{Endpoint, foothold_at, stand_on};
pub use foothold_sampling::{FootholdSampler, PERTURBATIONS_MAX};
pub use improvement::Improvement;
pub use outcome::{Outcome, Status};
pub use planner::Planner;
pub use planner_builder::{PlannerBuilder, PlannerError};
pub use retrace::Retrace;
pub use search::SearchStats;
pub use search_trace::SearchTrace;
pub use stage::{Event, Stage, WorkCategory};
pub use stage_table::{TRANSITIONS, Transition};
