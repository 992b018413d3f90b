//! The parameters of foot placement: requirements on a support, and the bounds of the search for
//! it.

use glam::DVec2;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::config::planner::{CONTACT_GAP_MAX, CONTACT_TILT_MAX};

use crate::foot_placement::sole_support::SurfacesError;
use crate::foot_placement::tuning::{
    AREA_SHARE_MIN, CHECKED_AREA_FACTOR, CHECKED_DISTANCE_FACTOR, EDGE_DISTANCE_SHARE_MIN,
    FOOT_SHIFT_MAX, GROUND_HEIGHT_MAX, NEAR_TARGETS_MAX, NEIGHBORS_MAX,
};
use crate::geometry::polygon::{area_and_centroid, inner_distance};

/// Requirements on a support, and the bounds of the search for it. All lengths in metres, angles in
/// radians. Values marked "measured" were chosen with `surefoot bench footholds`.
#[derive(Debug, Clone, PartialEq)]
pub struct FootPlacementConfig {
    /// The smallest support area, m2: a quarter of a DRC-Hubo sole.
    pub support_area_min: f64,
    /// Factor of `support_area_min` that is required at first. Where too few placements are found
    /// it relaxes to 1 [Grey 4.1.2].
    pub support_area_inflation: f64,
    /// The smallest distance from the support polygon's centroid to its nearest edge, m
    /// [Grey 4.1.2].
    pub centroid_edge_distance_min: f64,
    /// Largest distance of a supporting surface from the sole's plane, m: the contact gap that the
    /// checker allows.
    pub plane_distance_max: f64,
    /// Largest distance of the highest ground under a sole from the sole's plane, m.
    pub ground_height_max: f64,
    /// The smallest width of a supporting piece of a face under the sole, m. A narrower corner or
    /// edge is no reliable support, and may fall between the samples of the checker's 5 mm grid.
    /// Pieces of meshes are exempt, because other faces may continue them.
    pub contact_width_min: f64,
    /// Largest angle between a supporting surface's normal and the sole's, rad: the contact tilt
    /// that the checker allows.
    pub normal_tilt_max: f64,
    /// Height of the centre of mass over the sole, m: a robot whose foot tilts moves it by as much
    /// times the tilt.
    pub centre_height: f64,
    /// Distance by which a foot may land beside its place, m: it finds an inclined face lower.
    pub foot_shift: f64,
    /// Whether the support is only what such a foot holds, as a checker finds it that samples the
    /// ground: away from the edges of the ground and from the ends of a curved surface's line.
    pub is_secured: bool,
    /// Largest angle between the normals of features that belong to one plane, rad.
    pub plane_tilt_max: f64,
    /// Angle by which a supporting surface stays inside the friction cone, rad.
    pub friction_margin: f64,
    /// Thickness of the plate above the sole that must be free, m: the thin rectangle of
    /// [Grey 4.2.2].
    pub plate_height: f64,
    /// Algorithm 1's targets per query, `N_SampleAttempts` [Grey 4.2.2, figure 4.10].
    pub sample_attempts_max: u32,
    /// Number of these targets, the first ones, that lie at the ideal and half a foot around it
    /// [Grey 4.2.2]; at most five.
    pub sample_attempts_near_ideal: u32,
    /// Algorithm 1's triplets per target, `N_PlaneAttempts` [Grey 4.2.2, figure 4.10].
    pub plane_attempts_max: u32,
    /// Algorithm 1's placements and swaps per triplet, `N_MaxIterations` [Grey 4.2.2, figure 4.10].
    pub iterations_max: u32,
    /// Number of these placements, the first ones, that are near the triplet's centroid and the
    /// ideal heading [Grey 4.2.2].
    pub iterations_near_ideal: u32,
    /// The nearest intersection points a triplet is drawn from, `N_neighbors` [Grey 4.2.2].
    pub neighbors: usize,
    /// Distance between intersection points along an edge or a line, m; measured.
    pub point_spacing: f64,
    /// Most surface elements examined by one query of the support.
    pub support_elements_max: usize,
    /// Most contact points kept by one query of the support.
    pub contact_points_max: usize,
    /// Most features gathered by one query.
    pub features_max: usize,
    /// Most planes with candidates of one query.
    pub planes_max: usize,
    /// Most geometric candidates of one query.
    pub candidates_max: usize,
    /// Most intersection points of one query.
    pub intersection_points_max: usize,
    /// Most points of the ground under a sole. Of a sole that is set down further points are left
    /// out, and the exact support rejects a sole that they obstruct; a support with more points is
    /// rejected.
    pub ground_points_max: usize,
}

