//! Grids of VTU and PVD files as histories: the displacement, and every other field that they contain.

use super::footage::{FieldHistory, Footage};
use super::limits::{STATES, VALUES};
use super::modes::without_values;
use super::shape::{Limits, Shape};
use crate::math::tensor::Vec3;
use crate::mesh::error::MeshError;
use crate::mesh::grid_file::{Grid, GridCells, GridData, read_grid};
use crate::scene::column;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Names of displacement arrays, in the length unit of the points.
const DISPLACEMENTS: [&str; 6] = ["displacement_m", "displacement", "Displacement", "displacements", "U", "u"];
/// Smallest motion of the points of a collection, relative to their extent; less is due to the number of written digits.
const MOTION: f64 = 1e-6;
/// Largest number of fields of a page.
const FIELDS: usize = 12;

/// Reads the grids at several times \[s\], all with the same cells, and returns notes on what is left out; `unit_m` is their length unit.
pub fn footage(files: &[(f64, PathBuf)], unit_m: f64, limits: &Limits) -> Result<(Footage, Vec<String>), MeshError> {
    let mut out = Footage::default();
    let mut notes = vec![];
    let Some((_, first)) = files.first() else { return Ok((out, notes)) };
    let grid = read_grid(first, unit_m)?;
    out.shape = shape(&grid, limits);
    let moving = grid.data.iter().find(|d| is_displacement(d)).map(|d| d.name.clone());
    out.quantities = quantities(&grid, moving.as_deref(), &mut notes);
    let each = out.shape.points.len() * (6 + out.quantities.iter().map(|q| q.components).sum::<usize>());
    let most = STATES.min(VALUES / each.max(1)).max(1);
    let stride = files.len().div_ceil(most);
    if stride > 1 {
        notes.push(format!("Every {stride}th of the {} states is shown.", files.len()));
    }
    let mut of_points = vec![];
    for (t, file) in files.iter().step_by(stride) {
        let now = read_grid(file, unit_m)?;
        let new: Vec<&String> = now.left_out.iter().filter(|note| !notes.contains(note)).collect();
        notes.extend(new.into_iter().cloned());
        if now.points.len() != grid.points.len() || now.cells != with_points_of(&now, &grid) {
            let (fact, remedy) =
                ("its cells are not those of the first state", "show it alone, or leave it out of the collection");
            return Err(MeshError::Format { file: file.clone(), fact: fact.into(), remedy: remedy.into() });
        }
        out.times.push(*t);
        of_points.push(differences(&now.points, &grid.points, &out.shape.nodes));
        if let Some(u) = moving.as_ref().and_then(|name| find(&now, name, true)).filter(|d| is_displacement(d)) {
            let u = picked(&u.values, 3, &out.shape.nodes);
            out.motion.push(if unit_m == 1.0 {
                u
            } else {
                u.into_iter().map(|v| (f64::from(v) * unit_m) as f32).collect()
            });
        }
        for q in &mut out.quantities {
            let entities = if q.at_nodes { &out.shape.nodes } else { &out.shape.cell_numbers };
            let values = find(&now, &q.name, q.at_nodes).and_then(|d| match (d.components, q.components) {
                (9, 6) => Some(picked(&super::film::symmetric(&d.values), 6, entities)),
                (own, n) => (own == n).then(|| picked(&d.values, n, entities)),
            });
            let unknown = || vec![f32::NAN; q.components * entities.len()];
            q.states.push(values.unwrap_or_else(unknown));
        }
    }
    let least = MOTION * out.shape.diagonal();
    if of_points.iter().flatten().any(|v| f64::from(v.abs()) > least) {
        let instead = moving.map_or_else(String::new, |name| format!(", in place of {name}"));
        notes.push(format!("The points move from state to state: this motion is shown{instead}."));
        out.motion = of_points;
    } else if let Some(name) = moving.filter(|_| out.motion.len() < out.times.len()) {
        let missing = out.times.len() - out.motion.len();
        notes.push(format!("The motion is left out: {missing} of {} states have no {name}.", out.times.len()));
        out.motion.clear();
    }
    if out.times.windows(2).any(|pair| pair[1] <= pair[0]) {
        notes.push("The times do not rise: the states are in the order of the collection.".into());
    }
    notes.extend(out.quantities.iter().filter_map(gaps));
    rename(&mut out);
    Ok((out, notes))
}

