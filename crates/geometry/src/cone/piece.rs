//! One visible piece of a surface, between two bearings.

use crate::Vec2;

/// A piece of a surface that is in sight, between two bearings; in the sensor's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Slopes (tangents of the bearings) of its right and its left end.
    pub(super) slopes: [f64; 2],
    pub(super) surface: Surface,
    pub(super) tag: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Surface {
    /// Straight: one over the depth along the axis at both ends, 1/m; linear in the slope between.
    Line { inverse: [f64; 2] },
    /// The near side of a disc (m) that does not hold the apex.
    Disc { centre: Vec2, radius_m: f64 },
}

/// A point of a surface that is in sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Where, in the sensor's frame (m).
    pub point: Vec2,
    /// From the apex, metres.
    pub distance_m: f64,
    /// Unit normal of the surface there, on the side of the apex, in the sensor's frame.
    pub normal: Vec2,
    /// What the owner of the surface attached to it.
    pub tag: u32,
}

impl Sighting {
    /// Cosine of the incidence, from 0 (grazing) to 1 (squarely).
    pub fn cosine(&self) -> f64 {
        let along = -self.normal.dot(&self.point);
        if self.distance_m > 0.0 { (along / self.distance_m).clamp(0.0, 1.0) } else { 1.0 }
    }

    /// Angle to the axis, radians, to the left positive.
    pub fn bearing_rad(&self) -> f64 {
        self.point.y.atan2(self.point.x)
    }
}

impl Piece {
    pub(super) fn new(slopes: [f64; 2], surface: Surface, tag: u32) -> Self {
        Self { slopes, surface, tag }
    }

    /// Slopes (tangents of the bearings to the axis) of its right and its left end.
    pub fn slopes(&self) -> [f64; 2] {
        self.slopes
    }

