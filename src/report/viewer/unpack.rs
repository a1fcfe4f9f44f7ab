//! The model of packed data: the inverse of [`pack`](super::pack::pack).

use super::model::{Arrows, Curves, Field, Model};
use super::modes::Modes;
use super::pack::Packed;
use super::shape::{Marked, PartKind, Shape, ShapePart};
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::io::Read;

/// Largest number of bytes of unpacked numbers.
const LIMIT: u64 = 1 << 30;

/// Unpacks a case; `None` if its description and its numbers do not match. Facets are numbered as on the page.
pub fn unpack(packed: &Packed) -> Option<Model> {
    let mut bytes = vec![];
    flate2::read::ZlibDecoder::new(&packed.data[..]).take(LIMIT).read_to_end(&mut bytes).ok()?;
    let (head, block) = (&packed.head, Block { bytes });
    let shape = shape(head, &block)?;
    let (points, cells) = (shape.points.len(), shape.cell_numbers.len());
    let times: Vec<f64> = plain(&head["times"])?;
    let fields = head["fields"].as_array()?.iter().map(|f| {
        let at_nodes = f["nodal"].as_bool()?;
        let modes = modes(&f["modes"], &block, times.len())?;
        let count = modes.shapes.first().map_or(0, Vec::len) / modes.components.max(1);
        let fits = count >= if at_nodes { shape.nodes.len() } else { cells };
        fits.then_some(Field { name: plain(&f["name"])?, unit: plain(&f["unit"])?, at_nodes, modes })
    });
    let motion = modes(&head["motion"], &block, times.len())?;
    let fits =
        motion.shapes.iter().all(|s| s.len() == 3 * points) && (motion.shapes.is_empty() || motion.components == 3);
    Some(Model {
        title: plain(&head["title"])?,
        facts: plain(&head["facts"])?,
        notes: plain(&head["notes"])?,
        absent: plain(&head["absent"])?,
        // Missing on pages of earlier versions
        still: plain(&head["still"]).unwrap_or_default(),
        fields: fields.collect::<Option<_>>()?,
        arrows: head["arrows"].as_array()?.iter().map(|a| arrows(a, &block, points)).collect::<Option<_>>()?,
        curves: curves(&head["curves"], &block)?,
        motion: fits.then_some(motion)?,
        times,
        shape,
    })
}

fn plain<T: DeserializeOwned>(value: &Value) -> Option<T> {
    T::deserialize(value).ok()
}

fn shape(head: &Value, block: &Block) -> Option<Shape> {
    let (origin, relative): ([f64; 3], Vec<f32>) = (plain(&head["origin"])?, block.floats(&head["points"])?);
    let count = relative.len() / 3;
    let point = |p: usize| std::array::from_fn(|i| origin[i] + f64::from(relative[i * count + p]));
    let [nodes, facet_nodes, cell_count]: [usize; 3] =
        [plain(&head["nodes"])?, plain(&head["facetNodes"])?, plain(&head["cellCount"])?];
    let below = |all: Vec<u32>, end: usize| all.iter().all(|k| (*k as usize) < end).then_some(all);
    // Missing on pages of earlier versions, or if they are 0, 1, 2, …
    let numbers = |array: &Value, count: usize| match array.is_null() {
        true => Some((0..count as u32).collect()),
        false => block.indices(array).filter(|own| own.len() == count),
    };
    let facets = below(block.indices(&head["facets"])?, count)?;
    let cells = below(block.indices(&head["cells"])?, nodes)?;
    let facet_cells = below(block.indices(&head["facetCells"])?, cell_count)?;
    let parts = head["parts"].as_array()?.iter().map(|p| {
        let (first, own): (u32, u32) = (plain(&p["first"])?, plain(&p["count"])?);
        let corners = below(block.indices(&p["triangles"])?, own as usize)?;
        let kind = PartKind::ALL.into_iter().find(|k| p["kind"] == k.name())?;
        let fits = first as usize + own as usize <= count;
        let triangles = corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        fits.then_some(ShapePart { name: plain(&p["name"])?, kind, first, count: own, triangles })
    });
    let marked = head["marked"].as_array()?.iter().map(|m| {
        let kind = ["region", "cavity", "held"].into_iter().find(|k| m["kind"] == *k)?;
        let facets = below(block.indices(&m["facets"])?, facet_cells.len())?;
        Some(Marked { name: plain(&m["name"])?, kind, facets, points: below(block.indices(&m["points"])?, nodes)? })
    });
    let fits = nodes <= count && [3, 6].contains(&facet_nodes) && facets.len() == facet_nodes * facet_cells.len();
    fits.then_some(Shape {
        points: (0..count).map(point).collect(),
        nodes: numbers(&head["nodeNumbers"], nodes)?,
        // Pages of earlier versions have the numbers of the mesh if they have its inside
        has_own_numbers: plain(&head["ownNumbers"]).unwrap_or(cells.is_empty()),
        facet_nodes,
        facet_numbers: (0..facet_cells.len() as u32).collect(),
        cells,
        cell_numbers: numbers(&head["cellNumbers"], cell_count)?,
        parts: parts.collect::<Option<_>>()?,
        marked: marked.collect::<Option<_>>()?,
        facets,
        facet_cells,
        notes: vec![],
    })
}

