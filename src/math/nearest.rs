//! Closest points of a point and a triangle, and of two segments (Ericson, *Real-Time Collision Detection*, 2005, §5.1.5, §5.1.9).

use super::tensor::Vec3;

/// The part of a triangle that is nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nearest {
    Corner(usize),
    /// The side from this corner to the next
    Side(usize),
    Face,
}

/// The part of triangle abc that is nearest to p, with the barycentric weights of the closest point at the corners.
pub fn on_triangle(p: &Vec3, [a, b, c]: &[Vec3; 3]) -> (Nearest, [f64; 3]) {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(&(p - a)), ac.dot(&(p - a)));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (Nearest::Corner(0), [1.0, 0.0, 0.0]);
    }
    let (d3, d4) = (ab.dot(&(p - b)), ac.dot(&(p - b)));
    if d3 >= 0.0 && d4 <= d3 {
        return (Nearest::Corner(1), [0.0, 1.0, 0.0]);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return (Nearest::Side(0), [1.0 - t, t, 0.0]);
    }
    let (d5, d6) = (ab.dot(&(p - c)), ac.dot(&(p - c)));
    if d6 >= 0.0 && d5 <= d6 {
        return (Nearest::Corner(2), [0.0, 0.0, 1.0]);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return (Nearest::Side(2), [1.0 - t, 0.0, t]);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (Nearest::Side(1), [0.0, 1.0 - t, t]);
    }
    let sum = va + vb + vc;
    (Nearest::Face, [va / sum, vb / sum, vc / sum])
}

/// Parameter of the point of the segment ab that is closest to p: 0 at a, 1 at b.
pub fn on_segment(p: &Vec3, a: &Vec3, b: &Vec3) -> f64 {
    let along = b - a;
    let square = along.norm_squared();
    if square > 0.0 { (along.dot(&(p - a)) / square).clamp(0.0, 1.0) } else { 0.0 }
}

/// Parameters of the closest points of the segments ab and cd. At an end the parameter is exactly 0 or 1.
pub fn on_segments([a, b]: &[Vec3; 2], [c, d]: &[Vec3; 2]) -> [f64; 2] {
    let (u, v, w) = (b - a, d - c, a - c);
    let (uu, vv, uv) = (u.norm_squared(), v.norm_squared(), u.dot(&v));
    let apart = |s: f64, t: f64| (w + u * s - v * t).norm_squared();
    let determinant = uu * vv - uv * uv;
    if determinant > PARALLEL * uu * vv {
        let (s, t) = ((uv * v.dot(&w) - vv * u.dot(&w)) / determinant, (uu * v.dot(&w) - uv * u.dot(&w)) / determinant);
        if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
            return [s, t];
        }
    }
    // An end of one of the two is closest to the other
    let ends = [
        [0.0, on_segment(a, c, d)],
        [1.0, on_segment(b, c, d)],
        [on_segment(c, a, b), 0.0],
        [on_segment(d, a, b), 1.0],
    ];
    ends.into_iter().min_by(|p, q| apart(p[0], p[1]).total_cmp(&apart(q[0], q[1]))).unwrap_or([0.0; 2])
}

/// sin² of the angle below which segments count as parallel \[–\].
pub const PARALLEL: f64 = 1e-12;

/// The point of a triangle that is closest to a point.
pub fn closest_on_triangle(p: &Vec3, corners: &[Vec3; 3]) -> Vec3 {
    let (_, w) = on_triangle(p, corners);
    corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2]
}

/// Distance of a point from a triangle \[m\].
pub fn to_triangle(p: &Vec3, corners: &[Vec3; 3]) -> f64 {
    (p - closest_on_triangle(p, corners)).norm()
}

/// Distance of two segments \[m\].
pub fn between([a, b]: &[Vec3; 2], [c, d]: &[Vec3; 2]) -> f64 {
    let [s, t] = on_segments(&[*a, *b], &[*c, *d]);
    ((a + (b - a) * s) - (c + (d - c) * t)).norm()
}
