//! Cook's membrane, nearly incompressible: the limit of the tip, and whether the pressure oscillates.

use crate::common::cook::{bent, rubber, tip};
use crate::common::formulation::{FORMULATIONS, Formulation, LOCKING_FREE, cell_pressures, label};
use durometer::mesh::{Order, TetMesh};

/// Three meshes whose sizes halve: observed order, Richardson's limit, and 6.93 within 1 %. The corner at (0, 44) is
/// singular, so the order is that of the singularity, between 1 and 2 for every element.
#[test]
fn the_tip_extrapolates_to_the_reference() {
    for (order, formulation) in LOCKING_FREE {
        let sizes = if order == Order::Linear { [8, 16, 32] } else { [4, 8, 16] };
        let [a, b, c] = sizes.map(|n| {
            let (mesh, x) = bent(n, order, formulation, false);
            tip(&mesh, &x)
        });
        let p = ((b - a) / (c - b)).log2();
        let limit = c + (c - b) / (p.exp2() - 1.0);
        let name = label(order, formulation);
        println!("Cook {name}: {a:.4} {b:.4} {c:.4} at n = {sizes:?}, order {p:.2}, limit {limit:.4}");
        assert!((1.0..=2.1).contains(&p), "{name}: order {p}");
        assert!((limit / 6.93 - 1.0).abs() <= 0.01, "{name}: limit {limit}");
    }
}

/// √ Σ V (p − p̄)² / √ Σ V p²: how far the pressure of a cell is from the mean p̄ of the cells that share a node with it.
fn oscillation(mesh: &TetMesh, p: &[f64]) -> f64 {
    let mut around = vec![Vec::new(); mesh.points.len()];
    (0..mesh.cell_count()).for_each(|c| mesh.cell(c)[..4].iter().for_each(|&n| around[n as usize].push(c)));
    let (mut deviation, mut size) = (0.0, 0.0);
    for c in 0..mesh.cell_count() {
        let mut patch: Vec<usize> = mesh.cell(c)[..4].iter().flat_map(|&n| &around[n as usize]).copied().collect();
        patch.sort_unstable();
        patch.dedup();
        let volume: f64 = patch.iter().map(|&k| mesh.cell_volume(k)).sum();
        let mean = patch.iter().map(|&k| mesh.cell_volume(k) * p[k]).sum::<f64>() / volume;
        deviation += mesh.cell_volume(c) * (p[c] - mean).powi(2);
        size += mesh.cell_volume(c) * p[c] * p[c];
    }
    (deviation / size).sqrt()
}

/// A field without oscillation differs from the mean over a patch by the slope of p times h: half as much on the finer mesh,
/// and well below one. A checkerboard of ±p differs by p, whatever the mesh. So: locking-free pairs fall to 0.75 of the
/// coarse value or less (order 0.4, for the singular corner) and below ½, the displacement formulation stays above it.
#[test]
fn the_pressure_does_not_oscillate() {
    for (order, formulation) in FORMULATIONS {
        let [coarse, fine] = [8, 16].map(|n| {
            let (mesh, x) = bent(n, order, formulation, false);
            oscillation(&mesh, &cell_pressures(&mesh, &*rubber(), formulation, &x))
        });
        let name = label(order, formulation);
        println!("Cook, oscillation of the pressure {name}: {coarse:.3} at n = 8, {fine:.3} at n = 16");
        if formulation == Formulation::Displacement {
            assert!(fine > 0.5, "{name} does not show that it locks: {fine}");
        } else {
            assert!(fine <= 0.5 && fine <= 0.75 * coarse, "{name}: {coarse} then {fine}");
        }
    }
}
