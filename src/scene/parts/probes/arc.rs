//! The circular arc through the two ends of a sequence of points that is nearest to the points between them.
//!
//! With half of the chord as the unit of length, a point has the coordinate x along the chord, from −1 to 1, and u across it. The arc is given by w = tan(θ/4)
//! n, where θ is its angle and n the direction in which it bulges: its midpoint is at (0, w). The distance of the point from the circle is |d|,
//!
//! ```text
//! d = u + f w,  f = [2 (x² − 1) − 2 s − s (Q − B)/W²]/(Q + W² + 1),  s = u·w,  W = |w|,  B = 1 + 2 s − W²,  Q² = B² + 4 W² x²
//! ```
//!
//! which is smooth where the arc is straight: f = x² − 1 at w = 0. The fit minimises ½ Σ |d|² over w by Newton's method. Its derivatives with respect to the
//! points are those of the minimum, dw = −H⁻¹ dg with the gradient g and the Hessian H of the sum.

use crate::math::dual::{Dual, Number};

/// A vector in space.
pub(super) type Point<T> = [T; 3];

/// An arc with an angle of less than a full circle.
#[derive(Clone, Copy)]
pub(super) struct Arc<T> {
    /// Distance of its ends \[m\]
    chord: T,
    /// Unit vector from the first end to the last
    along: Point<T>,
    /// Bulge tan(θ/4) n
    bulge: Point<T>,
    /// Mean square distance of the points between the ends \[m²\]
    pub mean_square: T,
}

impl<T: Number> Arc<T> {
    /// Fits the arc to at least three points, of which the first and the last do not coincide.
    pub fn fit(points: &[Point<T>]) -> Self {
        let (first, last) = (points[0], points[points.len() - 1]);
        let chord = length(minus(last, first));
        let along = times(minus(last, first), T::constant(1.0) / chord);
        // A direction across the chord, from the axis of space that is farthest from it; the choice does not affect the result.
        let sizes = along.map(|a| a.value().abs());
        let axis = (0..3).min_by(|&i, &j| sizes[i].total_cmp(&sizes[j])).unwrap_or(0);
        let helper: Point<T> = std::array::from_fn(|i| T::constant(f64::from(i == axis)));
        let second = cross(along, helper);
        let second = times(second, T::constant(1.0) / length(second));
        let across = [cross(second, along), second];
        let half = chord / T::constant(2.0);
        let middle = times(plus(first, last), T::constant(0.5));
        let inner = &points[1..points.len() - 1];
        let own = |p: &Point<T>| {
            let arm = times(minus(*p, middle), T::constant(1.0) / half);
            [dot(arm, along), dot(arm, across[0]), dot(arm, across[1])]
        };
        let inner: Vec<[T; 3]> = inner.iter().map(own).collect();
        let w = minimum(&inner);
        let bulge = plus(times(across[0], w[0]), times(across[1], w[1]));
        let count = T::constant(inner.len() as f64);
        Self { chord, along, bulge, mean_square: T::constant(2.0) * objective(w, &inner) * half * half / count }
    }

    /// The bend tan(θ/4) without its rate; zero for a straight line.
    pub fn bend(&self) -> f64 {
        dot(self.bulge, self.bulge).value().sqrt()
    }

    /// Arc length L (1 + W²) atan(W)/W \[m\].
    pub fn length(&self) -> T {
        let square = dot(self.bulge, self.bulge);
        // The series has an error of 1e-18 here, and is differentiable at zero.
        let ratio = if square.value() < 1e-2 {
            let terms = (0..8).rev().map(|k| [1.0, -1.0][k % 2] / (2 * k + 1) as f64);
            terms.fold(T::constant(0.0), |sum, c| sum * square + T::constant(c))
        } else {
            let size = square.sqrt();
            size.atan2(T::constant(1.0)) / size
        };
        self.chord * (T::constant(1.0) + square) * ratio
    }

    /// Curvature 4 W/(L (1 + W²)) \[1/m\].
    pub fn curvature(&self) -> T {
        T::constant(4.0) * length(self.bulge) / (self.chord * (T::constant(1.0) + dot(self.bulge, self.bulge)))
    }

