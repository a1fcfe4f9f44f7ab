//! The wall of a cavity: facets of a region, facets that a skin lies on, or the triangles of a skin that lies on none.

use crate::effect::{Cavity, VolumeField};
use crate::math::tensor::Vec3;
use crate::math::units::Decimals;
use crate::mesh::TetMesh;
use crate::mesh::attach::TooFar;
use crate::mesh::boundary::boundary_facets;
use crate::mesh::closed_surface::{NotClosed, closed, enclosed};
use crate::mesh::distance::Nearest;
use crate::mesh::divided::FacetSizes;
use crate::mesh::error::point;
use crate::mesh::pieces::pieces;
use crate::mesh::rim::rim;
use crate::mesh::surface_file::Surface;
use crate::scene::build::builder::Builder;
use crate::scene::build::held_planes::HeldPlane;
use crate::scene::build::skin::NamedSkin;
use crate::scene::error::SceneError;
use std::collections::BTreeSet;

/// The surface on which the pressure of a cavity acts.
pub(super) enum Wall {
    /// Facets of the boundary
    Facets(Vec<u32>),
    /// A closed skin, oriented outwards from the volume that it encloses; it follows the body, whose facets next to it are `nearest`.
    Skin { surface: Surface, weights: Vec<Vec<(u32, f64)>>, nearest: Vec<u32> },
}

impl Wall {
    /// Edges that belong to one facet only.
    pub fn rim(&self, mesh: &TetMesh) -> Vec<Vec<u32>> {
        match self {
            Self::Facets(facets) => rim(mesh, facets),
            Self::Skin { .. } => Vec::new(),
        }
    }

    /// The facets of the wall, or the facets next to a skin.
    pub fn facets(&self) -> &[u32] {
        let (Self::Facets(facets) | Self::Skin { nearest: facets, .. }) = self;
        facets
    }

    /// Whether the wall is a skin that follows the body.
    pub fn follows(&self) -> bool {
        matches!(self, Self::Skin { .. })
    }

    /// The mean position of the nodes or vertices, each weighted by the number of its facets \[m\].
    pub fn middle(&self, mesh: &TetMesh) -> Vec3 {
        let places: Vec<Vec3> = match self {
            Self::Facets(facets) => {
                facets.iter().flat_map(|&f| mesh.facet(f as usize)).map(|&n| mesh.points[n as usize]).collect()
            }
            Self::Skin { surface, .. } => {
                surface.triangles.iter().flatten().map(|&k| surface.points[k as usize]).collect()
            }
        };
        places.iter().sum::<Vec3>() / places.len() as f64
    }

    /// Area of the wall \[m²\].
    pub fn area(&self, mesh: &TetMesh) -> f64 {
        match self {
            Self::Facets(facets) => facets.iter().map(|&f| mesh.facet_area(f as usize)).sum(),
            Self::Skin { surface, .. } => surface.areas().iter().sum(),
        }
    }

    /// The cavity behind the wall.
    pub fn cavity(&self, name: String, mesh: &TetMesh, field: VolumeField) -> Cavity {
        match self {
            Self::Facets(facets) => Cavity::new(name, mesh, facets, field),
            Self::Skin { surface, weights, .. } => {
                Cavity::on_surface(name, (&surface.points, &surface.triangles), weights, field)
            }
        }
    }
}

/// The wall that a specification names, and its name for messages.
pub(super) fn wall<'a>(
    builder: &mut Builder,
    place: &str,
    cavity: &str,
    region_or_skin: (Option<&'a str>, Option<&'a str>),
) -> Result<(&'a str, Wall), SceneError> {
    match region_or_skin {
        (Some(region), None) => Ok((region, Wall::Facets(of_region(builder, place, region)?))),
        (None, Some(skin)) => Ok((skin, of_skin(builder, place, cavity, skin)?)),
        _ => {
            let fact = "a cavity has one wall";
            Err(builder.content(place, fact, "give either `region` (facets of the mesh) or `skin` (a closed surface)"))
        }
    }
}

