//! One ping in a scene: what is in sight within the cone, and the nearest echo that is strong enough.

use geometry::{Cone, ConeScene, ConeView, Piece, Ray, Sighting};

use super::{fate::Fate, model::SonarModel};
use crate::material::Material;

/// A mirrored ray starts this far off the surface (m), or it would hit that surface again.
const OFF_THE_MIRROR_M: f64 = 1e-6;

/// All that decides what one ping hears.
pub(super) struct Listening<'a, S> {
    pub(super) model: &'a SonarModel,
    pub(super) cone: Cone,
    pub(super) scene: &'a S,
    pub(super) materials: &'a [Material],
    pub(super) fate: &'a Fate,
}

/// The nearest echo so far, and the truth.
pub(super) struct Heard {
    pub(super) nearest_m: f64,
    pub(super) is_ghost: bool,
    pub(super) truth_m: f64,
}

impl Heard {
    fn offer(&mut self, distance_m: f64, is_ghost: bool) {
        if distance_m < self.nearest_m {
            self.nearest_m = distance_m;
            self.is_ghost = is_ghost;
        }
    }
}

impl<S: ConeScene> Listening<'_, S> {
    /// The nearest echo that is strong enough, of all that is in sight within the cone.
    pub(super) fn hear(&self) -> Heard {
        let truth_m = self.model.range_max_m;
        let mut heard = Heard { nearest_m: f64::INFINITY, is_ghost: false, truth_m };
        let Some(nearest) = self.cone.nearest(self.scene) else { return heard };
        heard.truth_m = nearest.distance_m;
        if self.hears(&nearest) {
            heard.offer(nearest.distance_m, false);
            return heard;
        }
        // Its nearest point is too weak: others of it, and what stands beside and behind, may be
        // heard, and what is mirrored may return.
        let view = self.cone.front(self.scene);
        if view.is_complete() {
            self.hear_front(&view, &mut heard);
        } else {
            self.hear_in_a_crowd(&view, &mut heard);
        }
        heard
    }

    /// Every piece in sight, and what is mirrored by those that the rays meet.
    fn hear_front(&self, view: &ConeView, heard: &mut Heard) {
        for piece in view.pieces() {
            if let Some(echo) = self.echo_of(piece) {
                heard.offer(echo.distance_m, false);
            }
        }
        if !self.follows_mirrors() {
            return;
        }
        let n_rays = self.model.n_rays;
        let mut pieces = view.pieces().iter().peekable();
        for i in 0..n_rays {
            let slope = self.cone.slope(i, n_rays);
            while pieces.next_if(|piece| piece.slopes()[1] < slope).is_some() {}
            let Some(piece) = pieces.peek() else { return };
            if piece.slopes()[0] <= slope {
                self.hear_ghost(&piece.at_slope(slope), heard);
            }
        }
    }

    /// In a crowd, such as the points of a scanned map, echoes are sampled along rays; what is in
    /// sight beside the crowd is heard exactly.
    fn hear_in_a_crowd(&self, view: &ConeView, heard: &mut Heard) {
        let n_rays = self.model.n_rays;
        for i in 0..n_rays {
            let Some(met) = self.cone.cast(self.cone.slope(i, n_rays), self.scene) else {
                continue;
            };
            if self.hears(&met) {
                heard.offer(met.distance_m, false);
            } else if self.follows_mirrors() {
                self.hear_ghost(&met, heard);
            }
        }
        for piece in view.pieces() {
            if let Some(echo) = self.echo_of(piece)
                && echo.distance_m < heard.nearest_m
                && self.cone.sees(&echo, self.scene)
            {
                heard.offer(echo.distance_m, false);
            }
        }
    }

    /// The nearest point of a piece, or of where the rays meet it, whose echo is strong enough.
    fn echo_of(&self, piece: &Piece) -> Option<Sighting> {
        let holds = |s: &Sighting| s.distance_m <= self.model.range_max_m && self.hears(s);
        let nearest = piece.nearest();
        if holds(&nearest) {
            return Some(nearest);
        }
        let [right, left] = piece.slopes();
        let n_rays = self.model.n_rays;
        let first = self.cone.first_slope_from(right, n_rays);
        let slopes = (first..n_rays).map(|i| self.cone.slope(i, n_rays));
        let met = slopes.take_while(|&slope| slope <= left).map(|slope| piece.at_slope(slope));
        met.filter(holds).min_by(|a, b| a.distance_m.total_cmp(&b.distance_m))
    }

    fn follows_mirrors(&self) -> bool {
        self.fate.ghost < self.model.ghost_prob
    }

    /// Follows the sound one surface further from where it was mirrored; the echo returns by the way
    /// it came.
    fn hear_ghost(&self, mirror: &Sighting, heard: &mut Heard) {
        let range_max_m = self.model.range_max_m;
        // What it sends back itself is no mirror; and no ghost is nearer than what shows it.
        if mirror.distance_m >= heard.nearest_m.min(range_max_m) || self.hears(mirror) {
            return;
        }
        let mirrored = mirror.point / mirror.distance_m + 2.0 * mirror.cosine() * mirror.normal;
        let at = mirror.point + OFF_THE_MIRROR_M * mirror.normal;
        let world_from_sensor = self.cone.world_from_sensor();
        let ray = Ray {
            origin: world_from_sensor.transform_point(at),
            direction: world_from_sensor.rotate(mirrored),
        };
        let Some(hit) = self.scene.cast(&ray, range_max_m - mirror.distance_m) else { return };
        let distance_m = mirror.distance_m + hit.distance_m;
        let cosine = (-hit.normal.dot(&ray.direction)).clamp(0.0, 1.0);
        let sent = self.fate.strength * self.model.beam_ratio(mirror.bearing_rad());
        let returned = sent * self.material(hit.tag).returned_ratio(cosine);
        if returned >= self.model.threshold_at(distance_m) {
            heard.offer(distance_m, true);
        }
    }

    /// Whether the echo of a point in sight is strong enough.
    fn hears(&self, sighting: &Sighting) -> bool {
        let returned = self.material(sighting.tag).returned_ratio(sighting.cosine());
        let sent = self.fate.strength * returned;
        let threshold = self.model.threshold_at(sighting.distance_m);
        // The beam only ever weakens.
        sent >= threshold && sent * self.model.beam_ratio(sighting.bearing_rad()) >= threshold
    }

    fn material(&self, tag: u32) -> &Material {
        self.materials.get(tag as usize).unwrap_or(&self.materials[0])
    }
}

impl SonarModel {
    /// Strength that an echo from `distance_m` needs to be heard.
    fn threshold_at(&self, distance_m: f64) -> f64 {
        self.threshold_ratio * distance_m / self.range_max_m
    }

    /// Sensitivity at an angle to the axis: a Gaussian that reaches its edge value at the edge.
    fn beam_ratio(&self, bearing_rad: f64) -> f64 {
        if self.edge_sensitivity_ratio >= 1.0 || self.half_angle_rad <= 0.0 {
            return 1.0;
        }
        let ratio = bearing_rad / self.half_angle_rad;
        self.edge_sensitivity_ratio.powf(ratio * ratio)
    }
}

impl Material {
    /// Part of the sound that comes back to the sender, for the cosine of the incidence.
    fn returned_ratio(&self, cosine: f64) -> f64 {
        if cosine >= self.specular_from_rad.cos() {
            self.reflectivity_ratio
        } else {
            self.diffuse_ratio * cosine
        }
    }
}