    /// Unit tangent at the first end (`sign` 1) or at the last end (−1).
    fn tangent(&self, sign: f64) -> Point<T> {
        let square = dot(self.bulge, self.bulge);
        let [one, two] = [1.0, 2.0 * sign].map(T::constant);
        let both = plus(times(self.along, one - square), times(self.bulge, two));
        times(both, one / (one + square))
    }

    /// Unit tangent at the first end.
    pub fn start(&self) -> Point<T> {
        self.tangent(1.0)
    }

    /// Transports a frame, given by its tangent and the direction of the plane angle 0, along the arc. Returns the plane angle \[rad\] and the frame at the
    /// last end.
    pub fn carry(&self, tangent: Point<T>, zero: Point<T>) -> (T, (Point<T>, Point<T>)) {
        let start = self.start();
        let zero = turned(start, self.along, turned(tangent, start, zero));
        // The centre lies opposite to the bulge.
        let inwards = self.bulge.map(|b| -b);
        let plane = dot(inwards, cross(self.along, zero)).atan2(dot(inwards, zero));
        let end = self.tangent(-1.0);
        (plane, (end, turned(self.along, end, zero)))
    }
}

/// The vector `v`, perpendicular to the unit vector `a`, after the shortest rotation of `a` to the unit vector `b`.
fn turned<T: Number>(a: Point<T>, b: Point<T>, v: Point<T>) -> Point<T> {
    minus(v, times(plus(a, b), dot(v, b) / (T::constant(1.0) + dot(a, b))))
}

/// Objective ½ Σ |d|² for points (x, u).
fn objective<T: Number>(w: [T; 2], points: &[[T; 3]]) -> T {
    let [half, one, two, four] = [0.5, 1.0, 2.0, 4.0].map(T::constant);
    let square = w[0] * w[0] + w[1] * w[1];
    let of_point = |p: &[T; 3]| {
        let [x, u, v] = *p;
        let s = u * w[0] + v * w[1];
        let b = one + two * s - square;
        let q = (b * b + four * square * x * x).sqrt();
        // (Q − B)/W² without cancellation
        let rest = if b.value() > 0.0 { four * x * x / (q + b) } else { (q - b) / square };
        let f = (two * (x * x - one) - two * s - s * rest) / (q + square + one);
        let (du, dv) = (u + f * w[0], v + f * w[1]);
        half * (du * du + dv * dv)
    };
    points.iter().fold(T::constant(0.0), |sum, p| sum + of_point(p))
}

/// Gradient of the objective with respect to w.
fn gradient<T: Number>(w: [T; 2], points: &[[T; 3]]) -> [T; 2] {
    let points: Vec<[Dual<T>; 3]> = points.iter().map(|p| p.map(Dual::fixed)).collect();
    let by = |i: usize| {
        let w = [0, 1].map(|j| if i == j { Dual::variable(w[j]) } else { Dual::fixed(w[j]) });
        objective(w, &points).rate
    };
    [by(0), by(1)]
}

/// Hessian of the objective with respect to w: [H₀₀, H₀₁, H₁₁].
fn hessian(w: [f64; 2], points: &[[f64; 3]]) -> [f64; 3] {
    let points: Vec<[Dual<f64>; 3]> = points.iter().map(|p| p.map(Dual::fixed)).collect();
    let by = |i: usize| {
        let w = [0, 1].map(|j| if i == j { Dual::variable(w[j]) } else { Dual::fixed(w[j]) });
        gradient(w, &points).map(|g| g.rate)
    };
    let ([a, b], [_, c]) = (by(0), by(1));
    [a, b, c]
}

/// The w that minimises the objective.
fn minimum<T: Number>(points: &[[T; 3]]) -> [T; 2] {
    let values: Vec<[f64; 3]> = points.iter().map(|p| p.map(T::value)).collect();
    let mut w = first_guess(&values);
    for _ in 0..100 {
        let (now, slope) = (objective(w, &values), gradient(w, &values));
        let step = solve(hessian(w, &values), slope);
        let descends = step[0] * slope[0] + step[1] * slope[1] > 0.0;
        let step = if descends { step } else { slope };
        let at = |share: f64| [w[0] - share * step[0], w[1] - share * step[1]];
        let shares = (0..40).map(|k| 0.5_f64.powi(k));
        // If no step length decreases the objective, the minimum is reached to rounding.
        let Some(share) = shares.into_iter().find(|&share| objective(at(share), &values) < now) else { break };
        w = at(share);
    }
    // The last step also carries the rates of the points.
    let slope = gradient(w.map(T::constant), points);
    let [a, b, c] = hessian(w, &values);
    let scale = T::constant(1.0 / (a * c - b * b));
    let [a, b, c] = [a, b, c].map(T::constant);
    let step = [(c * slope[0] - b * slope[1]) * scale, (a * slope[1] - b * slope[0]) * scale];
    [T::constant(w[0]) - step[0], T::constant(w[1]) - step[1]]
}

