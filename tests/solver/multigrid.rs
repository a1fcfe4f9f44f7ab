//! The hierarchy as a preconditioner, and the linear solver that takes it or a factor: blocks of `common/elastic_block.rs`.

use crate::common::elastic_block::{Body, Hold, block, random};
use durometer::math::linear::{Definiteness, Factor, Linear, LinearError, Method};
use durometer::math::low_rank::Pattern;
use durometer::math::multigrid::{BottomFactor, Multigrid};
use durometer::math::pcg::{Outcome, pcg};
use durometer::math::vector::{dot, norm};
use std::sync::Arc;

/// As the linear solver takes it
fn whole(body: &Body) -> Arc<Pattern> {
    Pattern::from((*body.pattern).clone()).into()
}

fn hierarchy(body: &Body) -> Multigrid {
    let mut multigrid = Multigrid::new(body.pattern.clone(), body.places.clone());
    multigrid.set_up(&body.values, &[], BottomFactor::Definite).expect("held bodies are stable");
    multigrid
}

fn method(body: &Body, factor_memory: f64) -> Method {
    Method { linear: Linear::Iterative, factor_memory, places: Ok(body.places.clone()) }
}

/// Iterations under its own weight, to 1e-9.
fn iterations(body: &Body) -> usize {
    let multigrid = hierarchy(body);
    let weight: Vec<f64> = body.places.dofs.iter().map(|dof| if dof % 3 == 2 { -1.0 } else { 0.0 }).collect();
    let precondition = |r: &[f64]| {
        let mut z = r.to_vec();
        multigrid.apply(&mut z);
        z
    };
    let (outcome, iterations) = pcg(|v| body.times(v), precondition, &weight, 1e-9 * norm(&weight), 500);
    assert!(matches!(outcome, Outcome::Solved(_)), "{outcome:?}");
    iterations
}

/// ⟨M⁻¹u, v⟩ = ⟨u, M⁻¹v⟩ and ⟨M⁻¹u, u⟩ > 0: conjugate gradients need both. The inverse of a matrix of condition 1e4 is rounded by
/// some 1e-12 of its size.
#[test]
fn hierarchies_are_symmetric_and_definite() {
    // The last body is in several parts.
    let bodies = [
        ([7, 7, 7], Hold::Clamped),
        ([40, 3, 3], Hold::Rolling),
        ([1, 1, 1], Hold::Clamped),
        ([18, 18, 18], Hold::Clamped),
    ];
    for (size, hold) in bodies {
        let body = block(size, 0.4, hold);
        let multigrid = hierarchy(&body);
        let n = body.pattern.n;
        let solved = |v: &[f64]| {
            let mut z = v.to_vec();
            multigrid.apply(&mut z);
            z
        };
        let (u, v) = (random(n, 1), random(n, 2));
        let (mu, mv) = (solved(&u), solved(&v));
        assert!((dot(&mu, &v) - dot(&u, &mv)).abs() < 1e-11 * norm(&mu) * norm(&v), "{size:?}");
        assert!(dot(&mu, &u) > 0.0);
    }
}

/// Iterations are bounded however fine the mesh is: cubes of 6³ to 18³ boxes and bars eight times as long as thick. Measured: 16, 16,
/// 19, 19, 21, and at ν = 0.49 58, 57, 65, 61, 67; a tenth more is the room for another order of the nodes.
#[test]
fn iterations_do_not_grow_with_the_mesh() {
    let sizes = [[6, 6, 6], [10, 10, 10], [18, 18, 18], [32, 4, 4], [64, 8, 8]];
    let count = |nu: f64| sizes.map(|size| iterations(&block(size, nu, Hold::Clamped)));
    let (soft, hard) = (count(0.3), count(0.49));
    assert!(soft.iter().all(|&n| n <= 23), "{soft:?}");
    // Linear tetrahedra lock near incompressibility: the cost is a factor of three to four.
    assert!(hard.iter().all(|&n| n <= 75), "{hard:?}");
}

