//! Shape functions of tet4, tet10, tri3 and tri6 on the reference simplex, in VTK's node order.
//!
//! Reference cell: corners (0,0,0) (1,0,0) (0,1,0) (0,0,1), λ₀ = 1 − ξ − η − ζ. Corner functions of the quadratic elements are λ_i(2λ_i − 1),
//! mid-edge functions 4λ_iλ_j. Arrays have the size of the quadratic element; a linear element uses the first 4 (3) entries, and the rest are zero.

use super::Order;

/// Corners of the six edges of a cell; edge `e` carries the mid-node 4 + e.
pub const CELL_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// The four faces of a cell as local nodes in facet order (3 corners, 3 mid-nodes), outward by the right-hand rule.
pub const CELL_FACES: [[usize; 6]; 4] =
    [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]];

/// Corners of the three edges of a facet; edge `e` carries the mid-node 3 + e.
pub const FACET_EDGES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// Reference positions of the ten cell nodes.
pub const CELL_NODES: [[f64; 3]; 10] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.0, 0.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.0],
    [0.0, 0.0, 0.5],
    [0.5, 0.0, 0.5],
    [0.0, 0.5, 0.5],
];

/// Reference positions of the six facet nodes.
pub const FACET_NODES: [[f64; 2]; 6] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];

/// ∂λ_i/∂ξ_j of the cell's barycentric coordinates.
const CELL_LAMBDA: [[f64; 3]; 4] = [[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// ∂λ_i/∂ξ_j of the facet's barycentric coordinates.
const FACET_LAMBDA: [[f64; 2]; 3] = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];

/// Returns the shape functions N_i(ξ) of a cell.
pub fn cell_shape(order: Order, xi: [f64; 3]) -> [f64; 10] {
    let l = [1.0 - xi[0] - xi[1] - xi[2], xi[0], xi[1], xi[2]];
    let mut n = [0.0; 10];
    match order {
        Order::Linear => n[..4].copy_from_slice(&l),
        Order::Quadratic => {
            for i in 0..4 {
                n[i] = l[i] * (2.0 * l[i] - 1.0);
            }
            for (e, [i, j]) in CELL_EDGES.into_iter().enumerate() {
                n[4 + e] = 4.0 * l[i] * l[j];
            }
        }
    }
    n
}

/// Returns the derivatives ∂N_i/∂ξ_j of a cell.
pub fn cell_gradients(order: Order, xi: [f64; 3]) -> [[f64; 3]; 10] {
    let l = [1.0 - xi[0] - xi[1] - xi[2], xi[0], xi[1], xi[2]];
    let mut g = [[0.0; 3]; 10];
    match order {
        Order::Linear => g[..4].copy_from_slice(&CELL_LAMBDA),
        Order::Quadratic => {
            for d in 0..3 {
                for i in 0..4 {
                    g[i][d] = (4.0 * l[i] - 1.0) * CELL_LAMBDA[i][d];
                }
                for (e, [i, j]) in CELL_EDGES.into_iter().enumerate() {
                    g[4 + e][d] = 4.0 * (CELL_LAMBDA[i][d] * l[j] + l[i] * CELL_LAMBDA[j][d]);
                }
            }
        }
    }
    g
}

/// Returns the shape functions N_i(ξ) of a facet.
pub fn facet_shape(order: Order, xi: [f64; 2]) -> [f64; 6] {
    let l = [1.0 - xi[0] - xi[1], xi[0], xi[1]];
    let mut n = [0.0; 6];
    match order {
        Order::Linear => n[..3].copy_from_slice(&l),
        Order::Quadratic => {
            for i in 0..3 {
                n[i] = l[i] * (2.0 * l[i] - 1.0);
            }
            for (e, [i, j]) in FACET_EDGES.into_iter().enumerate() {
                n[3 + e] = 4.0 * l[i] * l[j];
            }
        }
    }
    n
}

/// Returns the derivatives ∂N_i/∂ξ_j of a facet.
pub fn facet_gradients(order: Order, xi: [f64; 2]) -> [[f64; 2]; 6] {
    let l = [1.0 - xi[0] - xi[1], xi[0], xi[1]];
    let mut g = [[0.0; 2]; 6];
    match order {
        Order::Linear => g[..3].copy_from_slice(&FACET_LAMBDA),
        Order::Quadratic => {
            for d in 0..2 {
                for i in 0..3 {
                    g[i][d] = (4.0 * l[i] - 1.0) * FACET_LAMBDA[i][d];
                }
                for (e, [i, j]) in FACET_EDGES.into_iter().enumerate() {
                    g[3 + e][d] = 4.0 * (FACET_LAMBDA[i][d] * l[j] + l[i] * FACET_LAMBDA[j][d]);
                }
            }
        }
    }
    g
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORDERS: [Order; 2] = [Order::Linear, Order::Quadratic];

    #[test]
    fn one_at_its_own_node_zero_at_the_others() {
        for order in ORDERS {
            for (i, &xi) in CELL_NODES.iter().enumerate().take(order.cell_nodes()) {
                for (j, n) in cell_shape(order, xi).into_iter().enumerate() {
                    assert_eq!(n, f64::from(u8::from(i == j)), "{order:?} cell: N_{j} at node {i}");
                }
            }
            for (i, &xi) in FACET_NODES.iter().enumerate().take(order.facet_nodes()) {
                for (j, n) in facet_shape(order, xi).into_iter().enumerate() {
                    assert_eq!(n, f64::from(u8::from(i == j)), "{order:?} facet: N_{j} at node {i}");
                }
            }
        }
    }

    #[test]
    fn sum_to_one_and_gradients_agree_with_differences() {
        // Central differences are exact for quadratics: the remaining error is rounding / 2e.
        let (e, tol) = (1e-3, 1e-12);
        let (x3, x2) = ([0.17, 0.31, 0.23], [0.29, 0.47]);
        for order in ORDERS {
            assert!((cell_shape(order, x3).iter().sum::<f64>() - 1.0).abs() < 1e-15);
            assert!((facet_shape(order, x2).iter().sum::<f64>() - 1.0).abs() < 1e-15);
            for d in 0..3 {
                let at = |s: f64| cell_shape(order, std::array::from_fn(|k| if k == d { x3[k] + s } else { x3[k] }));
                let (up, down, g) = (at(e), at(-e), cell_gradients(order, x3));
                (0..10).for_each(|i| assert!(((up[i] - down[i]) / (2.0 * e) - g[i][d]).abs() < tol));
            }
            for d in 0..2 {
                let at = |s: f64| facet_shape(order, std::array::from_fn(|k| if k == d { x2[k] + s } else { x2[k] }));
                let (up, down, g) = (at(e), at(-e), facet_gradients(order, x2));
                (0..6).for_each(|i| assert!(((up[i] - down[i]) / (2.0 * e) - g[i][d]).abs() < tol));
            }
        }
    }

    #[test]
    fn faces_carry_the_mid_nodes_of_their_edges() {
        for face in CELL_FACES {
            for (e, [a, b]) in FACET_EDGES.into_iter().enumerate() {
                let edge = CELL_EDGES[face[3 + e] - 4];
                assert!(edge == [face[a], face[b]] || edge == [face[b], face[a]], "{face:?}, edge {e}");
            }
        }
    }
}
