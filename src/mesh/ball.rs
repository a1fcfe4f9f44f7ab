//! Balls of material inside a mesh, defined by a smooth weight function.
//!
//! A ball of radius R around c moves with the weights w_i = ∫ b(|X − c|) (α + β·(X − c)) N_i dV over the part of the ball inside the body, b(r) = (1
//! − r²/R²)². α and β are chosen such that Σ w_i = 1 and Σ w_i X_i = c, so that the mean Σ w_i x_i follows every affine motion of the body exactly as
//! the material point c does; as h → 0 the weights tend to a fixed density, and the displacement that is work-conjugate to a force on the ball
//! remains finite (that of a point force does not).

use super::element::{CELL_EDGES, CELL_NODES, cell_gradients, cell_shape};
use super::embed::{EmbedError, cell_bounds, distance_to_surface, embed};
use super::file::validate::split;
use super::made::parts::parts;
use super::{Order, TetMesh, quadrature};
use crate::math::tensor::Vec3;
use crate::math::threads;
use nalgebra::{Matrix3, Matrix4, RowVector3, RowVector4, Vector4};
use std::collections::BTreeMap;

/// Smallest filled share of a ball, weighted by b, at which the body surrounds a point outside it \[–\].
const FILLED: f64 = 0.05;
/// Largest distance of the centroid of the filled part from the centre, relative to the radius \[–\]; at a flat wall it is 35/128 = 0.27.
const CENTRED: f64 = 0.2;
/// Smallest radius of a ball, relative to the diagonal of the body \[–\].
const SMALLEST: f64 = 1e-6;
/// Ratio of the longest to the shortest edge above which a part of a cell is bisected across its longest edge instead of split into eight \[–\]: the
/// number of parts then depends on the ball, not on the slenderness of the cell.
const SLENDER: f64 = 8.0;
/// Largest number of parts of one cell; a cell with edges of the size of the radius has a few thousand.
const MOST_PARTS: usize = 1_000_000;
/// Number of cells that one thread handles at a time.
const CELLS: usize = 16;

/// Returns the weights (node, w_i) of the ball of `radius` \[m\] around `center` \[m\], in ascending order of nodes; the module documentation defines
/// them. The centre may be outside the body as long as the ball intersects it: use [`embed`] to check a centre that must be inside. Of several
/// bodies, the one that contains the centre is used, or else the one with the nearest cell.
pub fn ball_weights(mesh: &TetMesh, center: Vec3, radius: f64) -> Result<Vec<(u32, f64)>, EmbedError> {
    let (moments, nodes) = ball_moments(mesh, center, radius)?;
    weights(&moments, &nodes, radius).ok_or_else(|| EmbedError::EmptyBall {
        at: center,
        radius,
        distance: distance_to_surface(mesh, center),
    })
}

/// Whether the body surrounds a point outside it, such as a point on the axis of a bore, within `radius` \[m\]: the ball is filled sufficiently and
/// evenly.
pub fn is_surrounded(mesh: &TetMesh, center: Vec3, radius: f64) -> bool {
    ball_moments(mesh, center, radius).is_ok_and(|(moments, _)| {
        let (mass, first) = (moments[(0, 0)], moments.fixed_view::<3, 1>(1, 0).norm());
        mass >= FILLED * whole_ball(radius) && first <= CENTRED * mass
    })
}