/// The least support of a sole: little more than the checker demands.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LeastSupport {
    /// Its area, m2.
    pub area: f64,
    /// Distance of its centroid from its edge, m.
    pub centroid_edge_distance: f64,
}

/// What a sole needs of the ground.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SoleNeeds {
    /// Greatest distance between two points of a sole, m.
    pub length: f64,
    /// The least support that a search accepts.
    pub least: LeastSupport,
}

impl LeastSupport {
    /// The least support for a checker, over whose margin of the centre of mass the planner's is
    /// larger by `reserve` (m).
    pub fn of(checker: &CheckerConfig, reserve: f64) -> Self {
        Self {
            area: CHECKED_AREA_FACTOR * checker.support_area_min,
            centroid_edge_distance: CHECKED_DISTANCE_FACTOR * (checker.com_margin + reserve),
        }
    }
}

impl Default for FootPlacementConfig {
    fn default() -> Self {
        let degree = std::f64::consts::PI / 180.0;
        Self {
            support_area_min: 0.008,
            support_area_inflation: 2.0,
            centroid_edge_distance_min: 0.02,
            plane_distance_max: CONTACT_GAP_MAX,
            ground_height_max: GROUND_HEIGHT_MAX,
            contact_width_min: 0.011,
            normal_tilt_max: CONTACT_TILT_MAX,
            centre_height: 0.9,
            foot_shift: 2.5e-3,
            is_secured: false,
            plane_tilt_max: degree,
            friction_margin: degree,
            plate_height: 0.02,
            sample_attempts_max: 40,
            sample_attempts_near_ideal: 5,
            plane_attempts_max: 10,
            iterations_max: 20,
            iterations_near_ideal: 4,
            neighbors: 10,
            point_spacing: 0.05,
            support_elements_max: 16_384,
            contact_points_max: 1_024,
            features_max: 192,
            planes_max: 32,
            candidates_max: 1_024,
            intersection_points_max: 1_024,
            ground_points_max: 4_096,
        }
    }
}

impl FootPlacementConfig {
    /// Algorithm 1 as printed: without near targets and placements, and with one bound of the area
    /// [Grey 4.2.2].
    pub fn as_printed() -> Self {
        Self {
            support_area_inflation: 1.0,
            sample_attempts_near_ideal: 0,
            iterations_near_ideal: 0,
            ..Self::default()
        }
    }

    /// The parameters for a robot's soles (m, each in its sole frame). `required` is the support
    /// area that the scenario demands, `checked` are the limits of its checker, over whose margin
    /// of the centre of mass the planner's is larger by `reserve` (m).
    pub(crate) fn for_soles(
        soles: &[Vec<DVec2>],
        required: f64,
        checked: &CheckerConfig,
        reserve: f64,
    ) -> Self {
        let standard = Self::default();
        let (mut area_min, mut edge_distance_min) = (required, standard.centroid_edge_distance_min);
        for sole in soles {
            let (area, centroid) = area_and_centroid(sole);
            area_min = area_min.min(AREA_SHARE_MIN * area);
            edge_distance_min =
                edge_distance_min.min(EDGE_DISTANCE_SHARE_MIN * inner_distance(sole, centroid));
        }
        let corners = soles.iter().flatten();
        let reach = corners.map(|corner| corner.length()).fold(0.0, f64::max);
        let least = LeastSupport::of(checked, reserve);
        Self {
            support_area_min: area_min.max(required.min(least.area)),
            centroid_edge_distance_min: edge_distance_min.max(least.centroid_edge_distance),
            foot_shift: (checked.foot_position_max + checked.foot_rotation_max * reach)
                .min(FOOT_SHIFT_MAX),
            is_secured: true,
            ..standard
        }
    }

    /// Lowers what a support needs.
    pub(crate) fn relax(&mut self, least: LeastSupport) {
        self.support_area_min = self.support_area_min.min(least.area);
        self.centroid_edge_distance_min =
            self.centroid_edge_distance_min.min(least.centroid_edge_distance);
    }