/// Displacement of points from their first positions \[m\].
fn differences(now: &[Vec3], first: &[Vec3], nodes: &[u32]) -> Vec<f32> {
    nodes.iter().flat_map(|&n| <[f64; 3]>::from(now[n as usize] - first[n as usize])).map(|v| v as f32).collect()
}

/// A note on a field that is missing in some states or at some points.
fn gaps(q: &FieldHistory) -> Option<String> {
    let (states, missing) = without_values(&q.states);
    let places: BTreeSet<usize> = missing.iter().map(|k| k / q.components).collect();
    let all = q.states.first().map_or(0, Vec::len) / q.components;
    let kind = if q.at_nodes { "nodes" } else { "cells" };
    let mut parts = vec![];
    if !states.is_empty() {
        parts.push(format!("has no value at {} of {} states", states.len(), q.states.len()));
    }
    if !places.is_empty() {
        parts.push(format!("is left out at {} of {all} {kind}, which have no value at some state", places.len()));
    }
    (!parts.is_empty()).then(|| format!("{} {}.", q.name, parts.join(", and ")))
}

/// Gives the fields the names and units of the page, each name once; if a name is taken, the field keeps the name of its array.
fn rename(footage: &mut Footage) {
    let mut taken: Vec<String> = ["regions", "plain"].map(String::from).into();
    if !footage.motion.is_empty() {
        taken.push("displacement".into());
    }
    for q in &mut footage.quantities {
        let (words, unit) = words(&q.name);
        let of_array = format!("array {}", q.name);
        let name = [words, q.name.clone()].into_iter().find(|name| !taken.contains(name)).unwrap_or(of_array);
        taken.push(name.clone());
        (q.name, q.unit) = (name, unit);
    }
}

/// The cells of another state with the reference points of this one, for comparison.
fn with_points_of(now: &Grid, first: &Grid) -> GridCells {
    match (&now.cells, &first.cells) {
        (GridCells::Tetrahedra(own), GridCells::Tetrahedra(of_first)) => {
            let mut mesh = of_first.clone();
            mesh.points.clone_from(&own.points);
            GridCells::Tetrahedra(mesh)
        }
        _ => first.cells.clone(),
    }
}

fn shape(grid: &Grid, limits: &Limits) -> Shape {
    match &grid.cells {
        GridCells::Tetrahedra(mesh) => Shape::of_mesh(mesh, limits),
        GridCells::Triangles(triangles) => of_triangles(grid, triangles),
    }
}

/// A surface without cells: its triangles serve as faces and as cells.
fn of_triangles(grid: &Grid, triangles: &[[u32; 3]]) -> Shape {
    let numbers: Vec<u32> = (0..triangles.len() as u32).collect();
    Shape {
        points: grid.points.iter().map(|p| (*p).into()).collect(),
        nodes: (0..grid.points.len() as u32).collect(),
        facet_nodes: 3,
        facets: triangles.iter().flatten().copied().collect(),
        facet_numbers: numbers.clone(),
        facet_cells: numbers.clone(),
        cell_numbers: numbers,
        ..Shape::default()
    }
}

fn is_displacement(data: &GridData) -> bool {
    data.at_points && data.components == 3 && DISPLACEMENTS.contains(&data.name.as_str())
}

fn find<'a>(grid: &'a Grid, name: &str, at_points: bool) -> Option<&'a GridData> {
    grid.data.iter().find(|d| d.name == name && d.at_points == at_points)
}

