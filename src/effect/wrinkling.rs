//! Wrinkling of a compressed membrane in a given state.
//!
//! A deflection w sin kx of a sheet with the force N per length on an incompressible half-space of shear modulus μ has the energy ¼w²(Nk² + 2μk) per
//! area (`docs/explanation/effects.md`). With N < 0 the sheet is unstable to all waves shorter than 2π/k = π|N|/μ. Facets of size h cannot represent
//! waves shorter than 2h: they wrinkle if
//!
//! h < h* = π|N|/(2μ)
//!
//! with N the smallest principal Cauchy stress times the current thickness, μ the sum over the cells at the facet, and h = √(2A) for a facet of area
//! A.

use super::membrane::Membrane;
use super::stress::Stressed;
use crate::mesh::element::CELL_FACES;
use rustc_hash::FxHashMap;

/// The facet of a membrane that is closest to wrinkling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrinkling {
    /// Largest h*/h of a facet \[–\]; the sheet wrinkles if it is 1 or more
    pub ratio: f64,
    /// h* there \[m\]
    pub size: f64,
    /// Share of its area where h* exceeds h \[–\]
    pub share: f64,
}

/// The corners of a face in ascending order.
fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

/// Returns the facet of a sheet on these bodies that is closest to wrinkling at displacement x; `None` if nothing is compressed, if no elastic cell
/// adjoins a compressed facet, or if the stress cannot be balanced by any thickness.
pub fn wrinkling(sheet: &Membrane, bodies: &[&dyn Stressed], x: &[f64]) -> Option<Wrinkling> {
    let corners = |b: usize| sorted([0, 1, 2].map(|k| sheet.facet_nodes(b)[k]));
    let mut shear: FxHashMap<[u32; 3], f64> = (0..sheet.facets()).map(|b| (corners(b), 0.0)).collect();
    for body in bodies {
        let (blocks, mu) = (&body.points().blocks, body.moduli().mu);
        for b in 0..blocks.len() {
            for face in CELL_FACES {
                let key = sorted([0, 1, 2].map(|k| blocks.nodes(b)[face[k]]));
                shear.entry(key).and_modify(|sum| *sum += mu);
            }
        }
    }
    let (mut worst, mut area, mut wrinkled) = (None::<(f64, f64)>, 0.0, 0.0);
    for b in 0..sheet.facets() {
        let own = sheet.area(b);
        area += own;
        let size = 0.5 * std::f64::consts::PI * sheet.compression(x, b)? / shear[&corners(b)];
        let ratio = size / (2.0 * own).sqrt();
        if !ratio.is_finite() || ratio <= 0.0 {
            continue;
        }
        wrinkled += if ratio > 1.0 { own } else { 0.0 };
        worst = worst.filter(|(most, _)| *most >= ratio).or(Some((ratio, size)));
    }
    worst.map(|(ratio, size)| Wrinkling { ratio, size, share: wrinkled / area })
}
