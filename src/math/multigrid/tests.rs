//! Blocks of linear tetrahedra, linear elasticity, E = 1: node positions off the grid by up to 15 % of its width, held at x = 0.

use super::*;
use crate::math::linear::{Definiteness, Factor, Linear, LinearError, Method};
use crate::math::low_rank::Pattern;
use crate::math::ordering::fill_reducing;
use crate::math::pcg::{Outcome, pcg};
use crate::math::random::SplitMix;
use crate::math::tensor::{Mat3, Vec3};
use crate::math::vector::{dot, norm};

struct Body {
    pattern: Arc<SymPattern>,
    values: Vec<f64>,
    places: Arc<Places>,
}

/// How the nodes at x = 0 are held.
#[derive(Clone, Copy, PartialEq)]
enum Hold {
    Clamped,
    /// u_x only, and what stops a rigid motion
    Rolling,
    Free,
}

fn block([nx, ny, nz]: [usize; 3], nu: f64, hold: Hold) -> Body {
    let node = |[i, j, k]: [usize; 3]| (i * (ny + 1) + j) * (nz + 1) + k;
    let boxes =
        |n: [usize; 3]| (0..n[0]).flat_map(move |i| (0..n[1]).flat_map(move |j| (0..n[2]).map(move |k| [i, j, k])));
    let mut random = SplitMix(3);
    let mut off = || 0.3 * (random.unit() - 0.5);
    let at: Vec<[usize; 3]> = boxes([nx + 1, ny + 1, nz + 1]).collect();
    let points: Vec<Vec3> = at.iter().map(|n| Vec3::from(n.map(|i| i as f64 + off()))).collect();
    let paths = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let cells: Vec<Vec<usize>> = boxes([nx, ny, nz])
        .flat_map(|corner| paths.map(|path| (corner, path)))
        .map(|(mut corner, path)| {
            let first = node(corner);
            std::iter::once(first)
                .chain(path.map(|d| {
                    corner[d] += 1;
                    node(corner)
                }))
                .collect()
        })
        .collect();
    let pairs = |list: &[usize]| {
        let list = list.to_vec();
        (0..list.len()).flat_map(move |a| {
            let list = list.clone();
            (0..a).map(move |b| (list[a] as u32, list[b] as u32))
        })
    };
    let graph = SymPattern::from_pairs(points.len(), cells.iter().flat_map(|c| pairs(c)));
    let held = |n: usize, c: usize| match hold {
        Hold::Clamped => at[n][0] == 0,
        Hold::Rolling => at[n][0] == 0 && (c == 0 || at[n] == [0, 0, 0] || (c == 2 && at[n] == [0, 1, 0])),
        Hold::Free => false,
    };
    let (mut equation, mut dofs) = (vec![usize::MAX; 3 * points.len()], Vec::new());
    for n in fill_reducing(&graph) {
        for c in (0..3).filter(|&c| !held(n as usize, c)) {
            equation[3 * n as usize + c] = dofs.len();
            dofs.push(3 * n + c as u32);
        }
    }
    let equations: Vec<Vec<usize>> = cells
        .iter()
        .map(|c| c.iter().flat_map(|n| (0..3).map(move |k| 3 * n + k)).map(|dof| equation[dof]).collect())
        .collect();
    let free = |list: &Vec<usize>| pairs(&list.iter().copied().filter(|&e| e != usize::MAX).collect::<Vec<_>>());
    let pattern = SymPattern::from_pairs(dofs.len(), equations.iter().flat_map(free));
    let mut values = vec![0.0; pattern.nnz()];
    let (mu, lambda) = (0.5 / (1.0 + nu), nu / ((1.0 + nu) * (1.0 - 2.0 * nu)));
    for (cell, e) in cells.iter().zip(&equations) {
        let edge = |k: usize| points[cell[k]] - points[cell[0]];
        let edges = Mat3::from_columns(&[edge(1), edge(2), edge(3)]);
        let rows = edges.try_inverse().expect("a cell has a volume");
        let mut g = [Vec3::zeros(); 4];
        (0..3).for_each(|k| g[k + 1] = rows.row(k).transpose());
        g[0] = -(g[1] + g[2] + g[3]);
        let volume = edges.determinant().abs() / 6.0;
        for (p, q) in (0..12).flat_map(|p| (0..12).map(move |q| (p, q))) {
            let ([a, i], [b, j]) = ([p / 3, p % 3], [q / 3, q % 3]);
            if e[p] == usize::MAX || e[q] == usize::MAX || e[q] > e[p] {
                continue;
            }
            let same = if i == j { mu * g[a].dot(&g[b]) } else { 0.0 };
            let slot = pattern.slot(e[p] as u32, e[q] as u32).expect("a pair of a cell");
            values[slot as usize] += volume * (lambda * g[a][i] * g[b][j] + mu * g[a][j] * g[b][i] + same);
        }
    }
    Body { pattern: pattern.into(), values, places: Places { dofs, points }.into() }
}