    /// The point of it that is nearest to the apex.
    pub fn nearest(&self) -> Sighting {
        match self.surface {
            Surface::Line { .. } => {
                let (from, along) = self.ends();
                let length_squared = along.norm_squared();
                let ratio = if length_squared > 0.0 {
                    (-from.dot(&along) / length_squared).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                self.on_line(from + ratio * along, along)
            }
            Surface::Disc { centre, .. } => {
                let [right, left] = self.slopes;
                let slope = if centre.x > 0.0 {
                    (centre.y / centre.x).clamp(right, left)
                } else if centre.y > 0.0 {
                    left
                } else {
                    right
                };
                self.at_slope(slope)
            }
        }
    }

    /// The point of it at a slope between its ends.
    pub fn at_slope(&self, slope_ratio: f64) -> Sighting {
        let depth_m = 1.0 / self.inverse_depth(slope_ratio);
        let point = Vec2::new(depth_m, depth_m * slope_ratio);
        match self.surface {
            Surface::Line { .. } => self.on_line(point, self.ends().1),
            Surface::Disc { centre, radius_m } => Sighting {
                point,
                distance_m: point.norm(),
                normal: (point - centre) / radius_m,
                tag: self.tag,
            },
        }
    }

    /// One over the depth (1/m) of its deepest end; a disc bulges towards the apex.
    #[inline]
    pub(super) fn inverse_depth_min(&self) -> f64 {
        match self.surface {
            Surface::Line { inverse: [right, left] } => right.min(left),
            Surface::Disc { .. } => {
                let [right, left] = self.slopes;
                self.inverse_depth(right).min(self.inverse_depth(left))
            }
        }
    }

    /// Its right end (m), and from there to its left end.
    fn ends(&self) -> (Vec2, Vec2) {
        let end = |slope: f64| {
            let depth_m = 1.0 / self.inverse_depth(slope);
            Vec2::new(depth_m, depth_m * slope)
        };
        let from = end(self.slopes[0]);
        (from, end(self.slopes[1]) - from)
    }

    fn on_line(&self, point: Vec2, along: Vec2) -> Sighting {
        let length_m = along.norm();
        // From right to left: the apex is on the left of the way.
        let normal = if length_m > 0.0 {
            Vec2::new(-along.y, along.x) / length_m
        } else {
            -point.normalize()
        };
        Sighting { point, distance_m: point.norm(), normal, tag: self.tag }
    }

    /// One over the depth along the axis at a slope, 1/m: the greater, the nearer.
    #[inline]
    pub(super) fn inverse_depth(&self, slope: f64) -> f64 {
        match self.surface {
            Surface::Line { inverse: [right, left] } => {
                let [from, to] = self.slopes;
                if slope >= to {
                    left
                } else {
                    right + (left - right) * ((slope - from) / (to - from))
                }
            }
            Surface::Disc { centre, radius_m } => {
                // (x − c_x)² + (s x − c_y)² = r², solved for 1/x.
                let along = centre.x + slope * centre.y;
                let outside = centre.norm_squared() - radius_m * radius_m;
                let root = along * along - (1.0 + slope * slope) * outside;
                (along + root.max(0.0).sqrt()) / outside
            }
        }
    }

    /// The piece between two slopes within it.
    pub(super) fn part(&self, slopes: [f64; 2]) -> Self {
        let surface = match self.surface {
            Surface::Line { .. } => {
                Surface::Line { inverse: slopes.map(|slope| self.inverse_depth(slope)) }
            }
            disc @ Surface::Disc { .. } => disc,
        };
        Self { slopes, surface, tag: self.tag }
    }

    /// Slopes at which the two surfaces may change places, strictly between `from` and `to`, in
    /// order; NaN for none.
    pub(super) fn crossings(&self, other: &Self, [from, to]: [f64; 2]) -> [f64; 2] {
        let none = f64::NAN;
        let found = match (self.surface, other.surface) {
            (Surface::Line { .. }, Surface::Line { .. }) => {
                let gap = |slope| {
                    let (a, b) = (self.inverse_depth(slope), other.inverse_depth(slope));
                    // What touches does not cross.
                    if (a - b).abs() <= 1e-12 * a { 0.0 } else { a - b }
                };
                let (at_from, at_to) = (gap(from), gap(to));
                let crosses = (at_from > 0.0 && at_to < 0.0) || (at_from < 0.0 && at_to > 0.0);
                [
                    if crosses { from + (to - from) * (at_from / (at_from - at_to)) } else { none },
                    none,
                ]
            }
            (Surface::Line { .. }, Surface::Disc { centre, radius_m }) => {
                let (start, along) = self.ends();
                line_through_disc(start, along, centre, radius_m)
            }
            (Surface::Disc { .. }, Surface::Line { .. }) => {
                return other.crossings(self, [from, to]);
            }
            (
                Surface::Disc { centre: c, radius_m: r },
                Surface::Disc { centre: d, radius_m: q },
            ) => disc_on_disc(c, r, d, q),
        };
        let within = found.map(|slope| if from < slope && slope < to { slope } else { none });
        if within[0].is_nan() || within[1] < within[0] { [within[1], within[0]] } else { within }
    }
}

/// Slopes at which a line enters and leaves a disc.
fn line_through_disc(start: Vec2, along: Vec2, centre: Vec2, radius_m: f64) -> [f64; 2] {
    let (to_start, squared) = (start - centre, along.norm_squared());
    let half = to_start.dot(&along) / squared;
    let root = (half * half - (to_start.norm_squared() - radius_m * radius_m) / squared).sqrt();
    [-half - root, -half + root].map(|ratio| {
        let point = start + ratio * along;
        point.y / point.x
    })
}

/// Slopes of the points that two circles share.
fn disc_on_disc(c: Vec2, r: f64, d: Vec2, q: f64) -> [f64; 2] {
    let (between, apart) = (d - c, (d - c).norm());
    let along = (apart * apart + r * r - q * q) / (2.0 * apart);
    let aside = (r * r - along * along).sqrt();
    let unit = between / apart;
    [-aside, aside].map(|aside| {
        let point = c + along * unit + aside * Vec2::new(-unit.y, unit.x);
        point.y / point.x
    })
}
