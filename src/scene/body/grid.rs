//! Meshes that a scene makes itself: grids of boxes, and meshes that are made worse on purpose.

use super::mesh_spec::{DisturbSpec, ElementSpec, GridSpec};
use crate::mesh::disturb::{add_slivers, distort};
use crate::mesh::graded::{Growth, half_space, half_sphere};
use crate::mesh::validate::min_det;
use crate::mesh::{TetMesh, curved, structured};
use crate::scene::error::SceneError;
use crate::scene::text::quantity::Length;
use crate::storage;
use sha2::{Digest, Sha256};
use std::f64::consts::PI;
use std::path::Path;
use toml::Value;

/// Largest number of cells of a grid; more are taken for a mistake, since no direct solver can store their matrix.
const MOST_CELLS: f64 = 1e7;

/// The mesh of a grid.
///
/// # Errors
///
/// Where a size is not positive or a number of divisions is zero or too large.
pub fn mesh_of_grid(file: &Path, spec: &GridSpec, element: ElementSpec) -> Result<TetMesh, SceneError> {
    let refuse = |fact: String, remedy: &str| Err(content(file, "mesh.grid", fact, remedy));
    let (divisions, lengths) = measures(spec);
    if divisions.contains(&0) {
        return refuse(format!("divisions = {divisions:?}"), "give at least one box in each direction");
    }
    if cells_of_grid(spec) > MOST_CELLS {
        let fact = format!("divisions = {divisions:?} make {:.1e} cells", cells_of_grid(spec));
        return refuse(fact, &format!("take fewer: a grid has at most {MOST_CELLS:e} cells"));
    }
    if let Some(length) = lengths.iter().find(|l| l.0 <= 0.0) {
        return refuse(format!("a length is {} mm", length.0 * 1e3), "lengths are positive");
    }
    if let Some(length) = lengths.iter().find(|l| !(1e-15..=1e15).contains(&l.0)) {
        return refuse(format!("a length is {:.1e} m", length.0), "take lengths from 1e-15 to 1e15 m");
    }
    let order = element.order();
    let growth = |fine: &Length, [inner, outer]: [usize; 2]| Growth { fine: fine.0, inner, outer };
    let mesh = match spec {
        GridSpec::Box { size: [x, y, z], divisions: [nx, ny, nz] } => {
            structured::block(*nx, *ny, *nz, x.0, y.0, z.0, order)
        }
        GridSpec::Plate { corners, thickness, divisions } => {
            curved::plate(corners.map(|c| c.map(|x| x.0)), thickness.0, *divisions, order)
        }
        GridSpec::Octant { inner, outer, .. } | GridSpec::Tube { inner, outer, .. } if inner.0 >= outer.0 => {
            return refuse("inner is not less than outer".into(), "exchange the two");
        }
        GridSpec::Octant { inner, outer, divisions: [n, layers] } => {
            curved::octant(inner.0, outer.0, *n, *layers, order)
        }
        GridSpec::Cylinder { radius, length, divisions: [n, layers] } => {
            curved::cylinder(radius.0, length.0, *n, *layers, order)
        }
        GridSpec::Bow { radius, bend, .. } if radius.0 >= bend.0 => {
            return refuse("radius is not less than bend".into(), "take a thinner bar, or a wider arc");
        }
        GridSpec::Bow { angle, .. } if !(angle.0 > 0.0 && angle.0.to_degrees() <= 350.0) => {
            let fact = format!("angle = {} deg", angle.0.to_degrees());
            return refuse(fact, "take one above 0 and up to 350 deg: a closed ring has no ends");
        }
        GridSpec::Bow { radius, bend, angle, divisions } => curved::bow(radius.0, (bend.0, angle.0), *divisions, order),
        GridSpec::Hole { radius, half_edge, .. } if radius.0 >= half_edge.0 => {
            return refuse("radius is not less than half_edge".into(), "take a smaller hole");
        }
        GridSpec::Hole { divisions: [_, around, _], .. } if around % 2 == 1 => {
            return refuse(
                format!("{around} divisions go round the quarter"),
                "take an even number: its corner is a node",
            );
        }
        GridSpec::Hole { radius, half_edge, thickness, divisions } => {
            curved::hole(radius.0, half_edge.0, thickness.0, *divisions, order)
        }
        GridSpec::Tube { divisions: [_, around, _], .. } if *around < 3 => {
            return refuse(format!("{around} divisions go round the tube"), "take at least three, better sixteen");
        }
        GridSpec::Tube { inner, outer, length, divisions } => {
            curved::tube([inner.0, outer.0], length.0, *divisions, order)
        }
        GridSpec::Bracket { edge, thickness, divisions } => curved::bracket(edge.0, thickness.0, *divisions, order),
        GridSpec::HalfSpace { radius, fine, divisions } | GridSpec::HalfSphere { radius, fine, divisions }
            if fine.0 * divisions[0] as f64 >= radius.0 =>
        {
            return refuse(
                "the inner layers reach beyond the radius".into(),
                "take a smaller `fine`, or fewer of them",
            );
        }
        GridSpec::HalfSpace { radius, fine, divisions } => half_space(radius.0, growth(fine, *divisions), order),
        GridSpec::HalfSphere { radius, fine, divisions } => half_sphere(radius.0, growth(fine, *divisions), order),
    };
    match (0..mesh.cell_count()).find(|&c| min_det(&mesh, c) <= 0.0) {
        Some(c) => {
            refuse(format!("cell {c} is folded"), "go round the corners counter-clockwise, or take more divisions")
        }
        None => Ok(mesh),
    }
}