fn of_region(builder: &Builder, place: &str, region: &str) -> Result<Vec<u32>, SceneError> {
    let mesh = &builder.body.mesh;
    let facets = builder.region(place, region)?.facets.clone();
    if facets.is_empty() {
        let fact = format!("region \"{region}\" holds no facets");
        return Err(builder.content(place, fact, "a cavity is a part of the surface: take a facet region"));
    }
    let boundary = boundary_facets(mesh);
    if let Some(&f) = facets.iter().find(|f| boundary.binary_search(f).is_err()) {
        let at = point(&mesh.points[mesh.facet(f as usize)[0] as usize]);
        let fact = format!("the facet at {at} has the body on both sides");
        return Err(builder.content(place, fact, "take facets of the boundary only"));
    }
    Ok(facets)
}

/// The facets under a skin, if every triangle lies on them except those of a cap in a plane in which the body ends and is held; otherwise the skin itself,
/// subdivided for the mesh.
fn of_skin(builder: &mut Builder, place: &str, cavity: &str, name: &str) -> Result<Wall, SceneError> {
    let (body, skin) = (builder.body.clone(), builder.skin(place, name)?);
    let (mesh, sizes) = (&body.mesh, FacetSizes::new(&body.mesh));
    let (all, of) = (&skin.surface, skin.surface.triangles.len());
    let on_facets = |surface: &Surface| sizes.facets_under(mesh, surface, skin.reach);
    let loose = match on_facets(all) {
        Ok(facets) => {
            builder
                .notes
                .push(format!("{cavity}: the skin {name} lies on {} facets, which are its wall", facets.len()));
            return Ok(Wall::Facets(facets));
        }
        Err(loose) => loose,
    };
    let open = without_caps(builder, name, all);
    if let Some((rest, capped)) = &open
        && let Ok(facets) = on_facets(rest)
    {
        builder.notes.push(format!(
            "{cavity}: {capped}, and no pressure acts on them; the others lie on {} facets, which are its wall",
            facets.len()
        ));
        return Ok(Wall::Facets(facets));
    }
    let triangles = closed(all).map_err(|NotClosed { edges, at }| match edges {
        0 => {
            let fact = format!("the triangles of the skin \"{name}\" cannot be turned the same way at {}", point(&at));
            builder.content(place, fact, "a cavity needs a surface with two sides: repair it")
        }
        _ => {
            let fact =
                format!("the skin \"{name}\" is not closed: {edges} edges are open, one of them at {}", point(&at));
            builder.content(place, fact, "close the surface, or give facets of the mesh as `region`")
        }
    })?;
    let skin = skin.divided(mesh, &sizes, triangles, skin.reach).map_err(|TooFar { count, distance, at, .. }| {
        let fact = format!(
            "between its vertices the skin \"{name}\" leaves the body: at {count} of the places where it is divided by more than \
             reach = {:.4} mm, the furthest by {:.4} mm at {}",
            Decimals(skin.reach * 1e3),
            Decimals(distance * 1e3),
            point(&at)
        );
        let remedy = "pressure there would load the body next to it: give the facets of the wall as `region` where the skin closes an opening, smaller triangles where the \
                      wall is curved, or a larger `reach`";
        builder.content(place, fact, remedy)
    })?;
    let Mapping { words, is_off, nearest } = mapping(mesh, &skin).map_err(|at| {
        let fact = format!("the skin \"{name}\" has the body inside of it, at {}", point(&at));
        builder.content(place, fact, "take the surface of a hollow, with the body around it")
    })?;
    if let Some((_, capped)) = open {
        let fact = format!(
            "{capped}, and the others lie on no facets: as a part of it that follows the body, this cap would load it"
        );
        return Err(builder.content(place, fact, "give the facets of the wall as `region`"));
    }
    let told =
        format!("{cavity}: {loose} of {of} triangles of the skin {name} lie on no facet; it follows the body: {words}");
    if is_off {
        let told = format!(
            "{told}; the pressure acts on another volume than that of the hollow: check file and unit of the skin, or refine the mesh at the hollow"
        );
        builder.gathered.warnings.push(told.clone());
        builder.notes.push(told);
    } else {
        builder.notes.push(told);
    }
    Ok(Wall::Skin { surface: skin.surface, weights: skin.weights, nearest })
}

