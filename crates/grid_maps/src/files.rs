//! Maps as bytes and texts: what ROS's map server, picture viewers and path planners read.
//!
//! Nothing here touches a file system: whoever owns the files passes their contents.

mod embedded;
pub mod map_server;
pub mod moving_ai;
mod pgm;
mod png;
mod yaml;

pub use embedded::read_picture;
pub use pgm::{GreyImage, read_pgm, write_pgm};
pub use png::{ColourScheme, read_png, write_coloured_png, write_png};
pub use yaml::{MapYaml, Mode};