/// Solves for H⁻¹ g.
fn solve([a, b, c]: [f64; 3], g: [f64; 2]) -> [f64; 2] {
    let det = a * c - b * b;
    [(c * g[0] - b * g[1]) / det, (a * g[1] - b * g[0]) / det]
}

/// The w of the arc through the point nearest to the middle of the chord: with y = |u|, y W² + (1 − x² − y²) W = y.
fn first_guess(points: &[[f64; 3]]) -> [f64; 2] {
    let middle = points.iter().min_by(|a, b| a[0].abs().total_cmp(&b[0].abs()));
    let Some(&[x, u, v]) = middle else { return [0.0; 2] };
    let y = u.hypot(v);
    let d = 1.0 - x * x - y * y;
    let root = d.hypot(2.0 * y);
    // W/y, each form without cancellation on its side
    let ratio = if d > 0.0 { 2.0 / (d + root) } else { (root - d) / (2.0 * y * y) };
    [u * ratio, v * ratio]
}

fn plus<T: Number>(a: Point<T>, b: Point<T>) -> Point<T> {
    std::array::from_fn(|i| a[i] + b[i])
}

fn minus<T: Number>(a: Point<T>, b: Point<T>) -> Point<T> {
    std::array::from_fn(|i| a[i] - b[i])
}

fn times<T: Number>(a: Point<T>, by: T) -> Point<T> {
    a.map(|c| c * by)
}