/// A skin without its triangles in planes in which the body ends and is held, and a description of these; `None` if there are no such triangles, or no others.
fn without_caps(builder: &Builder, name: &str, surface: &Surface) -> Option<(Surface, String)> {
    let planes = HeldPlane::all(builder);
    let is_in = |t: &[u32; 3], plane: &HeldPlane| plane.has(&t.map(|k| surface.points[k as usize]));
    let (caps, triangles): (Vec<_>, Vec<_>) =
        surface.triangles.iter().copied().partition(|t| planes.iter().any(|plane| is_in(t, plane)));
    if caps.is_empty() || triangles.is_empty() {
        return None;
    }
    let of: Vec<String> =
        planes.iter().filter(|plane| caps.iter().any(|t| is_in(t, plane))).map(HeldPlane::words).collect();
    let words = format!(
        "{} of {} triangles of the skin {name} close it where the body ends and is held ({})",
        caps.len(),
        surface.triangles.len(),
        of.join(", ")
    );
    Some((Surface { points: surface.points.clone(), triangles }, words))
}

/// Relative difference allowed between the volume of a skin and that of the hollow in which it lies: facets cut off less of a round hollow.
const OFF: f64 = 0.1;

/// How well a skin that does not lie on facets follows a body.
struct Mapping {
    /// Distances from the surface of the body, and volumes, in words
    words: String,
    /// Whether the volumes differ too much
    is_off: bool,
    /// Facets next to it, ascending
    nearest: Vec<u32>,
}

/// The quality of the mapping of a skin. The error is a point of the skin, if most of it faces out of the body.
fn mapping(mesh: &TetMesh, skin: &NamedSkin) -> Result<Mapping, Vec3> {
    let surface = &skin.surface;
    let facets = boundary_facets(mesh);
    let corners = facets.iter().map(|&f| [0, 1, 2].map(|k| mesh.facet(f as usize)[k])).collect();
    let boundary = Surface { points: mesh.points.clone(), triangles: corners };
    let nearest = Nearest::new(&boundary).expect("a body has a surface");
    let (mut square, mut furthest, mut facing) = (0.0, 0.0_f64, 0.0);
    let mut hit = BTreeSet::new();
    for t in &surface.triangles {
        let [a, b, c] = t.map(|k| surface.points[k as usize]);
        let (area, near) = ((b - a).cross(&(c - a)) / 2.0, nearest.of(&((a + b + c) / 3.0)));
        let facet = facets[near.triangle as usize];
        facing += area.dot(&mesh.facet_normal(facet as usize, [1.0 / 3.0; 2]).normalize());
        square += area.norm() * near.distance.powi(2);
        furthest = [a, b, c].iter().map(|p| nearest.of(p).distance).fold(furthest.max(near.distance), f64::max);
        hit.insert(facet);
    }
    if facing > 0.0 {
        return Err(surface.points[surface.triangles[0][0] as usize]);
    }
    let rms = (square / surface.areas().iter().sum::<f64>()).sqrt();
    let volume = enclosed(&surface.points, &surface.triangles);
    let is_hit = |facets: &[u32]| facets.iter().any(|f| hit.contains(f));
    let hollow: f64 = pieces(mesh).iter().filter(|p| p.volume < 0.0 && is_hit(&p.facets)).map(|p| -p.volume).sum();
    let against = match hollow > 0.0 {
        true => {
            format!(", the hollow of the body {:.4} mm^3 ({:+.3} %)", hollow * 1e9, (volume / hollow - 1.0) * 100.0)
        }
        false => ", and no hollow of the body is closed".into(),
    };
    let is_off = hollow > 0.0 && (volume / hollow - 1.0).abs() > OFF;
    let words = format!(
        "vertices up to {:.4} mm outside of the body, the skin up to {:.4} mm ({:.4} mm rms) from its surface; the skin holds {:.4} mm^3{against}",
        skin.outside * 1e3,
        furthest * 1e3,
        rms * 1e3,
        volume * 1e9
    );
    Ok(Mapping { words, is_off, nearest: hit.into_iter().collect() })
}