impl Body {
    /// As the linear solver takes it
    fn whole(&self) -> Arc<Pattern> {
        Pattern::from((*self.pattern).clone()).into()
    }

    fn hierarchy(&self) -> Multigrid {
        let mut multigrid = Multigrid::new(self.pattern.clone(), self.places.clone());
        multigrid.set_up(&self.values, &[], BottomFactor::Definite).expect("held bodies are stable");
        multigrid
    }

    fn method(&self, factor_memory: f64) -> Method {
        Method { linear: Linear::Iterative, factor_memory, places: Ok(self.places.clone()) }
    }

    fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        self.pattern.multiply(&self.values, x, &mut y);
        y
    }

    /// Iterations under its own weight, to 1e-9.
    fn iterations(&self) -> usize {
        let multigrid = self.hierarchy();
        let weight: Vec<f64> = self.places.dofs.iter().map(|dof| if dof % 3 == 2 { -1.0 } else { 0.0 }).collect();
        let precondition = |r: &[f64]| {
            let mut z = r.to_vec();
            multigrid.apply(&mut z);
            z
        };
        let (outcome, iterations) = pcg(|v| self.times(v), precondition, &weight, 1e-9 * norm(&weight), 500);
        assert!(matches!(outcome, Outcome::Solved(_)), "{outcome:?}");
        iterations
    }
}

fn random(n: usize, seed: u64) -> Vec<f64> {
    let mut random = SplitMix(seed);
    (0..n).map(|_| random.unit() - 0.5).collect()
}

/// The blocks are the matrix, with ones where a component is held.
#[test]
fn blocks_are_the_matrix() {
    let body = block([3, 2, 2], 0.3, Hold::Rolling);
    let nodal = Nodal::new(&body.pattern, &body.places);
    let a = nodal.matrix(&body.pattern, &body.values);
    let x = random(body.pattern.n, 1);
    let blocks = nodal.gather(&x);
    let product: Vec<[f64; 3]> = (0..a.rows()).map(|i| a.row_times(i, &blocks)).collect();
    let mut y = vec![0.0; x.len()];
    nodal.scatter(&product, &mut y);
    // Sums of some fifty products of numbers below 2.
    assert!(y.iter().zip(body.times(&x)).all(|(y, z)| (y - z).abs() < 1e-13));
    let held = (0..a.rows())
        .flat_map(|i| (0..3).map(move |c| (i, c)))
        .filter(|&(i, c)| a.values[a.diagonal(i)][c][c] == 1.0 && a.row_times(i, &blocks)[c] == 0.0);
    assert_eq!(held.count(), 3 * a.rows() - body.pattern.n);
}

/// P₀ R = B to the rounding of an orthogonalisation, and P R = B where A B = 0, here of a free body. Numbers are below 1.
#[test]
fn rigid_motions_are_in_the_range() {
    let body = block([6, 5, 4], 0.3, Hold::Free);
    let a = Nodal::new(&body.pattern, &body.places).matrix(&body.pattern, &body.values);
    let modes = body.places.rigid_modes(&[]);
    for k in 0..6 {
        let motion: Vec<[f64; 3]> = modes.iter().map(|m| m[k]).collect();
        assert!((0..a.rows()).all(|i| a.row_times(i, &motion).iter().all(|f| f.abs() < 1e-13)), "motion {k} is rigid");
        assert!(motion.iter().flatten().any(|u| u.abs() > 0.1), "motion {k} is one");
    }
    let (group, groups) = aggregate(&a, STRONG);
    let (p, next) = tentative(&modes, &group, groups);
    let smooth = smoothed(&a, &inverses(&a, &vec![[0.0; 3]; a.rows()]).expect("positive"), &p, 0.7);
    for (p, bound) in [(p, 1e-14), (smooth, 1e-13)] {
        for k in 0..6 {
            let coarse: Vec<[f64; 6]> = next.iter().map(|m| m[k]).collect();
            for (i, m) in modes.iter().enumerate() {
                let image = p.row_times(i, &coarse);
                assert!(image.iter().zip(&m[k]).all(|(a, b)| (a - b).abs() < bound), "motion {k}, node {i}");
            }
        }
    }
}

