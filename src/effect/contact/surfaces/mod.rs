//! Contact of two deformable surfaces, or of one with itself: points with triangles, and edges with edges, all of them moving.
//!
//! ```text
//! Π = ½ Σ_q W_q Σ_f c_qf b(d_qf) + Σ_ee′ w_ee′ m(|u × v|²) b(d_ee′)
//! ```
//!
//! The points of either surface meet the features f of the other: c = 1 on triangles, −1 on edges between two, 1 on corners that
//! triangles surround, so that a point over a flat or convex surface feels one distance, not one of each triangle. Terms of the same
//! nearest feature are added before anything else. Both surfaces carry half of the pressure.
//!
//! Edges are guards: w is a hundredth of their area where a surface is flat, and all of it where both are sharp;
//! m(c) = 2c/ε − c²/ε² for c < ε makes parallel ones vanish smoothly (Li et al., Incremental potential contact, ACM TOG 39, 2020,
//! §5.2, ε a thousandth of |u|²|v|² at rest). Weights by area and the sum over features are those of Li et al., Convergent
//! incremental potential contact (2023). Detection along the step is additive (Li, Kaufman & Jiang 2021, §4).
//!
//! Candidates are kept until the motion has used up their margin; what they are never decides what comes out.
//! Limits: parts that share a node do not meet. A curved facet is four flat triangles to the points of the other surface.

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
