//! Closed loops with an ideal differential drive, which shares no code with the product.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

mod followers;
mod promises;
mod trails;
