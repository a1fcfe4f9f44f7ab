//! Several bodies in one scene: each from its own source, or as a copy of the mesh of `[mesh]`. Each has its whole boundary as the region `skin`.

use super::Body;
use super::grid::mesh_hash;
use super::mesh_file::content;
use super::mesh_spec::{MeshSpec, PartSpec};
use super::request::{check_without_source, has_source};
use crate::math::tensor::{Mat3, Vec3};
use crate::mesh::boundary::boundary_facets;
use crate::mesh::error::point;
use crate::mesh::generate::{CablePath, MeshStore};
use crate::mesh::overlap::overlap;
use crate::mesh::parts::{image, side_by_side};
use crate::mesh::{Region, TetMesh};
use crate::scene::build::shape::{ShapeFault, TurnSpec};
use crate::scene::error::{SceneError, part};
use crate::scene::text::name::is_name;
use std::collections::BTreeMap;
use std::path::Path;

impl Body {
    /// All bodies of `mesh.part` as one mesh. Regions and cable paths are called `part.region` and `part.path`.
    pub(super) fn of_parts(
        file: &Path,
        spec: &MeshSpec,
        store: Option<&MeshStore>,
        progress: &mut dyn FnMut(&str),
    ) -> Result<Self, SceneError> {
        check_names(file, &spec.parts)?;
        let own = spec.parts.iter().all(|p| has_source(&p.mesh(spec)));
        if own && has_source(spec) {
            let fact = "every part has a source of its own, and nothing takes the mesh of [mesh]";
            return Err(content(file, fact, "remove the source from one of the parts, or from [mesh]"));
        }
        if own {
            check_without_source(file, spec)?;
        }
        let base = if own { None } else { Some(Self::sound(file, spec, store, progress)?) };
        let (mut named, mut paths) = (Vec::<(String, TetMesh)>::new(), BTreeMap::new());
        let (mut sources, mut notes, mut warnings, mut volumes) = (vec![], vec![], vec![], vec![]);
        if let Some(base) = &base {
            sources.push(base.source.clone());
            notes.extend(base.notes.clone());
            warnings.extend(base.warnings.clone());
        }
        for part in &spec.parts {
            let (a, b) = placement(file, part)?;
            let own = own_body(file, spec, part, store, progress)?;
            if let Some(own) = &own {
                sources.push(own.source.clone());
                let named = |words: &String| format!("{}: {words}", part.name);
                notes.extend(own.notes.iter().map(named));
                warnings.extend(own.warnings.iter().map(named));
            }
            let body = own.as_ref().or(base.as_ref()).expect("a part without a source has the mesh");
            volumes.extend(body.volumes.iter().map(|volume| volume.of_part(&part.name)));
            for (path, cable) in &body.paths {
                paths.insert(format!("{}.{path}", part.name), carried(cable, &a, &b));
            }
            let mesh = with_skin(image(&body.mesh, &a, &b));
            for (other, before) in &named {
                if let Some(at) = overlap(before, &mesh) {
                    let fact = format!("the parts \"{other}\" and \"{}\" both fill {}", part.name, point(&at));
                    return Err(content(file, fact, "shift one of the two: bodies may touch, not overlap"));
                }
            }
            named.push((part.name.clone(), mesh));
        }
        let mesh = side_by_side(&named).expect("there is a part");
        let sha256 = mesh_hash(&mesh);
        let mut seen = std::collections::BTreeSet::new();
        sources.retain(|s| seen.insert(s.clone()));
        Ok(Self { paths, notes, warnings, volumes, ..Self::new(mesh, sources.join(" + "), sha256) })
    }
}

/// The body of a part that has a source of its own; its errors name the part.
fn own_body(
    file: &Path,
    spec: &MeshSpec,
    part: &PartSpec,
    store: Option<&MeshStore>,
    progress: &mut dyn FnMut(&str),
) -> Result<Option<Body>, SceneError> {
    let table = part.mesh(spec);
    let place = format!("mesh.part {}", part.name);
    if has_source(&table) {
        return Body::sound(file, &table, store, progress).map(Some).map_err(|e| e.at(&place));
    }
    let idle = [
        ("parameters", !table.parameters.is_empty()),
        ("cells", table.cells.is_some()),
        ("size", table.size.is_some()),
        ("levels", table.levels > 0),
        ("unit", table.unit.is_some()),
        ("split", table.split),
        ("merge", table.merge.is_some()),
    ];
    match idle.iter().find(|(_, given)| *given) {
        Some((key, _)) => {
            let fact = format!("`{key}` has no effect on an image of the mesh of [mesh]");
            Err(content(file, fact, "remove it, or give the part a `body`, `file` or `grid` of its own").at(&place))
        }
        None => Ok(None),
    }
}

/// Adds the whole boundary as the region `skin`, unless the mesh has a region of this name.
fn with_skin(mut mesh: TetMesh) -> TetMesh {
    let facets = boundary_facets(&mesh);
    mesh.regions.entry("skin".into()).or_insert(Region { facets, ..Region::default() });
    mesh
}

fn check_names(file: &Path, parts: &[PartSpec]) -> Result<(), SceneError> {
    for (k, PartSpec { name, .. }) in parts.iter().enumerate() {
        // A point separates the name of a part from that of its region
        if !is_name(name) || name.contains('.') {
            let fact = format!("{name:?} cannot be the name of a part");
            let remedy = "use letters, digits, \"-\" and \"_\", with a letter, a digit or \"_\" first";
            return Err(content(file, fact, remedy));
        }
        if parts[..k].iter().any(|c| c.name == *name) {
            let fact = format!("two parts are called \"{name}\"");
            return Err(content(file, fact, "give each a `name` of its own"));
        }
    }
    Ok(())
}

/// The matrix A and the vector b of the map X ↦ A X + b from the part's own position to its position in the scene.
fn placement(file: &Path, spec: &PartSpec) -> Result<(Mat3, Vec3), SceneError> {
    let mirror = match spec.mirror.map(Vec3::from) {
        None => Mat3::identity(),
        Some(n) if n.norm() > 0.0 && n.norm().is_finite() => {
            Mat3::identity() - n * n.transpose() * (2.0 / n.norm_squared())
        }
        Some(_) => {
            let fact = format!("the normal of `mirror` of the part \"{}\" has no length", spec.name);
            return Err(content(file, fact, "write for example [1, 0, 0]"));
        }
    };
    let turn = spec.turn.as_ref().map_or(Ok(Mat3::identity()), TurnSpec::axes).map_err(|why| match why {
        ShapeFault::Content(fact, remedy) => content(file, format!("part \"{}\": {fact}", spec.name), remedy),
        ShapeFault::Part(source) => part(file, "mesh.part", source),
    })?;
    let shift = spec.shift.map_or(Vec3::zeros(), |s| Vec3::from(s.map(|x| x.0)));
    Ok((turn * mirror, shift))
}

/// The image of a cable path under the map X ↦ A X + b of its body.
fn carried(cable: &CablePath, a: &Mat3, b: &Vec3) -> CablePath {
    let image = |p: &[f64; 3]| (a * Vec3::from(*p) + b).into();
    CablePath {
        guides: cable.guides.iter().map(image).collect(),
        pull_point: image(&cable.pull_point),
        guide_radius: cable.guide_radius,
    }
}
