//! The search of a method other than the full planner.

use surefoot_shared_types::config::PlannerConfig;

use crate::base::capacity::ArenaFull;
use crate::methods::lattice::Lattice;
use crate::methods::lattice_steps::StepTest;
use crate::methods::method::{Method, MethodParameters};
use crate::methods::multi_modal_prm::{MultiModalPrm, are_ends_double};
use crate::methods::random_mmp::RandomMmp;
use crate::methods::reachability::Reachability;
use crate::methods::w_rpg::WRpg;
use crate::methods::workbench::{MethodEvent, Workbench};
use crate::motion::ids::TransitionId;

/// The search of a method, allocated once.
#[derive(Debug)]
pub(crate) enum MethodSearch {
    /// w-RPG and MMPRM.
    Sampling(Box<WRpg>),
    /// Random-MMP.
    Tree(Box<RandomMmp>),
    /// A* over a set of steps.
    Lattice(Box<Lattice>),
    /// Reachability-guided.
    Guided(Box<Reachability>),
}

impl MethodSearch {
    /// Reserves the memory of a method; `None` for the full planner.
    pub fn new(
        method: Method,
        parameters: MethodParameters,
        config: &PlannerConfig,
    ) -> Option<Self> {
        let footholds_max = config.footholds_max as usize;
        let prm = || {
            MultiModalPrm::new(
                footholds_max,
                config.transitions_max as usize,
                config.configurations_max as usize,
            )
        };
        let sampling = |parameters| Some(Self::Sampling(Box::new(WRpg::new(parameters, prm()))));
        let lattice =
            |test| Some(Self::Lattice(Box::new(Lattice::new(test, footholds_max, prm()))));
        match method {
            Method::Rpg | Method::RpgDiscs => None,
            Method::WRpg => sampling(parameters),
            Method::Mmprm => {
                sampling(MethodParameters { disc_radius_share: f64::INFINITY, ..parameters })
            }
            Method::RandomMmp => {
                let nodes_max = config.configurations_max as usize / 2;
                Some(Self::Tree(Box::new(RandomMmp::new(nodes_max, prm()))))
            }
            Method::Astar => lattice(StepTest::Postures),
            Method::AstarAdaptive => lattice(StepTest::AdaptedPostures),
            Method::BoundingBox => lattice(StepTest::ExpandedGeometry),
            Method::Reachability => {
                Some(Self::Guided(Box::new(Reachability::new(parameters.route_samples, prm()))))
            }
        }
    }

    /// Advances by at most `budget` units of work, and by at least one.
    ///
    /// # Errors
    /// An arena is full.
    pub fn step(
        &mut self,
        bench: &mut Workbench<'_>,
        budget: u64,
    ) -> Result<MethodEvent, ArenaFull> {
        if !are_ends_double(bench.roadmap) {
            return Ok(MethodEvent::NotExpressible("it begins and ends on both feet"));
        }
        match self {
            Self::Sampling(w_rpg) => w_rpg.step(bench, budget),
            Self::Tree(tree) => tree.step(bench, budget),
            Self::Lattice(lattice) => lattice.step(bench, budget),
            Self::Guided(guided) => guided.step(bench, budget),
        }
    }

    /// The sequence, once found.
    pub fn sequence(&self) -> &[TransitionId] {
        match self {
            Self::Sampling(w_rpg) => w_rpg.prm.sequence(),
            Self::Tree(tree) => tree.prm.sequence(),
            Self::Lattice(lattice) => lattice.prm.sequence(),
            Self::Guided(guided) => guided.prm.sequence(),
        }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Sampling(w_rpg) => w_rpg.bytes(),
            Self::Tree(tree) => tree.bytes(),
            Self::Lattice(lattice) => lattice.bytes(),
            Self::Guided(guided) => guided.bytes(),
        }
    }
}
