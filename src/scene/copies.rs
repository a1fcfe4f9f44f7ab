//! Several bodies in one scene: images of the mesh, or grids of their own. Each has its whole boundary as the region `skin`.

use super::body::{Body, has_source};
use super::error::SceneError;
use super::error::part;
use super::grid::{grid, mesh_hash};
use super::mesh_file::content;
use super::mesh_spec::{CopySpec, MeshSpec};
use super::shape::{ShapeFault, TurnSpec};
use crate::math::tensor::{Mat3, Vec3};
use crate::mesh::boundary::boundary_facets;
use crate::mesh::error::point;
use crate::mesh::generate::{CablePath, MeshStore};
use crate::mesh::overlap::overlap;
use crate::mesh::parts::{image, side_by_side};
use crate::mesh::{Region, TetMesh};
use std::collections::BTreeMap;
use std::path::Path;

impl Body {
    /// All bodies of `mesh.copy` as one mesh. Regions and cable paths are called `copy.region` and `copy.path`.
    pub(super) fn of_copies(
        file: &Path,
        spec: &MeshSpec,
        store: Option<&MeshStore>,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Self, SceneError> {
        check_names(file, &spec.copies)?;
        let own = spec.copies.iter().all(|c| c.grid.is_some());
        if own && has_source(spec) {
            let fact = "every copy has a grid of its own, and nothing takes the mesh of [mesh]";
            return Err(content(file, fact, "remove `grid` from one of the copies, or the source from [mesh]"));
        }
        let base = if own { None } else { Some(Self::sound(file, spec, store, progress)?) };
        let (mut named, mut paths) = (Vec::<(String, TetMesh)>::new(), BTreeMap::new());
        for copy in &spec.copies {
            let (a, b) = placement(file, copy)?;
            let mesh = match (&copy.grid, &base) {
                (None, Some(base)) => {
                    for (path, cable) in &base.paths {
                        paths.insert(format!("{}.{path}", copy.name), carried(cable, &a, &b));
                    }
                    image(&base.mesh, &a, &b)
                }
                (Some(boxes), _) => image(&grid(file, boxes, spec.element)?, &a, &b),
                (None, None) => unreachable!("a copy without a grid has the mesh"),
            };
            let mesh = with_skin(mesh);
            for (other, before) in &named {
                if let Some(at) = overlap(before, &mesh) {
                    let fact = format!("the copies \"{other}\" and \"{}\" both fill {}", copy.name, point(&at));
                    return Err(content(file, fact, "shift one of the two: bodies may touch, not overlap"));
                }
            }
            named.push((copy.name.clone(), mesh));
        }
        let mesh = side_by_side(&named).expect("there is a copy");
        let sha256 = mesh_hash(&mesh);
        let (source, notes) = base.map_or(("grid".into(), vec![]), |b| (b.source, b.notes));
        Ok(Self { mesh, paths, source, sha256, notes })
    }
}

/// With its whole boundary as the region `skin`, unless it has one.
fn with_skin(mut mesh: TetMesh) -> TetMesh {
    let facets = boundary_facets(&mesh);
    mesh.regions.entry("skin".into()).or_insert(Region { facets, ..Region::default() });
    mesh
}

fn check_names(file: &Path, copies: &[CopySpec]) -> Result<(), SceneError> {
    for (k, CopySpec { name, .. }) in copies.iter().enumerate() {
        let fits = |c: char| c.is_alphanumeric() || "_-".contains(c);
        if name.is_empty() || !name.chars().all(fits) {
            let fact = format!("\"{name}\" cannot be the name of a copy");
            return Err(content(file, fact, "use letters, digits, \"-\" and \"_\""));
        }
        if copies[..k].iter().any(|c| c.name == *name) {
            let fact = format!("two copies are called \"{name}\"");
            return Err(content(file, fact, "give each a `name` of its own"));
        }
    }
    Ok(())
}

/// A and b of X ↦ A X + b.
fn placement(file: &Path, copy: &CopySpec) -> Result<(Mat3, Vec3), SceneError> {
    let mirror = match copy.mirror.map(Vec3::from) {
        None => Mat3::identity(),
        Some(n) if n.norm() > 0.0 && n.norm().is_finite() => {
            Mat3::identity() - n * n.transpose() * (2.0 / n.norm_squared())
        }
        Some(_) => {
            let fact = format!("the normal of `mirror` of the copy \"{}\" has no length", copy.name);
            return Err(content(file, fact, "write for example [1, 0, 0]"));
        }
    };
    let turn = copy.turn.as_ref().map_or(Ok(Mat3::identity()), TurnSpec::axes).map_err(|why| match why {
        ShapeFault::Content(fact, remedy) => content(file, format!("copy \"{}\": {fact}", copy.name), remedy),
        ShapeFault::Part(source) => part(file, "mesh.copy", source),
    })?;
    let shift = copy.shift.map_or(Vec3::zeros(), |s| Vec3::from(s.map(|x| x.0)));
    Ok((turn * mirror, shift))
}

/// A path with its body.
fn carried(cable: &CablePath, a: &Mat3, b: &Vec3) -> CablePath {
    let image = |p: &[f64; 3]| (a * Vec3::from(*p) + b).into();
    CablePath {
        guides: cable.guides.iter().map(image).collect(),
        pull_point: image(&cable.pull_point),
        guide_radius: cable.guide_radius,
    }
}