/// The fields shown by a page: point fields first, then cell fields without a namesake among them. A note says why a field is left out.
fn quantities(grid: &Grid, moving: Option<&str>, notes: &mut Vec<String>) -> Vec<FieldHistory> {
    let mut all: Vec<&GridData> = vec![];
    for d in grid.data.iter().filter(|d| !(d.at_points && Some(d.name.as_str()) == moving)) {
        if ![1, 3, 6, 9].contains(&d.components) {
            notes.push(format!("{} is left out: it has {} components, not 1, 3, 6 or 9.", d.name, d.components));
        } else if !d.at_points && find(grid, &d.name, true).is_some() {
            notes.push(format!("{} of the cells is left out: the points have a field of this name.", d.name));
        } else {
            all.push(d);
        }
    }
    if all.len() > FIELDS {
        let left: Vec<&str> = all[FIELDS..].iter().map(|d| d.name.as_str()).collect();
        notes.push(format!("Of {} fields the first {FIELDS} are shown, without {}.", all.len(), left.join(", ")));
        all.truncate(FIELDS);
    }
    let of = |d: &GridData| FieldHistory {
        name: d.name.clone(),
        unit: String::new(),
        components: if d.components == 9 { 6 } else { d.components },
        at_nodes: d.at_points,
        states: vec![],
    };
    all.into_iter().map(of).collect()
}

fn picked(values: &[f64], components: usize, entities: &[u32]) -> Vec<f32> {
    let own = |n: u32| (0..components).map(move |i| n as usize * components + i);
    entities.iter().flat_map(|&n| own(n)).map(|k| values[k] as f32).collect()
}