/// Returns the moments of the ball of `radius` \[m\] around `center` \[m\], in total and for each node.
fn ball_moments(mesh: &TetMesh, center: Vec3, radius: f64) -> Result<(Matrix4<f64>, NodeMoments), EmbedError> {
    let across = mesh.diagonal();
    if radius < SMALLEST * across {
        return Err(EmbedError::SmallBall { at: center, radius, across });
    }
    let ball = Ball { mesh, center, radius, rule: quadrature::tet(5) };
    let near = |c: &usize| {
        let (low, high) = cell_bounds(mesh, *c);
        (center.sup(&low).inf(&high) - center).norm() < radius
    };
    let cells: Vec<usize> = of_one_part(mesh, center, (0..mesh.cell_count()).filter(near).collect());
    let of_part = |part: &[usize]| part.iter().map(|&c| ball.cell(c)).collect::<Option<Vec<_>>>();
    let parts: Option<Vec<Vec<Moments>>> = threads::map(cells.chunks(CELLS).collect(), of_part).into_iter().collect();
    let parts = parts.ok_or(EmbedError::SlenderCell { at: center, radius })?;
    // Summed in the order of cells: bitwise identical for any number of threads.
    let mut moments = Matrix4::zeros();
    let mut nodes = NodeMoments::new();
    for (&c, part) in cells.iter().zip(parts.iter().flatten()) {
        moments += part.whole;
        for (&node, sum) in mesh.cell(c).iter().zip(&part.nodes).filter(|(_, sum)| sum[0] != 0.0) {
            *nodes.entry(node).or_default() += sum;
        }
    }
    Ok((moments, nodes))
}

/// ∫ b dV over a whole ball \[m³\].
fn whole_ball(radius: f64) -> f64 {
    32.0 * std::f64::consts::PI / 105.0 * radius.powi(3)
}

/// Returns the cells that belong to the body around `center`.
fn of_one_part(mesh: &TetMesh, center: Vec3, cells: Vec<usize>) -> Vec<usize> {
    let parts = parts(mesh);
    let Some(&first) = cells.first() else { return cells };
    if cells.iter().all(|&c| parts[c] == parts[first]) {
        return cells;
    }
    let away = |c: &usize| (mesh.position(*c, [0.25; 3]) - center).norm();
    let nearest = || cells.iter().copied().min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(first);
    let home = parts[embed(mesh, center).map_or_else(|_| nearest(), |e| e.cell as usize)];
    cells.into_iter().filter(|&c| parts[c] == home).collect()
}

/// Returns the weights, with (α, β) from Σ w_i = 1 and Σ w_i (X_i − c) = 0: because Σ N_i X_i = X these are rows of the moments.
fn weights(moments: &Matrix4<f64>, nodes: &NodeMoments, radius: f64) -> Option<Vec<(u32, f64)>> {
    let mass = moments[(0, 0)];
    // Less than a millionth of the whole ball counts as empty.
    if mass < 1e-6 * whole_ball(radius) {
        return None;
    }
    let solution = (moments / mass).lu().solve(&Vector4::new(1.0, 0.0, 0.0, 0.0))?;
    Some(nodes.iter().map(|(&node, n)| (node, n.dot(&solution) / mass)).collect())
}

/// ∫ b (1, y) N_i dV for the nodes of a ball.
type NodeMoments = BTreeMap<u32, Vector4<f64>>;

/// Integrals over a cell, with lengths in units of the radius: y = (X − c)/R.
#[derive(Default)]
struct Moments {
    /// ∫ b (1, y) ⊗ (1, y) dV
    whole: Matrix4<f64>,
    /// ∫ b (1, y) N_i dV
    nodes: [Vector4<f64>; 10],
    /// Number of parts so far
    parts: usize,
}

struct Ball<'a> {
    mesh: &'a TetMesh,
    center: Vec3,
    radius: f64,
    rule: quadrature::Rule<3>,
}

/// A cell in the coordinates of the ball, y = (X − c)/R.
struct Seen {
    /// y of the nodes; only the first four are used for a linear cell
    nodes: [Vec3; 10],
    /// Whether the edges are straight with their mid-nodes at the midpoints, so that the map is affine
    is_straight: bool,
}

/// Distance of a mid-node from the midpoint of its edge, relative to the length of the edge, up to which it is rounding in a file \[–\]
const STRAIGHT: f64 = 1e-8;

