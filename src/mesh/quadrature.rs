//! Quadrature on the reference tetrahedron (volume 1/6) and triangle (area 1/2). All weights are positive.
//!
//! Sources: tetrahedron degree 2, Hammer & Stroud (1956); degree 5 with 14 points, Walkington, *Quadrature on simplices of
//! arbitrary dimension* (2000); triangle degree 4 with
//! 6 points, Dunavant, IJNME 21 (1985) table II. Every rule is tested on all monomials up to its degree.

/// Points and weights in `D` dimensions; exact for polynomials up to `degree`.
#[derive(Clone, PartialEq, Debug)]
pub struct Rule<const D: usize> {
    pub degree: usize,
    /// \[points\] reference coordinates
    pub points: Vec<[f64; D]>,
    /// \[points\] weights, summing to the volume of the reference simplex
    pub weights: Vec<f64>,
}

impl<const D: usize> Rule<D> {
    fn new(degree: usize) -> Self {
        Self { degree, points: Vec::new(), weights: Vec::new() }
    }

    fn push(&mut self, point: [f64; D], weight: f64) {
        self.points.push(point);
        self.weights.push(weight);
    }
}

/// Returns the smallest rule on the tetrahedron that is exact to `degree` ≤ 5: 1, 4 or 14 points.
pub fn tet(degree: usize) -> Rule<3> {
    match degree {
        0 | 1 => {
            let mut rule = Rule::new(1);
            rule.push([0.25; 3], 1.0 / 6.0);
            rule
        }
        2 => {
            let mut rule = Rule::new(2);
            corners(&mut rule, 0.138_196_601_125_010_5, 1.0 / 24.0);
            rule
        }
        3..=5 => {
            let mut rule = Rule::new(5);
            corners(&mut rule, 0.310_885_919_263_300_6, 0.112_687_925_718_015_85 / 6.0);
            corners(&mut rule, 0.092_735_250_310_891_22, 0.073_493_043_116_361_95 / 6.0);
            let (a, w) = (0.045_503_704_125_649_65, 0.042_546_020_777_081_466 / 6.0);
            let b = 0.5 - a;
            for p in [[a, a, b], [a, b, a], [b, a, a], [a, b, b], [b, a, b], [b, b, a]] {
                rule.push(p, w);
            }
            rule
        }
        _ => panic!("no tetrahedron rule of degree {degree}: the highest is 5"),
    }
}

/// Adds the orbit (a, a, a, 1 − 3a) in barycentric coordinates.
fn corners(rule: &mut Rule<3>, a: f64, weight: f64) {
    let b = 1.0 - 3.0 * a;
    for p in [[a, a, a], [b, a, a], [a, b, a], [a, a, b]] {
        rule.push(p, weight);
    }
}

/// Returns the smallest rule on the triangle that is exact to `degree` ≤ 4: 1, 3 or 6 points.
pub fn tri(degree: usize) -> Rule<2> {
    let orbit = |rule: &mut Rule<2>, a: f64, weight: f64| {
        let b = 1.0 - 2.0 * a;
        for p in [[a, a], [b, a], [a, b]] {
            rule.push(p, weight);
        }
    };
    match degree {
        0 | 1 => {
            let mut rule = Rule::new(1);
            rule.push([1.0 / 3.0; 2], 0.5);
            rule
        }
        2 => {
            let mut rule = Rule::new(2);
            orbit(&mut rule, 1.0 / 6.0, 1.0 / 6.0);
            rule
        }
        3..=4 => {
            let mut rule = Rule::new(4);
            orbit(&mut rule, 0.445_948_490_915_964_9, 0.223_381_589_678_011_47 / 2.0);
            orbit(&mut rule, 0.091_576_213_509_770_74, 0.109_951_743_655_321_87 / 2.0);
            rule
        }
        _ => panic!("no triangle rule of degree {degree}: the highest is 4"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factorial(n: usize) -> f64 {
        (1..=n).map(|k| k as f64).product()
    }

    #[test]
    fn tetrahedron_rules_are_exact_to_their_degree() {
        for (degree, count) in [(1, 1), (2, 4), (5, 14)] {
            let rule = tet(degree);
            assert_eq!((rule.degree, rule.points.len()), (degree, count));
            assert!(rule.weights.iter().all(|w| *w > 0.0));
            for a in 0..=degree {
                for b in 0..=degree - a {
                    for c in 0..=degree - a - b {
                        let exact = factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3);
                        let sum: f64 = (rule.points.iter().zip(&rule.weights))
                            .map(|(p, w)| w * p[0].powi(a as i32) * p[1].powi(b as i32) * p[2].powi(c as i32))
                            .sum();
                        assert!((sum / exact - 1.0).abs() < 1e-13, "degree {degree}, x^{a} y^{b} z^{c}: {sum} {exact}");
                    }
                }
            }
        }
    }

    #[test]
    fn triangle_rules_are_exact_to_their_degree() {
        for (degree, count) in [(1, 1), (2, 3), (4, 6)] {
            let rule = tri(degree);
            assert_eq!((rule.degree, rule.points.len()), (degree, count));
            assert!(rule.weights.iter().all(|w| *w > 0.0));
            for a in 0..=degree {
                for b in 0..=degree - a {
                    let exact = factorial(a) * factorial(b) / factorial(a + b + 2);
                    let sum: f64 = (rule.points.iter().zip(&rule.weights))
                        .map(|(p, w)| w * p[0].powi(a as i32) * p[1].powi(b as i32))
                        .sum();
                    assert!((sum / exact - 1.0).abs() < 1e-13, "degree {degree}, x^{a} y^{b}: {sum} {exact}");
                }
            }
        }
    }
}