/// Volume of the round body that a grid fills \[m³\]; `None` for grids with flat sides.
pub fn round_volume(spec: &GridSpec) -> Option<f64> {
    match spec {
        GridSpec::Box { .. } | GridSpec::Plate { .. } | GridSpec::Bracket { .. } => None,
        GridSpec::Octant { inner, outer, .. } => Some(PI / 6.0 * (outer.0.powi(3) - inner.0.powi(3))),
        GridSpec::Cylinder { radius, length, .. } => Some(PI * radius.0.powi(2) * length.0),
        GridSpec::Tube { inner, outer, length, .. } => Some(PI * (outer.0.powi(2) - inner.0.powi(2)) * length.0),
        // Pappus: the centroid of the section moves along the arc
        GridSpec::Bow { radius, bend, angle, .. } => Some(PI * radius.0.powi(2) * bend.0 * angle.0),
        GridSpec::Hole { radius, half_edge, thickness, .. } => {
            Some((half_edge.0.powi(2) - PI / 4.0 * radius.0.powi(2)) * thickness.0)
        }
        GridSpec::HalfSpace { radius, .. } | GridSpec::HalfSphere { radius, .. } => Some(PI / 6.0 * radius.0.powi(3)),
    }
}

/// The grid with `factor` times as many divisions along its edges, rounded, but not fewer than the grid needs; `None` for grids whose cells grow from a point,
/// since their numbers of layers are not divisions of an edge.
pub fn scaled_grid(spec: &GridSpec, factor: f64) -> Option<GridSpec> {
    let wanted: Vec<f64> = divisions_of_grid(spec).iter().map(|n| factor * *n as f64).collect();
    let grows = matches!(spec, GridSpec::HalfSpace { .. } | GridSpec::HalfSphere { .. });
    (!grows).then(|| grid_with_divisions(spec, &wanted))
}

/// The grid with the admissible numbers of divisions that are nearest to `wanted`.
pub fn grid_with_divisions(spec: &GridSpec, wanted: &[f64]) -> GridSpec {
    let mut out = spec.clone();
    let divisions = match &mut out {
        GridSpec::Box { divisions, .. }
        | GridSpec::Plate { divisions, .. }
        | GridSpec::Hole { divisions, .. }
        | GridSpec::Tube { divisions, .. } => divisions.as_mut_slice(),
        GridSpec::Octant { divisions, .. }
        | GridSpec::Cylinder { divisions, .. }
        | GridSpec::Bow { divisions, .. }
        | GridSpec::Bracket { divisions, .. }
        | GridSpec::HalfSpace { divisions, .. }
        | GridSpec::HalfSphere { divisions, .. } => divisions.as_mut_slice(),
    };
    for (k, (n, wanted)) in divisions.iter_mut().zip(wanted).enumerate() {
        let (unit, least) = match spec {
            GridSpec::Hole { .. } if k == 1 => (2, 2),
            GridSpec::Tube { .. } if k == 1 => (1, 3),
            _ => (1, 1),
        };
        *n = (unit * (wanted / unit as f64).round() as usize).max(least);
    }
    out
}

/// The divisions of a grid, as in its key `divisions`.
pub fn divisions_of_grid(spec: &GridSpec) -> &[usize] {
    measures(spec).0
}

/// The divisions of a grid, as a value of the key `divisions`.
pub fn divisions_value(spec: &GridSpec) -> Value {
    Value::from(divisions_of_grid(spec).iter().map(|n| *n as i64).collect::<Vec<_>>())
}