/// Columns of P₀ are orthonormal, those that a group of less than three nodes has not are zero.
#[test]
fn tentative_columns_are_orthonormal_or_absent() {
    let body = block([2, 2, 2], 0.3, Hold::Free);
    let modes = body.places.rigid_modes(&[]);
    // Groups of one node, of two, and of the rest.
    let group: Vec<u32> = (0..modes.len() as u32).map(|i| [0, 1, 1].get(i as usize).copied().unwrap_or(2)).collect();
    let (p, next) = tentative(&modes, &group, 3);
    let rank = |g: usize| (0..6).filter(|&k| next[g][k][k] > 0.0).count();
    assert_eq!([rank(0), rank(1), rank(2)], [3, 5, 6]);
    let gram = p.transposed().times(&p);
    for (g, next) in next.iter().enumerate() {
        let block = gram.values[gram.diagonal(g)];
        for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
            let expected = if i == j && next[i][i] > 0.0 { 1.0 } else { 0.0 };
            assert!((block[i][j] - expected).abs() < 1e-14, "group {g}: {i}, {j}");
        }
    }
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
        let multigrid = body.hierarchy();
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
    let count = |nu: f64| sizes.map(|size| block(size, nu, Hold::Clamped).iterations());
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
    let (x, direct) = solve(Factor::new(body.whole()));
    let (y, iterative) = solve(Factor::by(body.method(1.0), body.whole(), Definiteness::Positive));
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
    let mut direct = Factor::new(body.whole());
    direct.factorise(&shifted).expect("regular");
    let mut expected = load.clone();
    direct.solve(&shifted, &mut expected).expect("accurate");
    assert!(direct.negative_eigenvalues > 0);
    let mut factor = Factor::by(body.method(1.0), body.whole(), Definiteness::Positive);
    factor.factorise(&shifted).expect("a hierarchy or a factor");
    let mut x = load.clone();
    factor.solve(&shifted, &mut x).expect("a factor");
    assert!(factor.fell_back() && factor.has_inertia());
    assert_eq!((factor.negative_eigenvalues, factor.fallbacks), (direct.negative_eigenvalues, 1));
    assert_eq!(x, expected);
    factor.factorise(&body.values).expect("stable");
    assert!(!factor.fell_back());
    let mut poor = Factor::by(body.method(1e-6), body.whole(), Definiteness::Positive);
    let result = poor.factorise(&shifted).and_then(|()| poor.solve(&shifted, &mut load.clone()));
    assert!(matches!(result, Err(LinearError::Indefinite { gigabytes }) if gigabytes > 1e-6), "{result:?}");
}

/// By counts: the factor of this block has 0.02 GB, and takes some thousand operations an entry of the matrix.
#[test]
fn the_path_is_chosen_by_counts() {
    let body = block([8, 8, 8], 0.3, Hold::Clamped);
    let by = |linear, factor_memory| {
        let method = Method { linear, ..body.method(factor_memory) };
        let factor = Factor::by(method, body.whole(), Definiteness::Positive);
        (factor.multigrid().is_some(), factor.why)
    };
    assert_eq!(by(Linear::Iterative, 1.0), (true, "asked for".into()));
    assert_eq!(by(Linear::Direct, 1.0), (false, "asked for".into()));
    let (iterative, why) = by(Linear::Auto, 1.0);
    assert!(!iterative && why.starts_with("a factor of 0.00"), "{why}");
    let (iterative, why) = by(Linear::Auto, 1e-3);
    assert!(iterative && why.ends_with("more than factor_memory = 0.001 GB"), "{why}");
    let mut large =
        Factor::by(Method { linear: Linear::Direct, ..body.method(1e-3) }, body.whole(), Definiteness::Positive);
    assert!(matches!(large.factorise(&body.values), Err(LinearError::TooLarge { gigabytes }) if gigabytes > 1e-3));
}
