//! Who makes the map, and in which form.

/// Who makes the map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// The rig decides: a laser is mapped by [`Method::Laser`], a ring by [`Method::Sonar`].
    #[default]
    Auto,
    /// Scan matching, keyframes and loop closure.
    Laser,
    /// Short-term maps and continuous localisation.
    Sonar,
    /// Dead reckoning as it is: what the other methods are compared with.
    Odometry,
}

/// Which form of the sonar method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Our own.
    #[default]
    Default,
    /// Our own, with its short-term maps as submaps of a pose graph and loops between them.
    Graph,
    /// As ARTEMIC's thesis describes it.
    Thesis,
    /// As its printed program computes it, number by number.
    Listing,
}