/// Grids of the same proportions, coarse ones first: the divisions are exact multiples of those of the coarsest grid. The iterator is empty for grids whose
/// cells grow from a point.
pub fn similar_grids(spec: &GridSpec) -> impl Iterator<Item = GridSpec> {
    let own = divisions_of_grid(spec).to_vec();
    let common = common_divisor(own.iter().copied()).max(1);
    let multiple = move |k: usize| {
        let grid = scaled_grid(spec, k as f64 / common as f64)?;
        let is_exact = divisions_of_grid(&grid).iter().zip(&own).all(|(n, own)| common * n == k * own);
        Some(is_exact.then_some(grid))
    };
    (1..).map_while(multiple).flatten()
}

/// Greatest common divisor of these numbers; zero if there are no numbers.
pub fn common_divisor(numbers: impl IntoIterator<Item = usize>) -> usize {
    fn of_two(a: usize, b: usize) -> usize {
        if b == 0 { a } else { of_two(b, a % b) }
    }
    numbers.into_iter().fold(0, of_two)
}

/// The number of cells of a grid, or slightly more, as a float: exact integers are not needed, and could overflow.
pub fn cells_of_grid(spec: &GridSpec) -> f64 {
    let boxes = match spec {
        GridSpec::Octant { divisions: [n, layers], .. } => [*n, *n, *layers],
        GridSpec::Cylinder { divisions: [n, layers], .. } | GridSpec::Bow { divisions: [n, layers], .. } => {
            [n.saturating_mul(3), *n, *layers]
        }
        GridSpec::Bracket { divisions: [n, layers], .. } => [n.saturating_mul(2), n.saturating_mul(2), *layers],
        GridSpec::HalfSpace { divisions: [inner, outer], .. }
        | GridSpec::HalfSphere { divisions: [inner, outer], .. } => [inner.saturating_add(*outer); 3],
        GridSpec::Box { divisions, .. }
        | GridSpec::Plate { divisions, .. }
        | GridSpec::Hole { divisions, .. }
        | GridSpec::Tube { divisions, .. } => *divisions,
    };
    6.0 * boxes.iter().map(|n| *n as f64).product::<f64>()
}

/// Divisions and lengths of a grid.
fn measures(spec: &GridSpec) -> (&[usize], Vec<Length>) {
    match spec {
        GridSpec::Box { size, divisions } => (divisions, size.to_vec()),
        GridSpec::Plate { thickness, divisions, .. } => (divisions, vec![*thickness]),
        GridSpec::Octant { inner, outer, divisions } => (divisions, vec![*inner, *outer]),
        GridSpec::Cylinder { radius, length, divisions } => (divisions, vec![*radius, *length]),
        GridSpec::Tube { inner, outer, length, divisions } => (divisions, vec![*inner, *outer, *length]),
        GridSpec::Bow { radius, bend, divisions, .. } => (divisions, vec![*radius, *bend]),
        GridSpec::Hole { radius, half_edge, thickness, divisions } => {
            (divisions, vec![*radius, *half_edge, *thickness])
        }
        GridSpec::Bracket { edge, thickness, divisions } => (divisions, vec![*edge, *thickness]),
        GridSpec::HalfSpace { radius, fine, divisions } | GridSpec::HalfSphere { radius, fine, divisions } => {
            (divisions, vec![*radius, *fine])
        }
    }
}

/// Moves nodes and makes slivers.
///
/// # Errors
///
/// Where a size or a number is out of its range.
pub fn disturb(file: &Path, spec: &DisturbSpec, mesh: &mut TetMesh) -> Result<(), SceneError> {
    let refuse = |fact: String, remedy: &str| Err(content(file, "mesh.disturb", fact, remedy));
    if !(0.0..=1.0).contains(&spec.nodes) || !(0.0..=1.0).contains(&spec.slivers) {
        let fact = format!("nodes = {}, slivers = {}", spec.nodes, spec.slivers);
        return refuse(fact, "both are shares between 0 and 1");
    }
    distort(mesh, spec.seed, spec.nodes);
    if let Some(c) = (0..mesh.cell_count()).find(|&c| min_det(mesh, c) <= 0.0) {
        return refuse(format!("nodes = {} folds cell {c}", spec.nodes), "take less: 0.1 is safe on grids");
    }
    match spec.angle {
        None if spec.slivers > 0.0 => refuse("slivers have no angle".into(), "add for example angle = \"0.5 deg\""),
        Some(_) if spec.slivers == 0.0 => refuse("`angle` has no effect without slivers".into(), "remove it"),
        Some(angle) if !(angle.0 > 0.0 && angle.0.to_degrees() < 10.0) => {
            refuse(format!("angle = {} deg", angle.0.to_degrees()), "take one above 0 and below 10 deg")
        }
        None => Ok(()),
        Some(angle) => {
            add_slivers(mesh, spec.seed, spec.slivers, angle.0);
            Ok(())
        }
    }
}

