//! The planner's end of an instance.

use surefoot_planner::channel::plan_publisher::PlanPublisher;

use crate::input::inputs::Inputs;
use crate::report::command_error::CommandError;
use crate::system::instance::enter_instance;

/// Opens the planner's end of an instance and publishes the description of its walks.
///
/// # Errors
/// The instance cannot be entered, or the transport fails.
pub(super) fn open(
    instance: &str,
    session: u64,
    inputs: &Inputs,
) -> Result<PlanPublisher, CommandError> {
    let mut publisher = PlanPublisher::open(&enter_instance(instance)?, session)?;
    publisher.describe(&inputs.description(session))?;
    Ok(publisher)
}