/// Name and unit of a field such as `von_mises_Pa`.
fn words(name: &str) -> (String, String) {
    let (words, unit) = column::words(name);
    (words.replace("von mises", "von Mises stress"), unit.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::viewer::footage::About;
    use crate::report::viewer::unpack::unpack;

    const LIMITS: Limits = Limits { cells: 10, facets: 10 };

    /// Writes a file with one tetrahedron and these arrays at its points.
    fn grid(folder: &std::path::Path, name: &str, arrays: &str) -> PathBuf {
        let array = |kind: &str, name: &str, values: &str| {
            format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">{values}</DataArray>")
        };
        let cells = [("connectivity", "0 1 2 3"), ("offsets", "4"), ("types", "10")].map(|(n, v)| array("Int64", n, v));
        let points = array("Float64", "points", "0 0 0 1 0 0 0 1 0 0 0 1");
        let text = format!(
            "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece><Points>{points}</Points><Cells>{}</Cells>\
             <PointData>{arrays}</PointData><CellData>{}</CellData></Piece></UnstructuredGrid></VTKFile>",
            cells.concat(),
            array("Float64", "good", "1")
        );
        let path = folder.join(name);
        std::fs::write(&path, text).expect("room");
        path
    }

    fn array(name: &str, components: usize, values: &str) -> String {
        format!(
            "<DataArray type=\"Float64\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">{values}</DataArray>"
        )
    }

    /// Every array is shown, or one note says why not, even if all states have it.
    #[test]
    fn arrays_that_are_left_out_are_named() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let arrays = [
            array("two", 2, "1 2 3 4 5 6 7 8"),
            array("short", 1, "1 2 3"),
            array("words", 1, "1 2 3 x"),
            array("vast", usize::MAX, "1 2 3 4"),
            array("good", 1, "1 2 3 4"),
        ];
        let file = grid(folder.path(), "a.vtu", &arrays.concat());
        let (footage, notes) = footage(&[(0.0, file.clone()), (1.0, file)], 1.0, &LIMITS).expect("readable");
        assert_eq!(footage.quantities.iter().map(|q| q.name.as_str()).collect::<Vec<_>>(), ["good"]);
        assert_eq!(notes.len(), 5, "{notes:?}");
        for (name, why) in [
            ("two", "2 components"),
            ("short", "3 values, not 1 for each of 4"),
            ("words", "cannot be read"),
            ("vast", "4 values"),
            ("good of the cells", "a field of this name"),
        ] {
            let is_it = |note: &&String| note.starts_with(name) && note.contains(why);
            assert_eq!(notes.iter().filter(is_it).count(), 1, "{name}: {notes:?}");
        }
    }

    /// A field with other components in a later state is unknown there, and a motion that one state lacks is left out with a note.
    #[test]
    fn later_states_may_lack_a_field() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let zeros = "0 0 0 0 0 0 0 0 0 0 0 0";
        let first = grid(folder.path(), "a.vtu", &[array("u", 3, zeros), array("v", 3, zeros)].concat());
        let other = grid(folder.path(), "b.vtu", &[array("u", 1, "0 0 0 0"), array("v", 1, "0 0 0 0")].concat());
        let (footage, notes) = footage(&[(0.0, first), (1.0, other)], 1.0, &LIMITS).expect("readable");
        let v = footage.quantities.iter().find(|q| q.name == "v").expect("the first state has it");
        assert!(v.states[0].iter().all(|x| *x == 0.0) && v.states[1].iter().all(|x| x.is_nan()));
        let expected = ["The motion is left out: 1 of 2 states have no u.", "v has no value at 1 of 2 states."];
        assert!(footage.motion.is_empty() && notes == expected, "{notes:?}");
    }

    /// Missing values are reported, and the other states and points keep theirs.
    #[test]
    fn values_that_are_missing_are_named() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let state = |name: &str, arrays: &[String]| grid(folder.path(), name, &arrays.concat());
        let files = [
            state("a.vtu", &[array("v", 1, "1 2 3 4"), array("w", 1, "1 2 3 4")]),
            state("b.vtu", &[array("v", 1, "1 2 nan 4"), array("w", 1, "1 2 3 4")]),
            state("c.vtu", &[array("w", 1, "1 2 3 4")]),
        ];
        let files: Vec<(f64, PathBuf)> = (0..3).map(f64::from).zip(files).collect();
        let (footage, notes) = footage(&files, 1.0, &LIMITS).expect("readable");
        let expected =
            "v has no value at 1 of 3 states, and is left out at 1 of 4 nodes, which have no value at some state.";
        assert_eq!(notes, [expected]);
        let case = unpack(&footage.packed(About::default())).expect("sound");
        let v = case.fields.iter().find(|f| f.name == "v").expect("shown");
        let seen = |state: usize| v.modes.at(state).iter().map(|x| x.is_finite()).collect::<Vec<_>>();
        assert_eq!(
            [seen(0), seen(1), seen(2)],
            [vec![true, true, false, true], vec![true, true, false, true], vec![false; 4]]
        );
    }

    /// Points that change their positions are shown as motion, without a displacement field and in preference to one.
    #[test]
    fn points_that_move_from_state_to_state_are_shown_to_move() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let u = array("u", 3, &["9"; 12].join(" "));
        for (arrays, instead) in [("", ""), (u.as_str(), ", in place of u")] {
            let first = grid(folder.path(), "a.vtu", arrays);
            let text = std::fs::read_to_string(&first)
                .expect("text")
                .replace("0 0 0 1 0 0 0 1 0 0 0 1", "0 0 0 3 0 0 0 1 0 0 0 1");
            let second = folder.path().join("b.vtu");
            std::fs::write(&second, text).expect("room");
            let (footage, notes) = footage(&[(0.0, first), (1.0, second)], 0.001, &LIMITS).expect("readable");
            assert_eq!(notes, [format!("The points move from state to state: this motion is shown{instead}.")]);
            let mut moved = [0.0; 12];
            // 2 mm in single precision
            moved[3] = (0.003 - 0.001) as f32;
            assert_eq!(footage.motion, [vec![0.0; 12], moved.to_vec()]);
        }
    }

    /// No field hides another one or the displacement.
    #[test]
    fn fields_have_names_of_their_own() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let names = ["displacement_m", "displacement", "q_Pa", "q_N", "regions"];
        let arrays = names.map(|name| array(name, 3, &["0"; 12].join(" ")));
        let file = grid(folder.path(), "a.vtu", &arrays.concat());
        let (footage, _) = footage(&[(0.0, file)], 1.0, &LIMITS).expect("readable");
        let found: Vec<[&str; 2]> = footage.quantities.iter().map(|q| [q.name.as_str(), q.unit.as_str()]).collect();
        let expected = [["array displacement", ""], ["q", "Pa"], ["q_N", "N"], ["array regions", ""], ["good", ""]];
        assert_eq!(found, expected);
    }

    /// A run by arc length may go back in time: its states are not sorted.
    #[test]
    fn states_whose_times_do_not_rise_keep_their_order() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = grid(folder.path(), "a.vtu", "");
        let files = [0.0, 1.0, 0.5].map(|t| (t, file.clone()));
        let (footage, notes) = footage(&files, 1.0, &LIMITS).expect("readable");
        assert_eq!(footage.times, [0.0, 1.0, 0.5]);
        assert_eq!(notes, ["The times do not rise: the states are in the order of the collection."]);
    }
}