/// Modes about the current positions: a body that is rotated by 90° needs the modes of its position, and then as many iterations as before.
#[test]
fn motions_are_those_of_the_place() {
    let body = block([24, 3, 3], 0.3, Hold::Clamped);
    // Rotated about z: x′ = −y, y′ = x; tangents rotate with the body.
    let turned: Vec<f64> = body.places.points.iter().flat_map(|p| [-p.y - p.x, p.x - p.y, 0.0]).collect();
    let modes = body.places.rigid_modes(&turned);
    let still = body.places.rigid_modes(&[]);
    // e_z × (x − x̄) of the rotated body is the rotated field.
    for (m, s) in modes.iter().zip(&still).skip(200) {
        let field = [-s[5][1], s[5][0], s[5][2]];
        assert!(field.iter().zip(m[5]).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}

/// The direct factor and the iterative path have the same answer to 1e-9 of the load times the condition, some 1e4, and conjugate
/// gradients say how many they took.
#[test]
fn both_paths_have_the_same_answer() {
    let body = block([16, 4, 4], 0.4, Hold::Rolling);
    let load = random(2 * body.pattern.n, 5);
    let solve = |mut factor: Factor| {
        factor.factorise(&body.values).expect("stable");
        let mut x = load.clone();
        factor.solve(&body.values, &mut x).expect("accurate");
        (x, factor)
    };
    let (x, direct) = solve(Factor::new(whole(&body)));
    let (y, iterative) = solve(Factor::by(method(&body, 1.0), whole(&body), Definiteness::Positive));
    let apart: Vec<f64> = x.iter().zip(&y).map(|(x, y)| x - y).collect();
    assert!(norm(&apart) < 1e-6 * norm(&x), "{:e}", norm(&apart) / norm(&x));
    assert!(direct.has_inertia() && !iterative.has_inertia() && !iterative.fell_back());
    assert_eq!(iterative.gradients.solves, 2);
    // Both are counted: two right sides, of which the second does not begin with the first.
    assert!((10..=2 * 40).contains(&iterative.gradients.iterations), "{:?}", iterative.gradients);
    assert_eq!(iterative.multigrid().expect("iterative").size.levels, 2);
}

/// K − σ diag K is indefinite: this matrix is factorised, its negative eigenvalues counted, and the next one is solved iteratively again.
/// Without the memory it is an error that reports it.
#[test]
fn negative_curvature_is_factorised() {
    let body = block([12, 3, 3], 0.3, Hold::Clamped);
    let mut shifted = body.values.clone();
    for j in 0..body.pattern.n {
        shifted[body.pattern.col_ptr[j] as usize] *= 1.0 - 0.05;
    }
    let load = random(body.pattern.n, 5);
    let mut direct = Factor::new(whole(&body));
    direct.factorise(&shifted).expect("regular");
    let mut expected = load.clone();
    direct.solve(&shifted, &mut expected).expect("accurate");
    assert!(direct.negative_eigenvalues > 0);
    let mut factor = Factor::by(method(&body, 1.0), whole(&body), Definiteness::Positive);
    factor.factorise(&shifted).expect("a hierarchy or a factor");
    let mut x = load.clone();
    factor.solve(&shifted, &mut x).expect("a factor");
    assert!(factor.fell_back() && factor.has_inertia());
    assert_eq!((factor.negative_eigenvalues, factor.fallbacks), (direct.negative_eigenvalues, 1));
    assert_eq!(x, expected);
    factor.factorise(&body.values).expect("stable");
    assert!(!factor.fell_back());
    let mut poor = Factor::by(method(&body, 1e-6), whole(&body), Definiteness::Positive);
    let result = poor.factorise(&shifted).and_then(|()| poor.solve(&shifted, &mut load.clone()));
    assert!(matches!(result, Err(LinearError::Indefinite { gigabytes }) if gigabytes > 1e-6), "{result:?}");
}

/// By counts: the factor of this block has 0.02 GB, and takes some thousand operations an entry of the matrix.
#[test]
fn the_path_is_chosen_by_counts() {
    let body = block([8, 8, 8], 0.3, Hold::Clamped);
    let by = |linear, factor_memory| {
        let method = Method { linear, ..method(&body, factor_memory) };
        let factor = Factor::by(method, whole(&body), Definiteness::Positive);
        (factor.multigrid().is_some(), factor.why)
    };
    assert_eq!(by(Linear::Iterative, 1.0), (true, "asked for".into()));
    assert_eq!(by(Linear::Direct, 1.0), (false, "asked for".into()));
    let (iterative, why) = by(Linear::Auto, 1.0);
    assert!(!iterative && why.starts_with("a factor of 0.00"), "{why}");
    let (iterative, why) = by(Linear::Auto, 1e-3);
    assert!(iterative && why.ends_with("more than factor_memory = 0.001 GB"), "{why}");
    let mut large =
        Factor::by(Method { linear: Linear::Direct, ..method(&body, 1e-3) }, whole(&body), Definiteness::Positive);
    assert!(matches!(large.factorise(&body.values), Err(LinearError::TooLarge { gigabytes }) if gigabytes > 1e-3));
}
