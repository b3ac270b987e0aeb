//! What searches share: what is known of each cell, and which one comes next.

/// What is known of a cell in the present search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    /// Length of the best way known, cells.
    pub(crate) way: f64,
    /// The cell before it on that way.
    pub(crate) parent: u32,
    /// The search that wrote it, shifted left, and whether it was expanded since it was last improved.
    stamp: u32,
}

impl Node {
    /// Whether it was expanded since its way was last improved.
    #[inline]
    pub(crate) fn is_closed(&self) -> bool {
        self.stamp & 1 != 0
    }
}

/// Ways whose lengths differ by less are equally long, cells: sums of the same steps in another order.
pub(crate) const SAME_WAY: f64 = 1e-7;

/// All cells of a floor; a search is begun without touching them.
#[derive(Clone, Debug)]
pub(crate) struct Nodes {
    nodes: Vec<Node>,
    search: u32,
}

impl Nodes {
    pub(crate) fn new(n_nodes: usize) -> Self {
        Self { nodes: vec![Node { way: 0.0, parent: 0, stamp: 0 }; n_nodes], search: 0 }
    }

    /// Forgets what the last search found out.
    pub(crate) fn begin(&mut self) {
        self.search += 2;
        if self.search >= u32::MAX - 2 {
            self.nodes.iter_mut().for_each(|node| node.stamp = 0);
            self.search = 2;
        }
    }

    /// What is known of a cell in this search.
    #[inline]
    pub(crate) fn get(&self, node: u32) -> Option<&Node> {
        let known = &self.nodes[node as usize];
        (known.stamp & !1 == self.search).then_some(known)
    }

    /// Whether the way to a cell is new or shorter than what was known; then it is kept.
    #[inline]
    pub(crate) fn improve(&mut self, node: u32, parent: u32, way: f64) -> bool {
        let known = &mut self.nodes[node as usize];
        let better = known.stamp & !1 != self.search || way < known.way - SAME_WAY;
        if better {
            *known = Node { way, parent, stamp: self.search };
        }
        better
    }

    /// Marks a cell as expanded; `None` when it was since its way was last improved. Otherwise its way and parent.
    #[inline]
    pub(crate) fn close(&mut self, node: u32) -> Option<(f64, u32)> {
        let known = &mut self.nodes[node as usize];
        if known.stamp & 1 != 0 {
            return None;
        }
        known.stamp |= 1;
        Some((known.way, known.parent))
    }

    /// Places another parent and way, whatever was known.
    #[inline]
    pub(crate) fn amend(&mut self, node: u32, parent: u32, way: f64) {
        let known = &mut self.nodes[node as usize];
        (known.parent, known.way) = (parent, way);
    }
}

/// Cells in the order of their estimates, roughly: those within a part of a step of each other come last in, first
/// out.
///
/// The order within a bucket does not matter for what is found, because a way is taken for the shortest only when its
/// bucket is empty, and a cell may be expanded again; it matters little for the time, because estimates of
/// neighbours differ by nothing or by more than half a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Open {
    buckets: Vec<Vec<u32>>,
    first: usize,
    base: f64,
    n_waiting: usize,
}

/// Buckets for each cell of way.
const BUCKETS_PER_CELL: f64 = 4.0;

impl Open {
    /// Empties it; no estimate will be below `base`.
    pub(crate) fn begin(&mut self, base: f64) {
        self.buckets.iter_mut().for_each(Vec::clear);
        (self.first, self.base, self.n_waiting) = (0, base, 0);
    }

    #[inline]
    pub(crate) fn push(&mut self, node: u32, estimate: f64) {
        let bucket = self.bucket(estimate).max(self.first);
        if bucket >= self.buckets.len() {
            self.buckets.resize_with(bucket + 1, Vec::new);
        }
        self.buckets[bucket].push(node);
        self.n_waiting += 1;
    }

    /// The next cell, if one waits whose bucket is not behind the one of `estimate`.
    #[inline]
    pub(crate) fn pop_within(&mut self, estimate: f64) -> Option<u32> {
        if self.n_waiting == 0 {
            return None;
        }
        let last = if estimate.is_finite() { self.bucket(estimate) } else { usize::MAX };
        while self.first <= last {
            let bucket = self.buckets.get_mut(self.first)?;
            if let Some(node) = bucket.pop() {
                self.n_waiting -= 1;
                return Some(node);
            }
            self.first += 1;
        }
        None
    }

    #[inline]
    fn bucket(&self, estimate: f64) -> usize {
        // A cast saturates; what is below the base by rounding is in the first.
        ((estimate - self.base) * BUCKETS_PER_CELL) as usize
    }
}