impl Seen {
    fn new(ball: &Ball, c: usize) -> Self {
        let mut nodes = [Vec3::zeros(); 10];
        for (y, &i) in nodes.iter_mut().zip(ball.mesh.cell(c)) {
            *y = (ball.mesh.points[i as usize] - ball.center) / ball.radius;
        }
        let is_halved = |(e, &[a, b]): (usize, &[usize; 2])| {
            (nodes[4 + e] - (nodes[a] + nodes[b]) / 2.0).norm() <= STRAIGHT * (nodes[a] - nodes[b]).norm()
        };
        let is_straight = ball.mesh.order == Order::Linear || CELL_EDGES.iter().enumerate().all(is_halved);
        Self { nodes, is_straight }
    }

    /// Returns y at a point.
    fn at(&self, xi: [f64; 3]) -> Vec3 {
        match self.is_straight {
            true => self.nodes[0] + self.edges() * Vec3::from(xi),
            false => self.nodes.iter().zip(cell_shape(Order::Quadratic, xi)).map(|(y, n)| y * n).sum(),
        }
    }

    /// Returns ∂y/∂ξ at a point; column j is the derivative with respect to ξ_j.
    fn jacobian(&self, xi: [f64; 3]) -> Matrix3<f64> {
        match self.is_straight {
            true => self.edges(),
            false => {
                self.nodes.iter().zip(cell_gradients(Order::Quadratic, xi)).map(|(y, g)| y * RowVector3::from(g)).sum()
            }
        }
    }

    /// Returns the edges from the first corner to the others.
    fn edges(&self) -> Matrix3<f64> {
        Matrix3::from_columns(&[1, 2, 3].map(|k| self.nodes[k] - self.nodes[0]))
    }

    /// Returns Σ N_i ⊗ (1, y_i) from sums over the nodes: with the actual node positions the weights follow affine motions exactly, whatever counts
    /// as straight.
    fn sum_of_nodes(&self, sums: &[Vector4<f64>; 10]) -> Matrix4<f64> {
        sums.iter().zip(&self.nodes).map(|(n, y)| n * RowVector4::new(1.0, y.x, y.y, y.z)).sum()
    }

    /// Distributes the sums among the corners of a cell with straight edges, whose shape functions are linear: (1, y) = Σ N_i (1, y_i).
    fn share_among_corners(&self, sum: &mut Moments) -> Option<()> {
        let corners = [0, 1, 2, 3].map(|k| self.nodes[k]);
        let rows = Matrix4::from_columns(&corners.map(|y| Vector4::new(1.0, y.x, y.y, y.z)));
        let nodes = rows.lu().solve(&sum.whole)?;
        for (k, node) in sum.nodes[..4].iter_mut().enumerate() {
            *node = nodes.row(k).transpose();
        }
        Some(())
    }
}

