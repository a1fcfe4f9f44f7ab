//! Cook's membrane, nearly incompressible: the limit of the tip, and whether the pressure oscillates.

mod common;

use common::cook::{bent, rubber, tip};
use common::formulation::{FORMULATIONS, Formulation, LOCKING_FREE, cell_pressures, label};
use durometer::mesh::{Order, TetMesh};

#[test]
fn the_tip_extrapolates_to_the_reference() {
    for (order, formulation) in LOCKING_FREE {
        let sizes = if order == Order::Linear { [8, 16, 32] } else { [4, 8, 16] };
        let t = std::time::Instant::now();
        let [a, b, c] = sizes.map(|n| tip(n, order, formulation, false));
        let p = ((b - a) / (c - b)).log2();
        let limit = c + (c - b) / (p.exp2() - 1.0);
        println!("cook {}: {a:.4} {b:.4} {c:.4} order {p:.2} limit {limit:.4} {:?}", label(order, formulation), t.elapsed());
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

#[test]
fn the_pressure_does_not_oscillate() {
    for (order, formulation) in FORMULATIONS {
        for n in [8, 16] {
            let (mesh, x) = bent(n, order, formulation, false);
            let p = cell_pressures(&mesh, &*rubber(), formulation, &x);
            println!("pressure {} n {n}: {:.3}", label(order, formulation), oscillation(&mesh, &p));
        }
    }
    let _ = Formulation::Mixed;
}
