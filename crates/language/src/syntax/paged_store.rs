//! Lists of nodes of which only a part may be loaded.
//!
//! The tree of a large program would take many times the memory of its text. If blocks contain only words, a page of them is loaded when it is
//! executed, and unloaded when the next one is loaded. Nodes keep their numbers.

use std::ops::{Index, IndexMut, Range};

/// Nodes by number.
#[derive(Clone, Debug)]
pub struct PagedStore<T> {
    /// Number of the first loaded node.
    first: usize,
    items: Vec<T>,
    /// Total number of nodes, loaded or not.
    count: usize,
}

impl<T> Default for PagedStore<T> {
    fn default() -> Self {
        PagedStore { first: 0, items: Vec::new(), count: 0 }
    }
}

impl<T> PagedStore<T> {
    /// Number of nodes, loaded or not.
    #[must_use]
    pub fn len(&self) -> usize {
        self.count
    }

    /// `true` if there are no nodes.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// `true` if a node is loaded.
    #[must_use]
    pub fn holds(&self, number: usize) -> bool {
        number.wrapping_sub(self.first) < self.items.len()
    }

    /// A node; `None` if it is not loaded.
    #[must_use]
    pub fn get(&self, number: usize) -> Option<&T> {
        self.items.get(number.wrapping_sub(self.first))
    }

    /// A mutable node; `None` if it is not loaded.
    pub(super) fn get_mut(&mut self, number: usize) -> Option<&mut T> {
        self.items.get_mut(number.wrapping_sub(self.first))
    }

    /// Nodes with these numbers; empty if not all of them are loaded.
    #[must_use]
    pub fn range(&self, numbers: Range<usize>) -> &[T] {
        let (start, end) = (numbers.start.wrapping_sub(self.first), numbers.end.wrapping_sub(self.first));
        self.items.get(start..end).unwrap_or_default()
    }

    /// The loaded nodes among these numbers.
    #[must_use]
    pub fn there(&self, numbers: Range<usize>) -> &[T] {
        let clip = |number: usize| number.clamp(self.first, self.next()) - self.first;
        self.items.get(clip(numbers.start)..clip(numbers.end)).unwrap_or_default()
    }

    /// The loaded nodes.
    pub fn iter(&self) -> std::slice::Iter<'_, T> {
        self.items.iter()
    }

    /// The number of the next node.
    pub(super) fn next(&self) -> usize {
        self.first + self.items.len()
    }

    pub(super) fn push(&mut self, item: T) {
        self.items.push(item);
        self.count = self.count.max(self.next());
    }

    /// Counts nodes that are not loaded, instead of the loaded ones.
    pub(super) fn leave_out(&mut self, count: usize) {
        self.turn_to(self.next() + count);
        self.count = self.count.max(self.first);
    }

    /// Unloads all nodes; the next ones begin with number `first`.
    pub(super) fn turn_to(&mut self, first: usize) {
        self.first = first;
        self.items.clear();
    }
}

impl<T> Extend<T> for PagedStore<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, items: I) {
        self.items.extend(items);
        self.count = self.count.max(self.next());
    }
}

impl<T> Index<usize> for PagedStore<T> {
    type Output = T;

    fn index(&self, number: usize) -> &T {
        &self.items[number.wrapping_sub(self.first)]
    }
}

impl<T> IndexMut<usize> for PagedStore<T> {
    fn index_mut(&mut self, number: usize) -> &mut T {
        &mut self.items[number.wrapping_sub(self.first)]
    }
}

impl<T> Index<Range<usize>> for PagedStore<T> {
    type Output = [T];

    fn index(&self, numbers: Range<usize>) -> &[T] {
        &self.items[numbers.start.wrapping_sub(self.first)..numbers.end.wrapping_sub(self.first)]
    }
}

impl<'a, T> IntoIterator for &'a PagedStore<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// Page starts of a program.
#[derive(Clone, Debug)]
pub(super) struct Pages<const N: usize> {
    starts: Vec<Start<N>>,
    /// Offset after the last page.
    pub(super) end: usize,
}

/// The beginning of a page.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start<const N: usize> {
    /// Its offset in the file.
    pub(super) offset: usize,
    /// Number of lines before it.
    pub(super) lines: u32,
    /// Number of its first node in each list, blocks first.
    pub(super) first: [usize; N],
}

impl<const N: usize> Pages<N> {
    /// Empty page list of a file that ends at an offset.
    pub(super) fn until(end: usize) -> Self {
        Pages { starts: Vec::new(), end }
    }

    pub(super) fn push(&mut self, start: Start<N>) {
        self.starts.push(start);
    }

    /// The page of a block: its start, and the offset of its end.
    pub(super) fn of_block(&self, number: usize) -> Option<(Start<N>, usize)> {
        let next = self.starts.partition_point(|start| start.first[0] <= number);
        let page = self.starts.get(next.checked_sub(1)?)?;
        Some((*page, self.starts.get(next).map_or(self.end, |next| next.offset)))
    }

    /// `true` for the first page.
    pub(super) fn is_first(&self, page: &Start<N>) -> bool {
        self.starts.first().is_none_or(|first| first.offset == page.offset)
    }

    /// The first blocks of all pages.
    pub(super) fn first_blocks(&self) -> impl Iterator<Item = usize> {
        self.starts.iter().map(|start| start.first[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stay_when_nodes_leave() {
        let mut shelf = PagedStore::default();
        shelf.extend(['a', 'b', 'c']);
        shelf.turn_to(3);
        shelf.push('d');
        assert_eq!((shelf.len(), shelf.next(), shelf.get(2), shelf.get(3)), (4, 4, None, Some(&'d')));
        shelf.turn_to(1);
        shelf.extend(['b', 'c']);
        assert_eq!((shelf.len(), shelf.next(), &shelf[1..3], shelf.range(0..2)), (4, 3, &['b', 'c'][..], &[][..]));
        assert!(shelf.holds(1) && !shelf.holds(0) && !shelf.holds(3));
    }
}