/// SHA-256 of the nodes and cells.
pub fn mesh_hash(mesh: &TetMesh) -> String {
    let mut hash = Sha256::new();
    mesh.points.iter().flat_map(|p| p.iter()).for_each(|x| hash.update(x.to_le_bytes()));
    mesh.cells.iter().for_each(|k| hash.update(k.to_le_bytes()));
    storage::hexadecimal(&hash.finalize())
}

fn content(file: &Path, place: &str, fact: String, remedy: &str) -> SceneError {
    SceneError::Content { file: file.into(), place: place.into(), fact, remedy: remedy.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::text::quantity::Angle;

    /// Quadratic cells on a round body have the volume of the body, however few they are.
    #[test]
    fn round_grids_have_the_volume_of_their_body() {
        let mm = |x: f64| Length(1e-3 * x);
        let round = [
            GridSpec::Octant { inner: mm(5.0), outer: mm(9.0), divisions: [4, 1] },
            GridSpec::Cylinder { radius: mm(5.0), length: mm(7.0), divisions: [2, 2] },
            GridSpec::Tube { inner: mm(5.0), outer: mm(9.0), length: mm(7.0), divisions: [1, 12, 1] },
            GridSpec::Bow { radius: mm(2.0), bend: mm(9.0), angle: Angle(1.5), divisions: [2, 6] },
            GridSpec::Hole { radius: mm(3.0), half_edge: mm(7.0), thickness: mm(2.0), divisions: [3, 6, 1] },
            GridSpec::HalfSpace { radius: mm(9.0), fine: mm(2.0), divisions: [2, 2] },
            GridSpec::HalfSphere { radius: mm(9.0), fine: mm(2.0), divisions: [2, 2] },
        ];
        for spec in round {
            let mesh = mesh_of_grid(Path::new("scene.toml"), &spec, ElementSpec::Tet10).expect("a grid");
            let share = mesh.volume() / round_volume(&spec).expect("round") - 1.0;
            println!("{spec:?}: {share}");
            // The half sphere, whose cells grow, is off by 2e-3
            assert!(share.abs() < 4e-3, "{spec:?}: {share}");
        }
        let flat = GridSpec::Bracket { edge: mm(9.0), thickness: mm(2.0), divisions: [2, 1] };
        assert_eq!(round_volume(&flat), None);
    }

    #[test]
    fn divisions_are_scaled_to_numbers_that_the_grid_takes() {
        let mm = |x: f64| Length(1e-3 * x);
        let block = GridSpec::Box { size: [mm(40.0), mm(20.0), mm(20.0)], divisions: [8, 4, 1] };
        let of = |spec: &GridSpec, factor| divisions_of_grid(&scaled_grid(spec, factor).expect("divisions")).to_vec();
        assert_eq!(of(&block, 1.0), [8, 4, 1]);
        assert_eq!(of(&block, 0.5f64.cbrt()), [6, 3, 1]);
        assert_eq!(of(&block, 0.01), [1, 1, 1]);
        let beam = GridSpec::Box { size: [mm(50.0), mm(20.0), mm(20.0)], divisions: [20, 8, 8] };
        let multiples: Vec<_> = similar_grids(&beam).take(3).map(|grid| divisions_of_grid(&grid).to_vec()).collect();
        assert_eq!(multiples, [[5, 2, 2], [10, 4, 4], [15, 6, 6]]);
        let hole = GridSpec::Hole { radius: mm(1.0), half_edge: mm(5.0), thickness: mm(1.0), divisions: [4, 6, 1] };
        assert_eq!(of(&hole, 2f64.cbrt()), [5, 8, 1]);
        assert_eq!(divisions_of_grid(&grid_with_divisions(&hole, &[5.2, 9.0, 1.0])), [5, 10, 1]);
        let tube = GridSpec::Tube { inner: mm(1.0), outer: mm(2.0), length: mm(9.0), divisions: [1, 4, 6] };
        assert_eq!(of(&tube, 0.5), [1, 3, 3]);
        let similar: Vec<_> = similar_grids(&hole).take(2).map(|grid| divisions_of_grid(&grid).to_vec()).collect();
        assert_eq!(similar, [[4, 6, 1], [8, 12, 2]]);
        assert!(
            scaled_grid(&GridSpec::HalfSphere { radius: mm(9.0), fine: mm(1.0), divisions: [3, 2] }, 2.0).is_none()
        );
    }
}