fn modes(head: &Value, block: &Block, states: usize) -> Option<Modes> {
    let components: usize = plain(&head["components"])?;
    let shapes = head["shapes"].as_array()?.iter().map(|s| {
        let values = block.shorts(s)?;
        let count = values.len() / components.max(1);
        // A page stores one component after the other
        Some((0..count).flat_map(|p| (0..components).map(move |i| i * count + p)).map(|k| values[k]).collect())
    });
    let (shapes, amplitudes): (Vec<Vec<i16>>, Vec<Vec<Option<f32>>>) =
        (shapes.collect::<Option<_>>()?, plain(&head["amplitudes"])?);
    // JSON writes NaN as null
    let amplitudes: Vec<Vec<f32>> =
        amplitudes.into_iter().map(|a| a.into_iter().map(|v| v.unwrap_or(f32::NAN)).collect()).collect();
    let fits = shapes.len() == amplitudes.len() && amplitudes.iter().all(|a| a.len() == states);
    fits.then_some(Modes { components, shapes, amplitudes, error: plain(&head["error"])? })
}

fn arrows(head: &Value, block: &Block, count: usize) -> Option<Arrows> {
    let (points, vectors) = (block.indices(&head["points"])?, block.floats(&head["vectors"])?);
    if vectors.len() != 3 * points.len() || points.iter().any(|p| *p as usize >= count) {
        return None;
    }
    let mut all = points.into_iter().zip(vectors.chunks_exact(3).map(|v| [v[0], v[1], v[2]]));
    let counts = block.indices(&head["counts"])?;
    let states = counts.into_iter().map(|n| all.by_ref().take(n as usize).collect()).collect();
    Some(Arrows { name: plain(&head["name"])?, unit: plain(&head["unit"])?, states })
}

fn curves(head: &Value, block: &Block) -> Option<Curves> {
    let columns: Vec<String> = plain(&head["columns"])?;
    // Pages of earlier versions also have times in single precision
    let column = |v| block.doubles(v).or_else(|| Some(block.floats(v)?.into_iter().map(f64::from).collect()));
    let values: Vec<Vec<f64>> = head["values"].as_array()?.iter().map(column).collect::<Option<_>>()?;
    let rows = values.first().map_or(0, Vec::len);
    let fits = values.len() == columns.len() && values.iter().all(|v| v.len() == rows);
    let row = |k: usize| values.iter().map(|v| v[k]).collect();
    fits.then(|| Curves { columns, rows: (0..rows).map(row).collect() })
}

/// The unpacked bytes of all arrays.
struct Block {
    bytes: Vec<u8>,
}

impl Block {
    /// Reads the numbers of an array of a kind, most significant bytes first.
    fn words<const N: usize>(&self, array: &Value, kind: &str) -> Option<Vec<[u8; N]>> {
        let [at, count]: [usize; 2] = [plain(&array["at"])?, plain(&array["count"])?];
        let own = self.bytes.get(at..at.checked_add(count.checked_mul(N)?)?)?;
        (array["kind"] == kind)
            .then(|| (0..count).map(|k| std::array::from_fn(|plane| own[plane * count + k])).collect())
    }

    fn doubles(&self, array: &Value) -> Option<Vec<f64>> {
        Some(self.words(array, "f64")?.into_iter().map(f64::from_be_bytes).collect())
    }

    fn floats(&self, array: &Value) -> Option<Vec<f32>> {
        Some(self.words(array, "f32")?.into_iter().map(f32::from_be_bytes).collect())
    }

    fn shorts(&self, array: &Value) -> Option<Vec<i16>> {
        Some(self.words(array, "i16")?.into_iter().map(i16::from_be_bytes).collect())
    }

    fn indices(&self, array: &Value) -> Option<Vec<u32>> {
        let mut past = 0i64;
        let next = |bytes| {
            let word = u32::from_be_bytes(bytes);
            past += i64::from(word >> 1) ^ -i64::from(word & 1);
            u32::try_from(past).ok()
        };
        self.words(array, "u32")?.into_iter().map(next).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::viewer::pack::pack;

    /// A page of one triangle of a mesh with these times and rows.
    fn triangle(times: Vec<f64>, rows: Vec<Vec<f64>>) -> Packed {
        let shape = Shape {
            points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            nodes: vec![4, 7, 9],
            facet_nodes: 3,
            facets: vec![0, 1, 2],
            facet_cells: vec![0],
            cell_numbers: vec![5],
            ..Shape::default()
        };
        let curves = Curves { columns: vec!["t_s".into(), "v".into()], rows };
        pack(&Model { shape, times, curves, ..Model::default() })
    }

    /// Late in a run the times of neighbouring states are equal in single precision, and a page has no room for all rows.
    #[test]
    fn every_state_keeps_the_row_of_its_exact_time() {
        let rows: Vec<Vec<f64>> = (0..12_000).map(|k| vec![86_400.0 + f64::from(k) / 1000.0, f64::from(k)]).collect();
        let states = [0, 1, 2, 7001, 7003, 11_999];
        let packed = triangle(states.map(|k| rows[k][0]).into(), rows.clone());
        let found = unpack(&packed).expect("sound").curves.rows;
        assert!(found.len() < rows.len() / 2, "{}", found.len());
        assert!(states.iter().all(|k| found.contains(&rows[*k])));
    }

    /// A page of an earlier version does not state the numbers of the mesh; without the inside of the body they are unknown.
    #[test]
    fn numbers_of_the_mesh_come_back_where_a_page_has_them() {
        let mut packed = triangle(vec![], vec![]);
        let found = |packed: &Packed| {
            let shape = unpack(packed).expect("sound").shape;
            (shape.nodes, shape.cell_numbers, shape.has_own_numbers)
        };
        assert_eq!(found(&packed), (vec![4, 7, 9], vec![5], false));
        let head = packed.head.as_object_mut().expect("a table");
        ["nodeNumbers", "cellNumbers", "ownNumbers"].iter().for_each(|key| drop(head.remove(*key)));
        assert_eq!(found(&packed), (vec![0, 1, 2], vec![0], true));
    }
}
