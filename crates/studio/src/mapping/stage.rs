//! What the player shows and every page looks at: greeting, source, state, and a board for each run.

use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;
use tokio::sync::watch;

use super::{
    board::{Board, Message, Seen},
    protocol::{Source, State},
};

/// Runs at a time: one, or two that are compared.
pub(crate) const N_SLOTS: usize = 2;

/// The shared picture. Cloning gives another handle to it.
#[derive(Clone, Debug)]
pub(crate) struct Stage {
    scene: Arc<Mutex<Scene>>,
    /// Counts the changes, and wakes the pages.
    bell: watch::Sender<u64>,
}

#[derive(Debug, Default)]
struct Scene {
    hello: String,
    /// With the number of its last change.
    source: (u64, String),
    state: (u64, String),
    boards: [Option<Board>; N_SLOTS],
}

/// What one page was sent.
#[derive(Debug, Default)]
pub(crate) struct PageSeen {
    greeted: bool,
    source: u64,
    state: u64,
    boards: [Seen; N_SLOTS],
}

impl Stage {
    /// An empty stage with its greeting.
    pub(crate) fn new(hello: &impl Serialize) -> Self {
        let scene = Scene { hello: text(hello), ..Scene::default() };
        Self { scene: Arc::new(Mutex::new(scene)), bell: watch::Sender::new(0) }
    }

    /// Wakes whenever there may be news.
    pub(crate) fn listen(&self) -> watch::Receiver<u64> {
        self.bell.subscribe()
    }

    pub(crate) fn show_source(&self, source: &Source) {
        self.change(|scene| scene.source = (scene.source.0 + 1, text(source)));
    }

    pub(crate) fn show_state(&self, state: &State) {
        self.change(|scene| scene.state = (scene.state.0 + 1, text(state)));
    }

    /// Paints on a board; nothing when the slot is empty.
    pub(crate) fn paint<T>(&self, slot: usize, paint: impl FnOnce(&mut Board) -> T) -> Option<T> {
        self.change(|scene| scene.boards.get_mut(slot)?.as_mut().map(paint))
    }

    /// Puts boards into the slots.
    pub(crate) fn set_boards(&self, boards: [Option<Board>; N_SLOTS]) {
        self.change(|scene| scene.boards = boards);
    }

    /// Takes the boards out of the slots.
    pub(crate) fn take_boards(&self) -> [Option<Board>; N_SLOTS] {
        self.change(|scene| std::mem::take(&mut scene.boards))
    }

    /// What a page has not been sent. The second value says that there is more already.
    pub(crate) fn news(&self, seen: &mut PageSeen) -> (Vec<Message>, bool) {
        let scene = self.scene.lock().unwrap_or_else(PoisonError::into_inner);
        let mut messages = Vec::new();
        if !seen.greeted {
            seen.greeted = true;
            messages.push(Message::Text(scene.hello.clone()));
        }
        for (told, (changed, text)) in
            [(&mut seen.source, &scene.source), (&mut seen.state, &scene.state)]
        {
            if *changed > *told {
                *told = *changed;
                messages.push(Message::Text(text.clone()));
            }
        }
        for (slot, (board, seen)) in scene.boards.iter().zip(&mut seen.boards).enumerate() {
            if let Some(board) = board {
                let (news, more_here) = board.news(slot, seen);
                messages.extend(news);
                // A page takes one piece at a time.
                if more_here {
                    return (messages, true);
                }
            }
        }
        (messages, false)
    }

    /// A page that panicked while it looked has not damaged the scene, which only the player changes.
    fn change<T>(&self, change: impl FnOnce(&mut Scene) -> T) -> T {
        let changed = change(&mut self.scene.lock().unwrap_or_else(PoisonError::into_inner));
        self.bell.send_modify(|n| *n += 1);
        changed
    }
}

/// Our messages hold strings, finite numbers and lists only, which always have a text.
fn text(message: &impl Serialize) -> String {
    serde_json::to_string(message).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_hears_the_greeting_once_and_the_newest_of_the_rest() {
        let stage = Stage::new(&"hello");
        let mut seen = PageSeen::default();
        let texts = |(messages, more): (Vec<Message>, bool)| {
            assert!(!more);
            messages.len()
        };
        assert_eq!(texts(stage.news(&mut seen)), 1);
        for name in ["a", "b"] {
            stage.show_source(&Source { name: name.to_owned(), ..Source::default() });
        }
        let (messages, _) = stage.news(&mut seen);
        let [Message::Text(text)] = messages.as_slice() else { panic!("{messages:?}") };
        assert!(text.contains(r#""name":"b""#));
        assert_eq!(texts(stage.news(&mut seen)), 0);
    }

    #[test]
    fn an_empty_slot_is_not_painted() {
        let stage = Stage::new(&"hello");
        assert_eq!(stage.paint(1, |_| 5), None);
        stage.set_boards([None, Some(Board::new(7))]);
        assert_eq!(stage.paint(1, |_| 5), Some(5));
        let [a, b] = stage.take_boards();
        assert!(a.is_none() && b.is_some());
    }
}
