//! Contact of two deformable surfaces, or of one with itself: points against triangles and edges against edges, all of them moving.
//!
//! ```text
//! Π = ½ Σ_q W_q Σ_f c_qf b(d_qf) + Σ_ee′ w_ee′ m(|u × v|²) b(d_ee′)
//! ```
//!
//! The points of either surface interact with the features f of the other: c = 1 for triangles, −1 for edges between two triangles, 1 for corners
//! surrounded by triangles, so that a point over a flat or convex surface feels one distance, not one per triangle. Terms with the same nearest
//! feature are combined first. Each surface contributes half of the pressure.
//!
//! Edges are guards: w is a hundredth of their area where a surface is flat, and the full area where both are sharp; m(c) = 2c/ε − c²/ε² for c < ε
//! makes the terms of parallel edges vanish smoothly (Li et al., Incremental potential contact, ACM TOG 39, 2020,
//! §5.2, ε a thousandth of |u|²|v|² at rest). Weights by area and the sum over features are those of Li et al., Convergent
//! incremental potential contact (2023). Detection along the step is additive (Li, Kaufman & Jiang 2021, §4).
//!
//! Candidates are kept until the motion has used up their margin; they affect only the cost, never the result. Limits: parts that share a node do not
//! interact. For the points of the other surface, a curved facet consists of four flat triangles.

mod candidates;
pub mod friction;
mod motion;
mod pair;
mod pair_distance;
pub mod pressed;
mod search;
pub mod surface;
mod terms;

pub use motion::max_step;
pub use pair::Surfaces;
pub use pair_distance::PairDistance;
pub use terms::Term;
