//! A queue of fixed size that forgets its oldest entry when it is full, and counts what it forgot.

/// At most `N` entries, oldest first. Never allocates.
#[derive(Clone, Debug)]
pub(crate) struct Ring<T, const N: usize> {
    slots: [Option<T>; N],
    first: usize,
    len: usize,
    n_lost: u64,
    n_pushed: u64,
}

impl<T: Copy, const N: usize> Ring<T, N> {
    pub(crate) fn new() -> Self {
        Self { slots: [None; N], first: 0, len: 0, n_lost: 0, n_pushed: 0 }
    }

    pub(crate) fn push(&mut self, entry: T) {
        if self.len == N {
            self.pop();
            self.n_lost = self.n_lost.saturating_add(1);
        }
        let index = Self::wrapped(self.first.saturating_add(self.len));
        if let Some(slot) = self.slots.get_mut(index) {
            *slot = Some(entry);
            self.len = self.len.saturating_add(1);
            self.n_pushed = self.n_pushed.saturating_add(1);
        }
    }

    pub(crate) fn pop(&mut self) -> Option<T> {
        let entry = self.slots.get_mut(self.first)?.take()?;
        self.first = Self::wrapped(self.first.saturating_add(1));
        self.len = self.len.saturating_sub(1);
        Some(entry)
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = T> + '_ {
        let (wrapped, straight) = self.slots.split_at_checked(self.first).unwrap_or_default();
        straight.iter().chain(wrapped).flatten().copied()
    }

    /// Entries forgotten because the queue was full.
    pub(crate) fn n_lost(&self) -> u64 {
        self.n_lost
    }

    /// Entries ever taken in.
    pub(crate) fn n_pushed(&self) -> u64 {
        self.n_pushed
    }

    fn wrapped(index: usize) -> usize {
        index.checked_rem(N).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_entries_go_first_and_are_counted() {
        let mut ring = Ring::<u8, 3>::new();
        assert_eq!(ring.pop(), None);
        (0..5).for_each(|entry| ring.push(entry));
        assert_eq!(ring.iter().collect::<Vec<_>>(), [2, 3, 4]);
        assert_eq!((ring.pop(), ring.n_lost()), (Some(2), 2));
        ring.push(5);
        assert_eq!(ring.iter().collect::<Vec<_>>(), [3, 4, 5]);
        assert_eq!(std::iter::from_fn(|| ring.pop()).collect::<Vec<_>>(), [3, 4, 5]);
        assert_eq!(ring.n_lost(), 2);
    }
}