    /// Checks every value against its range.
    ///
    /// # Errors
    /// The first field out of its range.
    pub(crate) fn validate(&self) -> Result<(), SurfacesError> {
        let reals = [
            ("support_area_min", self.support_area_min, 1e-6, 1.0),
            ("support_area_inflation", self.support_area_inflation, 1.0, 10.0),
            ("centroid_edge_distance_min", self.centroid_edge_distance_min, 0.0, 1.0),
            ("plane_distance_max", self.plane_distance_max, 1e-6, 0.01),
            ("ground_height_max", self.ground_height_max, 1e-6, 0.01),
            ("contact_width_min", self.contact_width_min, 0.0, 0.05),
            ("normal_tilt_max", self.normal_tilt_max, 1e-6, 0.1),
            ("centre_height", self.centre_height, 0.0, 10.0),
            ("foot_shift", self.foot_shift, 0.0, FOOT_SHIFT_MAX),
            ("plane_tilt_max", self.plane_tilt_max, 1e-6, 0.1),
            ("friction_margin", self.friction_margin, 0.0, 0.5),
            ("plate_height", self.plate_height, 2.0 * self.plane_distance_max, 0.2),
            ("point_spacing", self.point_spacing, 1e-3, 1.0),
        ];
        let counts = [
            ("sample_attempts_max", self.sample_attempts_max as usize, 0, 1_000_000),
            (
                "sample_attempts_near_ideal",
                self.sample_attempts_near_ideal as usize,
                0,
                NEAR_TARGETS_MAX,
            ),
            ("plane_attempts_max", self.plane_attempts_max as usize, 1, 1_000_000),
            ("iterations_max", self.iterations_max as usize, 1, 1_000_000),
            ("iterations_near_ideal", self.iterations_near_ideal as usize, 0, 1_000_000),
            ("neighbors", self.neighbors, 3, NEIGHBORS_MAX),
            ("support_elements_max", self.support_elements_max, 1, 1 << 24),
            ("contact_points_max", self.contact_points_max, 128, 1 << 20),
            ("features_max", self.features_max, 1, 1 << 20),
            ("planes_max", self.planes_max, 1, 1 << 16),
            ("candidates_max", self.candidates_max, 1, 1 << 20),
            ("intersection_points_max", self.intersection_points_max, 3, 1 << 20),
            ("ground_points_max", self.ground_points_max, 3, 1 << 20),
        ];
        for (field, value, lower, upper) in reals {
            if !(lower..=upper).contains(&value) {
                return Err(SurfacesError::Config { field, value, lower, upper });
            }
        }
        for (field, value, lower, upper) in counts {
            if !(lower..=upper).contains(&value) {
                return Err(SurfacesError::Config {
                    field,
                    value: value as f64,
                    lower: lower as f64,
                    upper: upper as f64,
                });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The support area (m2) and the distance to the edge (m) that a sole needs, where the checker
    /// demands the area `checked` (m2).
    fn needs(length: f64, width: f64, checked: f64) -> (f64, f64) {
        let checked =
            CheckerConfig { support_area_min: checked, com_margin: 1e-3, ..Default::default() };
        let [x, y] = [0.5 * length, 0.5 * width];
        let sole = vec![DVec2::new(-x, -y), DVec2::new(x, -y), DVec2::new(x, y), DVec2::new(-x, y)];
        let config = FootPlacementConfig::for_soles(&[sole], 0.008, &checked, 2e-3);
        (config.support_area_min, config.centroid_edge_distance_min)
    }

    #[test]
    fn a_small_sole_needs_a_share_of_its_area_and_more_than_the_checker_demands() {
        assert_eq!(needs(0.22, 0.14, 5e-4), (0.008, 0.02));
        let (area, edge_distance) = needs(0.2, 0.04, 5e-4);
        assert!(
            (area - 0.26 * 0.008).abs() < 1e-12 && (edge_distance - 0.29 * 0.02).abs() < 1e-12,
            "{area} {edge_distance}"
        );
        assert_eq!(needs(0.05, 0.04, 5e-4).0, 6e-4);
        let sole = [(-0.1, -0.02), (0.1, -0.02), (0.1, 0.02), (-0.1, 0.02)].map(DVec2::from);
        let config = FootPlacementConfig::for_soles(
            &[sole.to_vec()],
            0.008,
            &CheckerConfig::default(),
            3e-3,
        );
        assert!((config.centroid_edge_distance_min - 0.01).abs() < 1e-12, "{config:?}");
        assert_eq!(needs(0.2, 0.04, 0.0070).0, 0.008);
    }
}