impl Ball<'_> {
    /// Returns the integrals over cell `c`; `None` if it needs too many parts, or is so slender that its volume is lost to rounding.
    fn cell(&self, c: usize) -> Option<Moments> {
        let (mut sum, seen) = (Moments::default(), Seen::new(self, c));
        self.add_part(&seen, &CELL_NODES[..4].try_into().expect("four corners"), &mut sum);
        if sum.parts > MOST_PARTS {
            return None;
        }
        match self.mesh.order {
            Order::Quadratic => sum.whole = seen.sum_of_nodes(&sum.nodes),
            Order::Linear if sum.whole[(0, 0)] > 0.0 => seen.share_among_corners(&mut sum)?,
            Order::Linear => {}
        }
        Some(sum)
    }

    /// Adds the part `xi` (corners in reference coordinates) of a cell, split until it is small: R/2 inside, where the integrand is smooth, R/3 at
    /// the sphere, where the second derivative of b is discontinuous (second moments are accurate to 1e-5).
    fn add_part(&self, seen: &Seen, xi: &[[f64; 3]; 4], sum: &mut Moments) {
        sum.parts += 1;
        if sum.parts > MOST_PARTS {
            return;
        }
        let corners = xi.map(|x| seen.at(x));
        let middle = corners.iter().sum::<Vec3>() / 4.0;
        let spread = corners.iter().map(|x| (x - middle).norm()).fold(0.0, f64::max);
        // All of the part lies within `reach` of its centre; the margin is larger if edges are curved.
        let reach = if seen.is_straight { spread } else { 1.5 * spread };
        if middle.norm() - reach >= 1.0 {
            return;
        }
        let lengths = CELL_EDGES.map(|[a, b]| (corners[a] - corners[b]).norm());
        let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
        let (longest, size) =
            CELL_EDGES.into_iter().zip(lengths).max_by(|a, b| a.1.total_cmp(&b.1)).expect("six edges");
        let enough = if middle.norm() + reach <= 1.0 { 1.0 / 2.0 } else { 1.0 / 3.0 };
        let halfway = |a: &[f64; 3], b: &[f64; 3]| std::array::from_fn(|d| (a[d] + b[d]) / 2.0);
        if size > enough && size > SLENDER * shortest {
            for [kept, moved] in [longest, [longest[1], longest[0]]] {
                let mut part = *xi;
                part[moved] = halfway(&xi[kept], &xi[moved]);
                self.add_part(seen, &part, sum);
            }
        } else if size > enough {
            for part in split(xi, halfway) {
                self.add_part(seen, &part, sum);
            }
        } else if self.mesh.order == Order::Linear {
            self.add_flat(&corners, sum);
        } else {
            self.add_quadratic(seen, xi, sum);
        }
    }

    /// Returns (1, y) and b dV at a quadrature point; `None` outside the ball.
    fn density(&self, y: Vec3, volume: f64) -> Option<(Vector4<f64>, f64)> {
        let gap = 1.0 - y.norm_squared();
        (gap > 0.0).then(|| (Vector4::new(1.0, y.x, y.y, y.z), gap * gap * volume))
    }

    /// Adds the integrals over a part with straight edges, except those of its nodes.
    fn add_flat(&self, corners: &[Vec3; 4], sum: &mut Moments) {
        let edges = Matrix3::from_columns(&[1, 2, 3].map(|k| corners[k] - corners[0]));
        let volume = edges.determinant() * self.radius.powi(3);
        for (&point, weight) in self.rule.points.iter().zip(&self.rule.weights) {
            if let Some((basis, mass)) = self.density(corners[0] + edges * Vec3::from(point), weight * volume) {
                sum.whole += basis * mass * basis.transpose();
            }
        }
    }

    /// Adds the integrals for the nodes over a part of a quadratic cell.
    fn add_quadratic(&self, seen: &Seen, xi: &[[f64; 3]; 4], sum: &mut Moments) {
        let edges = Matrix3::from_columns(&[1, 2, 3].map(|k| Vec3::from(xi[k]) - Vec3::from(xi[0])));
        let share = edges.determinant();
        for (&point, weight) in self.rule.points.iter().zip(&self.rule.weights) {
            let at: [f64; 3] = (Vec3::from(xi[0]) + edges * Vec3::from(point)).into();
            let volume = weight * share * seen.jacobian(at).determinant() * self.radius.powi(3);
            let Some((basis, mass)) = self.density(seen.at(at), volume) else { continue };
            let n = cell_shape(self.mesh.order, at);
            sum.nodes.iter_mut().zip(n).for_each(|(sum, n)| *sum += basis * (mass * n));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::larger;
    use crate::mesh::made::disturb::distort;
    use crate::mesh::made::structured::block;

    fn mean(mesh: &TetMesh, weights: &[(u32, f64)], f: impl Fn(&Vec3) -> f64) -> f64 {
        weights.iter().map(|&(i, w)| w * f(&mesh.points[i as usize])).sum()
    }

    #[test]
    fn points_and_balls_follow_affine_motions() {
        for order in [Order::Linear, Order::Quadratic] {
            let mut mesh = block(5, 4, 3, 0.05, 0.04, 0.03, order);
            distort(&mut mesh, 3, 0.15);
            let at = Vec3::new(0.0221, 0.0173, 0.0042);
            let point = embed(&mesh, at).expect("inside").weights;
            // The second ball is cut by the surface z = 0.
            for weights in [point, ball_weights(&mesh, at, 0.004).unwrap(), ball_weights(&mesh, at, 0.006).unwrap()] {
                assert!((mean(&mesh, &weights, |_| 1.0) - 1.0).abs() < 1e-12);
                for d in 0..3 {
                    assert!((mean(&mesh, &weights, |x| x[d]) - at[d]).abs() < 1e-12 * 0.05);
                }
                assert!(weights.windows(2).all(|w| w[0].0 < w[1].0 || weights.len() <= 10));
            }
        }
    }

    /// Linear and quadratic cells with the same corners and straight edges have the same weights if each mid-node adds half of its weight to each
    /// end, ξ_i = N_i + ½ Σ N of its edges. The rule for curved cells gives nearly the same result.
    #[test]
    fn straight_cells_have_the_weights_of_the_general_rule() {
        let mut linear = block(4, 3, 3, 0.05, 0.04, 0.03, Order::Linear);
        let mut quadratic = block(4, 3, 3, 0.05, 0.04, 0.03, Order::Quadratic);
        let place = |x: &Vec3| linear.points.iter().position(|p| (p - x).norm() < 1e-9);
        let corner: Vec<Option<usize>> = quadratic.points.iter().map(place).collect();
        let mut ends = BTreeMap::new();
        for c in 0..quadratic.cell_count() {
            let nodes = quadratic.cell(c);
            let of = |k: usize| corner[nodes[k] as usize].expect("a corner of both");
            ends.extend(CELL_EDGES.iter().enumerate().map(|(e, &[a, b])| (nodes[4 + e] as usize, [of(a), of(b)])));
        }
        distort(&mut linear, 5, 0.2);
        for (i, x) in quadratic.points.iter_mut().enumerate() {
            let [a, b] = corner[i].map_or_else(|| ends[&i], |k| [k, k]).map(|k| linear.points[k]);
            *x = (a + b) / 2.0;
        }
        let (center, radius) = (Vec3::new(0.021, 0.012, 0.004), 0.011);
        let difference = |quadratic: &TetMesh| {
            let mut left = vec![0.0; linear.points.len()];
            for (i, w) in ball_weights(quadratic, center, radius).expect("inside") {
                for k in corner[i as usize].map_or_else(|| ends[&(i as usize)], |k| [k, k]) {
                    left[k] += w / 2.0;
                }
            }
            for (i, w) in ball_weights(&linear, center, radius).expect("inside") {
                left[i as usize] -= w;
            }
            left.into_iter().fold(0.0, |most, w| larger(most, w.abs()))
        };
        let straight = difference(&quadratic);
        assert!(straight < 1e-13, "{straight:e}");
        // No cell counts as straight any more, and the cells have hardly moved.
        quadratic.points.iter_mut().enumerate().for_each(|(i, x)| x[i % 3] += 1e-9);
        let ball = Ball { mesh: &quadratic, center, radius, rule: quadrature::tet(5) };
        assert!((0..quadratic.cell_count()).all(|c| !Seen::new(&ball, c).is_straight));
        // Curved cells are split further, because their reach is taken to be one and a half times as large: second moments to 1e-5.
        let curved = difference(&quadratic);
        assert!((1e-13..1e-5).contains(&curved), "{curved:e}");
    }

    #[test]
    fn a_ball_outside_is_an_error_with_the_distance() {
        let mesh = block(2, 2, 2, 0.02, 0.02, 0.02, Order::Quadratic);
        let at = Vec3::new(0.023, 0.024, 0.01);
        assert!(ball_weights(&mesh, at, 0.0055).is_ok());
        let error = ball_weights(&mesh, at, 0.0045).expect_err("outside").to_string();
        assert!(error.contains("holds nothing of the body, whose surface is 5.0000 mm away"), "{error}");
    }
}
