//! The drivers against real partners at the other end of a simulated link.

mod closed_loop;
mod create;
mod ground;
mod pheromones;
mod pioneer;
