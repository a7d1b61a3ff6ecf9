//! `ncfix tables --format`: what is made, what is told of it, and what is refused.
