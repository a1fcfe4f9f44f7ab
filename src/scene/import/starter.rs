//! The starter scene of an imported body: example values labelled as such, and its weight as the load.

use super::fixture::Fixture;
use super::{Import, Imported};
use crate::math::tensor::Vec3;
use crate::math::units::shown;
use crate::mesh::pieces::{Piece, pieces};
use crate::mesh::{Order, TetMesh};
use std::fmt::Write;
use std::path::Path;

/// Example density \[kg/m³\]
const DENSITY: f64 = 1070.0;
/// Ratio of the example modulus to the pressure of the weight of the body over its largest dimension.
const STIFFNESS: f64 = 100.0;
/// Smallest example modulus \[Pa\]
const SOFTEST: f64 = 100e3;
/// A load for bodies with a closed hollow.
const HOLLOW: &str = r#"# EXAMPLE: pressure in the closed hollow of the body; take the marks of comments away
# [mesh.regions.hollow]
# kind = "component"
# pick = "facets"
# which = "inner"
#
# [[constraint]]
# kind = "cavity"
# region = "hollow"
# drive = { kind = "pressure", signal = { kind = "ramp", from = "0 kPa", to = "1 kPa", end = "1 s" } }
"#;

/// Text of a scene that runs as it is, to be written to a file in `folder`.
pub fn starter(import: &Import, imported: &Imported, folder: &Path) -> String {
    let path = relative(&import.file, folder);
    let mesh = &imported.body.mesh;
    let (low, high) = mesh.bounding_box();
    let size = (high - low).norm();
    let name = import.file.file_stem().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let quoted = |text: &str| toml::Value::String(text.into()).to_string();
    let mut out = mesh_table(import, &quoted(&name), &quoted(&path), mesh.order == Order::Quadratic);
    let mut line = |text: String| writeln!(out, "{text}").expect("a string");
    let fixed: Vec<String> = match &imported.fixture {
        Fixture::Region(region) => vec![region.clone()],
        Fixture::Slabs(slabs) => {
            line("\n[mesh.regions]".into());
            let named = |k: usize| if slabs.len() == 1 { "held".to_string() } else { format!("held_{}", k + 1) };
            for (k, slab) in slabs.iter().enumerate() {
                let corner = |p: &Vec3| {
                    format!("[{}]", [p.x, p.y, p.z].map(|x| format!("\"{} mm\"", short(x * 1e3))).join(", "))
                };
                let end = slab.end();
                line(match slab.flat {
                    true => format!("# EXAMPLE: {end}"),
                    false => format!(
                        "# EXAMPLE: {end}, the longest direction of the body. It has no flat end, so that this box ends within cells, and a convergence study needs \
                         another region"
                    ),
                });
                let (low, high) = (corner(&slab.low), corner(&slab.high));
                line(format!("{} = {{ kind = \"box\", min = {low}, max = {high} }}", named(k)));
            }
            (0..slabs.len()).map(named).collect()
        }
    };
    let modulus = one_digit((STIFFNESS * DENSITY * 9.81 * size).max(SOFTEST) / 1e3);
    line(format!(
        "\n[laws.example]\nlaw = \"neo_hookean\"\nE = \"{modulus} kPa\" # EXAMPLE: the modulus of your material\nnu = 0.45 # EXAMPLE\n\n\
         [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"example\"\nformulation = \"mixed\"\n\n\
         [[effect]]\nkind = \"gravity\"\nregion = \"body\"\ndensity = \"{DENSITY} kg/m^3\" # EXAMPLE\ndirection = [0, 0, -1] # EXAMPLE\n\
         acceleration = {{ kind = \"ramp\", from = \"0 m/s^2\", to = \"9.81 m/s^2\", end = \"1 s\" }}\n"
    ));
    for region in &fixed {
        line(format!("[[constraint]]\nkind = \"fixed\"\nregion = {}\n", quoted(region)));
    }
    if is_hollow(mesh) {
        line(HOLLOW.into());
    }
    line("[[probe]]\nkind = \"energy\"\n".into());
    line("[[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"0.5 s\"\n".into());
    for region in &fixed {
        line(format!("[[probe]]\nkind = \"reaction\"\nregion = {}\n", quoted(region)));
    }
    out.truncate(out.trim_end().len());
    out + "\n"
}

