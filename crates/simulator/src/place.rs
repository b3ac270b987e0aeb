//! Where things can be.

/// No coordinate of a world may be larger: beyond it a millimetre is lost in rounding.
const COORDINATE_MAX_M: f64 = 1e6;

/// Whether a number can be a coordinate (m): finite, and not absurd.
pub(crate) fn is_place(value: f64) -> bool {
    value.abs() <= COORDINATE_MAX_M
}
