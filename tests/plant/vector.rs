//! Vectors, rotations and rigid frames of the plant, written for it alone.

/// Three coordinates, mm or rad.
pub(crate) type V3 = [f64; 3];

/// Rows of a rotation.
pub(crate) type Mat = [[f64; 3]; 3];

/// The rotation by nothing.
pub(crate) const UNIT: Mat = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// a + b
pub(crate) fn add(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a − b
pub(crate) fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// k a
pub(crate) fn scale(a: V3, k: f64) -> V3 {
    [a[0] * k, a[1] * k, a[2] * k]
}

/// a · b
pub(crate) fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b
pub(crate) fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// |a|
pub(crate) fn norm(a: V3) -> f64 {
    dot(a, a).sqrt()
}

/// A direction of F.
pub(crate) fn along(direction: usize, k: f64) -> V3 {
    let mut out = [0.0; 3];
    out[direction] = k;
    out
}

/// R a
pub(crate) fn turn(r: &Mat, a: V3) -> V3 {
    [dot(r[0], a), dot(r[1], a), dot(r[2], a)]
}

/// Rᵀ
pub(crate) fn transposed(r: &Mat) -> Mat {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| r[j][i]))
}

/// A B
pub(crate) fn product(a: &Mat, b: &Mat) -> Mat {
    let columns = transposed(b);
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| dot(a[i], columns[j])))
}

/// The rotation by a vector: about its direction by its length.
pub(crate) fn rotation(by: V3) -> Mat {
    let angle = norm(by);
    if angle == 0.0 {
        return UNIT;
    }
    let n = scale(by, 1.0 / angle);
    let (s, c) = angle.sin_cos();
    let v = 2.0 * (angle / 2.0).sin().powi(2);
    [
        [c + v * n[0] * n[0], v * n[0] * n[1] - s * n[2], v * n[0] * n[2] + s * n[1]],
        [v * n[1] * n[0] + s * n[2], c + v * n[1] * n[1], v * n[1] * n[2] - s * n[0]],
        [v * n[2] * n[0] - s * n[1], v * n[2] * n[1] + s * n[0], c + v * n[2] * n[2]],
    ]
}

/// The vector of a small rotation, from its skew part.
pub(crate) fn small_turn(r: &Mat) -> V3 {
    let skew = [(r[2][1] - r[1][2]) / 2.0, (r[0][2] - r[2][0]) / 2.0, (r[1][0] - r[0][1]) / 2.0];
    let s = norm(skew);
    if s < 1e-12 { skew } else { scale(skew, s.asin() / s) }
}

/// A rigid displacement: turn, then shift.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) r: Mat,
    pub(crate) t: V3,
}

impl Frame {
    /// A shift.
    pub(crate) fn shift(t: V3) -> Frame {
        Frame { r: UNIT, t }
    }

    /// A turn about the origin.
    pub(crate) fn turn(by: V3) -> Frame {
        Frame { r: rotation(by), t: [0.0; 3] }
    }

    /// A small displacement EX EY EZ EA EB EC.
    pub(crate) fn small(e: [f64; 6]) -> Frame {
        Frame { r: rotation([e[3], e[4], e[5]]), t: [e[0], e[1], e[2]] }
    }

    /// This, then (further out) the other.
    pub(crate) fn then(&self, other: &Frame) -> Frame {
        Frame { r: product(&self.r, &other.r), t: add(turn(&self.r, other.t), self.t) }
    }

    /// The inverse of this times the other.
    pub(crate) fn sees(&self, other: &Frame) -> Frame {
        let back = transposed(&self.r);
        Frame { r: product(&back, &other.r), t: turn(&back, sub(other.t, self.t)) }
    }
}