/// Whether the body has an inner surface, as found by the selector `component`.
fn is_hollow(mesh: &TetMesh) -> bool {
    pieces(mesh).iter().any(Piece::is_inner)
}

/// Title and `[mesh]` of the scene.
fn mesh_table(import: &Import, title: &str, path: &str, quadratic: bool) -> String {
    let spec = &import.spec;
    let mut out = String::from(
        "# Starter scene, written by `durometer`. It runs as it is, but its physics is an example: replace every value marked EXAMPLE.\n",
    );
    let mut line = |text: String| writeln!(out, "{text}").expect("a string");
    line(format!("title = {}\n\n[mesh]\nfile = {}", title, path));
    line(format!("unit = {} # {}", toml::Value::String(import.unit.clone()), import.unit_reason));
    if let Some(cells) = spec.cells {
        line(format!("cells = {cells} # EXAMPLE: increase it until the result no longer changes"));
    }
    if spec.split {
        line("split = true # hexahedra, wedges and pyramids become tetrahedra".into());
    }
    if let Some(distance) = spec.merge {
        line(format!("merge = \"{:e} mm\" # the file has nodes at the same place", shown(distance.0 * 1e3)));
    }
    if quadratic {
        line("element = \"tet10\"".into());
    }
    out
}

/// The next larger number with one significant digit.
fn one_digit(x: f64) -> f64 {
    let scale = 10f64.powf(x.log10().floor());
    (x / scale).ceil() * scale
}

/// A length with eight significant digits, a tenth of the depth of a flat end.
fn short(x: f64) -> f64 {
    format!("{x:.7e}").parse().unwrap_or(x)
}

/// The path of a file relative to a folder, with `/`.
fn relative(file: &Path, folder: &Path) -> String {
    let full = |p: &Path| std::fs::canonicalize(p).or_else(|_| std::path::absolute(p)).unwrap_or(p.into());
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (file, folder) = (full(file), full(folder));
    let (a, b): (Vec<_>, Vec<_>) = (file.components().collect(), folder.components().collect());
    let common = a.iter().zip(&b).take_while(|(x, y)| x == y).count();
    let up = std::iter::repeat_n("..".to_string(), b.len() - common);
    let down = a[common..].iter().map(|c| c.as_os_str().to_string_lossy().into_owned());
    up.chain(down).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::boundary::add_boundary;
    use crate::mesh::structured::block;

    /// A block of 3³ boxes is solid, and is hollow without the middle one.
    #[test]
    fn a_pressure_is_offered_where_there_is_a_hollow() {
        let mut mesh = block(3, 3, 3, 0.3, 0.3, 0.3, Order::Linear);
        assert!(!is_hollow(&mesh));
        let middle = Vec3::repeat(0.15);
        let is_kept = |c: &usize| (mesh.position(*c, [0.25; 3]) - middle).amax() > 0.05;
        let kept: Vec<u32> = (0..mesh.cell_count()).filter(is_kept).flat_map(|c| mesh.cell(c).to_vec()).collect();
        mesh.cells = kept;
        add_boundary(&mut mesh);
        assert!(is_hollow(&mesh));
        let example: String =
            HOLLOW.lines().skip(1).map(|line| line.trim_start_matches('#').to_string() + "\n").collect();
        let example: toml::Table = example.parse().unwrap_or_else(|e| panic!("{e}: {example}"));
        assert!(example["constraint"].is_array() && example["mesh"]["regions"]["hollow"].is_table(), "{example}");
    }
}
