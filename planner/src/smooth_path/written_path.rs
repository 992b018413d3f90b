//! The points and spans of a smooth path, phase by phase. Final phases do not change any
//! more.

use crate::base::arena::reserve;
use crate::base::capacity::ArenaFull;
use crate::timing::path_point::{Path, PathPoint, PathSpan};

/// The phases written so far. All memory is reserved at first.
#[derive(Debug)]
pub(crate) struct WrittenPath {
    points: Vec<PathPoint>,
    spans: Vec<PathSpan>,
    /// Number of points and of spans before each written phase.
    begins: Vec<[usize; 2]>,
    /// Number of phases that do not change any more, and of their spans.
    finals: [usize; 2],
}

impl WrittenPath {
    /// Reserves memory for paths of `phases_max` phases and `points_max` points.
    pub fn new(phases_max: usize, points_max: usize) -> Self {
        Self {
            points: reserve(points_max),
            spans: reserve(points_max / 2),
            begins: reserve(phases_max),
            finals: [0; 2],
        }
    }

    /// Begins a path.
    pub fn begin(&mut self) {
        self.points.clear();
        self.spans.clear();
        self.begins.clear();
        self.finals = [0; 2];
    }

    /// The final part of the path.
    pub fn final_part(&self) -> Path<'_> {
        Path { points: &self.points, spans: &self.spans[..self.finals[1]] }
    }

    /// Number of final phases.
    pub fn final_phases(&self) -> usize {
        self.finals[0]
    }

    /// Number of written phases. The last one may be incomplete.
    pub fn phases(&self) -> usize {
        self.begins.len()
    }

    /// The last point.
    pub fn last(&self) -> Option<&PathPoint> {
        self.points.last()
    }

    /// Number of points.
    pub fn points_len(&self) -> usize {
        self.points.len()
    }

    /// The path's parameter at its end.
    pub fn last_parameter(&self) -> f64 {
        self.points.last().map_or(0.0, |last| last.parameter)
    }

    /// Begins the next phase.
    pub fn begin_phase(&mut self) {
        self.begins.push([self.points.len(), self.spans.len()]);
    }

    /// Withdraws the phases from `phase` on, none of which is final.
    pub fn withdraw(&mut self, phase: usize) {
        debug_assert!(phase >= self.finals[0]);
        if let Some(&[points, spans]) = self.begins.get(phase) {
            self.points.truncate(points);
            self.spans.truncate(spans);
            self.begins.truncate(phase);
        }
    }

    /// The first phases, which are complete, do not change any more.
    pub fn finalize(&mut self, phases: usize) {
        if phases > self.finals[0] {
            let spans = self.begins.get(phases).map_or(self.spans.len(), |[_, spans]| *spans);
            self.finals = [phases, spans];
        }
    }

    /// Appends a point to the last phase.
    ///
    /// # Errors
    /// The arena of points is full.
    pub fn push_point(&mut self, point: PathPoint) -> Result<(), ArenaFull> {
        push(&mut self.points, point)
    }

    /// Appends a span to the last phase.
    ///
    /// # Errors
    /// The arena of spans is full.
    pub fn push_span(&mut self, span: PathSpan) -> Result<(), ArenaFull> {
        push(&mut self.spans, span)
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.points.capacity() * size_of::<PathPoint>()
            + self.spans.capacity() * size_of::<PathSpan>()
            + self.begins.capacity() * size_of::<[usize; 2]>()
    }
}

/// Appends to an arena.
fn push<T>(arena: &mut Vec<T>, item: T) -> Result<(), ArenaFull> {
    if arena.len() == arena.capacity() {
        return Err(ArenaFull::Waypoints);
    }
    arena.push(item);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timing::path_point::VELOCITY_MAX;
    use surefoot_shared_types::Pose;
    use surefoot_shared_types::message::SupportMode;

    fn write_phase(path: &mut WrittenPath, parameter: f64) {
        path.begin_phase();
        let rates = [0.0; VELOCITY_MAX];
        let root = Pose::IDENTITY;
        let q = [0.0; surefoot_shared_types::base::limits::JOINTS_MAX];
        let point = PathPoint { parameter, world_from_root: root, q, first: rates, second: rates };
        path.push_point(point).unwrap();
        let span = PathSpan {
            first: path.points_len() - 1,
            last: path.points_len() - 1,
            starts_at_rest: false,
            support: SupportMode::Double,
            contacts: heapless::Vec::new(),
            grounds: Default::default(),
        };
        path.push_span(span).unwrap();
    }

    #[test]
    fn final_phases_stay_and_the_others_can_be_withdrawn() {
        let mut path = WrittenPath::new(8, 8);
        path.begin();
        (0..4).for_each(|phase| write_phase(&mut path, f64::from(phase)));
        assert_eq!(path.final_part().spans.len(), 0);
        path.finalize(2);
        assert_eq!((path.final_part().spans.len(), path.final_phases()), (2, 2));
        path.withdraw(3);
        assert_eq!((path.phases(), path.points_len(), path.last_parameter()), (3, 3, 2.0));
        path.finalize(1);
        assert_eq!(path.final_phases(), 2, "a final phase stays so");
        path.finalize(3);
        assert_eq!(path.final_part().spans.len(), 3);
    }

    #[test]
    fn a_full_arena_is_an_error() {
        let mut path = WrittenPath::new(2, 2);
        write_phase(&mut path, 0.0);
        let second = *path.last().unwrap();
        path.push_point(second).unwrap();
        assert_eq!(path.push_point(second), Err(ArenaFull::Waypoints));
    }
}
