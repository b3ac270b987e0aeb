//! Where a Pioneer's bumpers are.

/// Segments of the bumpers in front, and as many behind.
pub(super) const N_SEGMENTS: u8 = 5;
/// Angle that one segment covers, degrees.
const SEGMENT_DEG: f64 = 27.0;

/// The bearings between which the segments lie, right and left, degrees: five of the front, five of the rear, in
/// each ring clockwise. The sides, where the wheels are, have none.
///
/// Source: the client library AriaCoda (commit b0d02e0) places the readings of five segments in
/// this order over 135°.
pub(super) fn bumper_bearings_deg() -> impl Iterator<Item = [f64; 2]> {
    [0.0, 180.0].into_iter().flat_map(|middle_deg| {
        (0..N_SEGMENTS).map(move |index| {
            let half_span = 0.5 * f64::from(N_SEGMENTS);
            let left_deg = middle_deg + SEGMENT_DEG * (half_span - f64::from(index));
            [left_deg - SEGMENT_DEG, left_deg]
        })
    })
}