fn dot<T: Number>(a: Point<T>, b: Point<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length<T: Number>(a: Point<T>) -> T {
    dot(a, a).sqrt()
}

fn cross<T: Number>(a: Point<T>, b: Point<T>) -> Point<T> {
    let c = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
    [c(1, 2), c(2, 0), c(0, 1)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::tensor::{Mat3, Vec3};
    use nalgebra::Rotation3;

    /// Unevenly spaced positions along an arc, as shares of its length.
    const SHARES: [f64; 6] = [0.0, 0.15, 0.31, 0.6, 0.72, 1.0];

    /// The point of an arc of length 1 that starts along z and bends by θ towards the direction φ from x, moved by a rotation and a translation.
    fn on_arc(turn: f64, plane: f64, share: f64) -> Vec3 {
        let [along, aside] = if turn == 0.0 {
            [share, 0.0]
        } else {
            [(turn * share).sin() / turn, 2.0 * (0.5 * turn * share).sin().powi(2) / turn]
        };
        Vec3::new(aside * plane.cos(), aside * plane.sin(), along)
    }

    fn turn() -> Mat3 {
        *Rotation3::from_scaled_axis(Vec3::new(0.4, -1.1, 0.7)).matrix()
    }

    /// Points of an arc of any angle and plane, rotated in space: length, curvature and plane are found to rounding, which a chord much shorter than the arc
    /// amplifies, and the residual is zero.
    #[test]
    fn arcs_of_any_angle_are_found() {
        for degrees in [0.0, 1e-6, 0.1, 30.0, 120.0, 179.0, 181.0, 270.0, 340.0] {
            for plane in [0.0, 1.0, -2.5] {
                let angle = f64::to_radians(degrees);
                let place = |share: &f64| (turn() * on_arc(angle, plane, *share) + Vec3::new(3.0, 1.0, -2.0)).into();
                let arc: Arc<f64> = Arc::fit(&SHARES.iter().map(place).collect::<Vec<_>>());
                let (found, _) = arc.carry((turn() * Vec3::z()).into(), (turn() * Vec3::x()).into());
                let off = (found - plane).abs();
                println!("{degrees}°: {:e} {:e} {off:e}", arc.length() - 1.0, arc.curvature() - angle);
                assert!((arc.length() - 1.0).abs() < 1e-12 && (arc.curvature() - angle).abs() < 1e-11, "{degrees}°");
                assert!(degrees < 0.05 || off < 1e-9, "{degrees}°: plane {found}, not {plane}");
                assert!(arc.mean_square.sqrt() < 1e-13);
            }
        }
    }

    /// Root mean square distance of points from the circle of an arc, computed from its centre and its axis.
    fn distance(points: &[Vec3], w: [f64; 2]) -> f64 {
        let middle = Vec3::new(0.0, w[0], w[1]);
        let size = middle.norm();
        let (n, axis) = (middle / size, Vec3::x().cross(&middle).normalize());
        let (radius, centre) = ((size * size + 1.0) / (2.0 * size), n * (size * size - 1.0) / (2.0 * size));
        let of_point = |p: &Vec3| {
            let arm = p - centre;
            let out = arm.dot(&axis);
            ((arm - axis * out).norm() - radius).powi(2) + out * out
        };
        (points.iter().map(of_point).sum::<f64>() / points.len() as f64).sqrt()
    }

    /// The formula of the distance agrees with that by centre and axis, and no neighbour of the fit is nearer to the points.
    #[test]
    fn the_fit_is_the_nearest_arc() {
        for (bend, noise) in [(0.05, 0.02), (0.6, 0.1), (1.7, 0.2)] {
            let points: Vec<Vec3> = (0..5)
                .map(|k| {
                    let a = f64::from(k);
                    let x = -0.7 + 0.35 * a;
                    Vec3::new(x, (1.0 - x * x) * bend + noise * (3.0 * a).sin(), noise * (2.0 * a + 1.0).cos())
                })
                .collect();
            let values: Vec<[f64; 3]> = points.iter().map(|p| (*p).into()).collect();
            let w = minimum(&values);
            let of = |w: [f64; 2]| (2.0 * objective(w, &values) / 5.0).sqrt();
            for other in [w, [0.3, -0.8], [1.5, 0.4], [-0.02, 0.01]] {
                assert!((of(other) - distance(&points, other)).abs() < 1e-12, "{other:?}");
            }
            for k in 0..12 {
                let (sin, cos) = (0.5 * f64::from(k)).sin_cos();
                assert!(of([w[0] + 1e-3 * cos, w[1] + 1e-3 * sin]) > of(w), "{w:?}, {k}");
            }
        }
    }

    /// Rates with respect to every coordinate of every point agree with central differences, whose error is 1e-9 of the largest rate with steps of 1e-5.
    #[test]
    fn rates_are_those_of_the_fit() {
        for angle in [0.3_f64, 2.0, 5.0] {
            let place = |(k, share): (usize, &f64)| {
                let off = 0.02 * Vec3::new((3.0 * k as f64).sin(), (5.0 * k as f64).cos(), 0.3);
                <[f64; 3]>::from(turn() * (on_arc(angle, 0.4, *share) + off))
            };
            let points: Vec<[f64; 3]> = SHARES.iter().enumerate().map(place).collect();
            let frame = [turn() * Vec3::z(), turn() * Vec3::x()].map(<[f64; 3]>::from);
            fn numbers<T: Number>(points: &[[T; 3]], frame: [[f64; 3]; 2]) -> [T; 4] {
                let (arc, [t, zero]) = (Arc::fit(points), frame.map(|v| v.map(T::constant)));
                [arc.length(), arc.curvature(), arc.carry(t, zero).0, arc.mean_square.sqrt()]
            }
            for (k, i) in (0..points.len()).flat_map(|k| [0, 1, 2].map(|i| (k, i))) {
                let mut moving: Vec<[Dual<f64>; 3]> = points.iter().map(|p| p.map(Dual::fixed)).collect();
                moving[k][i].rate = 1.0;
                let exact = numbers(&moving, frame).map(|n| n.rate);
                let at = |h: f64| {
                    let mut points = points.clone();
                    points[k][i] += h;
                    numbers(&points, frame)
                };
                let (above, below) = (at(1e-5), at(-1e-5));
                for (c, exact) in exact.iter().enumerate() {
                    let difference = (above[c] - below[c]) / 2e-5;
                    assert!(
                        (exact - difference).abs() < 1e-6 * exact.abs().max(1.0),
                        "{angle} {k} {i} {c}: {exact} {difference}"
                    );
                }
            }
        }
    }
}
