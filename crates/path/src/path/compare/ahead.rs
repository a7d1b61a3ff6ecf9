//! The moves of a program with look-ahead, and the search for a common block after two programs diverge.

use std::collections::VecDeque;

use super::step::ComparedMove;

/// Number of moves of each program in which a common block is searched.
const LOOK: usize = 500;

/// Moves that can be inspected before they are taken.
pub(super) struct MovesAhead<'m, I> {
    moves: I,
    queue: VecDeque<ComparedMove<'m>>,
    /// `true` once a move was taken.
    pub(super) has_begun: bool,
}

impl<'m, I: Iterator<Item = ComparedMove<'m>>> MovesAhead<'m, I> {
    pub(super) fn new(moves: I) -> MovesAhead<'m, I> {
        MovesAhead { moves, queue: VecDeque::new(), has_begun: false }
    }

    /// The next move, which is not taken.
    pub(super) fn peek(&mut self) -> Option<&ComparedMove<'m>> {
        if self.queue.is_empty() {
            self.queue.push_back(self.moves.next()?);
        }
        self.queue.front()
    }

    /// Puts a taken move back.
    pub(super) fn put_back(&mut self, step: ComparedMove<'m>) {
        self.queue.push_front(step);
    }

    /// Takes up to `count` moves.
    fn take(&mut self, count: usize) -> Vec<ComparedMove<'m>> {
        let count = count.min(self.queue.len());
        self.queue.drain(..count).collect()
    }

    /// Omits the next move; what belongs to it goes to the one after it. The last move stays: returns `false`.
    fn omit(&mut self) -> bool {
        let Some(lead) = self.next() else { return false };
        let Some(mut next) = self.next() else {
            self.put_back(lead);
            return false;
        };
        next.take_over(lead);
        self.put_back(next);
        true
    }

    fn look(&mut self) {
        while self.queue.len() < LOOK
            && let Some(step) = self.moves.next()
        {
            self.queue.push_back(step);
        }
    }
}

impl<'m, I: Iterator<Item = ComparedMove<'m>>> Iterator for MovesAhead<'m, I> {
    type Item = ComparedMove<'m>;

    fn next(&mut self) -> Option<ComparedMove<'m>> {
        let step = self.queue.pop_front().or_else(|| self.moves.next());
        self.has_begun |= step.is_some();
        step
    }
}

/// Omits moves of both that lead to a hole at which the tool nearly is, unless the other program has the same move.
pub(super) fn omit_leads<'m, I, J>(original: &mut MovesAhead<'m, I>, corrected: &mut MovesAhead<'m, J>)
where
    I: Iterator<Item = ComparedMove<'m>>,
    J: Iterator<Item = ComparedMove<'m>>,
{
    loop {
        let (step, piece) = (original.peek(), corrected.peek());
        let own = step.is_some_and(|step| step.is_lead_beside(piece));
        let other = piece.is_some_and(|piece| piece.is_lead_beside(step));
        let is_omitted = (own && original.omit()) | (other && corrected.omit());
        if !is_omitted {
            return;
        }
    }
}

/// Continues in both after the next move with the same block number in both and the same end, as `meets` determines. Returns the skipped moves;
/// `None` if there is no such move.
pub(super) fn rejoin<'m, I, J>(
    original: &mut MovesAhead<'m, I>,
    corrected: &mut MovesAhead<'m, J>,
    meets: impl Fn(&ComparedMove<'m>, &ComparedMove<'m>) -> bool,
) -> Option<[Vec<ComparedMove<'m>>; 2]>
where
    I: Iterator<Item = ComparedMove<'m>>,
    J: Iterator<Item = ComparedMove<'m>>,
{
    original.look();
    corrected.look();
    let mut best: Option<[usize; 2]> = None;
    for (at, step) in original.queue.iter().enumerate() {
        if best.is_some_and(|[own, other]| at >= own + other) {
            break;
        }
        let Some(number) = step.number.filter(|_| step.origin.calls == 0) else { continue };
        let Some(start) = corrected.queue.iter().position(|piece| piece.number == Some(number)) else { continue };
        // The last piece of that move.
        let more = corrected.queue.iter().skip(start + 1).take_while(|piece| piece.continues).count();
        let end = start + more;
        let is_nearer = best.is_none_or(|[own, other]| at + end < own + other);
        if is_nearer && corrected.queue.get(end).is_some_and(|piece| meets(step, piece)) {
            best = Some([at, end]);
        }
    }
    let [own, other] = best?;
    Some([original.take(own + 1), corrected.take(other + 1)])
}
