//! Fields of a run for ParaView: a VTU file per state on the time grid, and a PVD collection of these files.

use crate::math::stopwatch::{Spent, Stopwatch};
use crate::mesh::error::MeshError;
use crate::mesh::grid_file::read_collection;
use crate::mesh::vtu::{Data, write_pvd, write_surface, write_vtu};
use crate::mesh::{Region, TetMesh};
use crate::scene::Scene;
use crate::scene::output::{Field, FieldSpec};
use crate::system::State;
use std::path::{Path, PathBuf};

/// The fields that are written by default.
pub const USUAL: [FieldSpec; 2] = [FieldSpec::Displacement, FieldSpec::Stretch];

/// Writes `<name>-regions.vtu`, `<name>-0000.vtu`, … and `<name>.pvd`, and the states of every skin as `<name>-<skin>`. The time of writing is
/// recorded, so that it does not count as cost.
pub struct Fields {
    dir: PathBuf,
    name: String,
    what: Vec<FieldSpec>,
    frames: Vec<(f64, String)>,
    /// Name and frames of each skin
    skins: Vec<(String, Vec<(f64, String)>)>,
    /// Whether a state has been added
    begun: bool,
    failure: Option<MeshError>,
    spent: Spent,
}

impl Fields {
    pub fn new(dir: impl Into<PathBuf>, name: &str, what: &[FieldSpec]) -> Self {
        let (what, spent) = (what.to_vec(), Spent::default());
        let (dir, name, failure) = (dir.into(), name.into(), None);
        Self { dir, name, what, frames: vec![], skins: vec![], begun: false, failure, spent }
    }

    /// Continues the collections in the folder: takes over their states up to the time `until` \[s\], which a part of the run before a restart has
    /// written.
    pub fn go_on(&mut self, scene: &Scene, until: f64) {
        let earlier = |of: &str| -> Vec<(f64, String)> {
            let all = read_collection(&self.dir.join(format!("{of}.pvd"))).unwrap_or_default().into_iter();
            let there = all.filter(|(t, file)| *t <= until && file.is_file());
            there.filter_map(|(t, file)| Some((t, file.file_name()?.to_str()?.to_string()))).collect()
        };
        let frames = earlier(&self.name);
        let of_skin = |name: &String| (name.clone(), earlier(&format!("{}-{name}", self.name)));
        self.skins = scene.skins.iter().map(|skin| of_skin(&skin.name)).collect();
        self.frames = frames;
    }

    /// The folder into which the fields are written.
    pub fn folder(&self) -> &Path {
        &self.dir
    }

    /// Path of the collection, which exists once all states have been written.
    pub fn collection(&self) -> PathBuf {
        self.dir.join(format!("{}.pvd", self.name))
    }

    /// Writes the fields of the state with this number on the time grid. After a failure nothing more is written; [`Fields::finish`] reports it.
    pub fn add(&mut self, scene: &Scene, state: &State, number: usize) {
        if self.failure.is_some() {
            return;
        }
        let stopwatch = Stopwatch::start();
        let fields = scene.fields(state, &self.what);
        let (nodes, cells): (Vec<&Field>, Vec<&Field>) = fields.iter().partition(|f| f.at_nodes);
        let (nodes, cells): (Vec<Data>, Vec<Data>) =
            (nodes.into_iter().map(data).collect(), cells.into_iter().map(data).collect());
        let frame = format!("{}-{number:04}.vtu", self.name);
        self.failure = write_vtu(&self.dir.join(&frame), &scene.body.mesh, &nodes, &cells).err();
        self.frames.push((state.t, frame));
        if !std::mem::replace(&mut self.begun, true) {
            let written = self.write_regions(scene);
            self.failure = self.failure.take().or(written.err());
            if self.skins.is_empty() {
                self.skins = scene.skins.iter().map(|skin| (skin.name.clone(), vec![])).collect();
            }
        }
        for (skin, (name, frames)) in scene.skins.iter().zip(&mut self.skins) {
            let frame = format!("{}-{name}-{number:04}.vtu", self.name);
            let u = skin.displacement(&state.x);
            let data = Data { name: "displacement_m", components: 3, values: &u };
            let written = write_surface(&self.dir.join(&frame), &skin.surface, &[data]);
            self.failure = self.failure.take().or(written.err());
            frames.push((state.t, frame));
        }
        self.spent += stopwatch.spent();
    }

    /// Writes the regions as fields of 0 and 1: at the nodes and, for regions of cells, in the cells.
    fn write_regions(&self, scene: &Scene) -> Result<(), MeshError> {
        let mesh = TetMesh { regions: scene.regions.clone(), ..scene.body.mesh.clone() };
        let flags = |region: &Region| {
            let mut flags = vec![0.0; mesh.points.len()];
            mesh.nodes_of(region).iter().for_each(|&k| flags[k as usize] = 1.0);
            flags
        };
        let shown = scene.regions.iter().filter(|(name, _)| *name != "body");
        let at_nodes: Vec<(&String, Vec<f64>)> = shown.map(|(name, region)| (name, flags(region))).collect();
        let nodes: Vec<Data> = at_nodes.iter().map(|(name, values)| Data { name, components: 1, values }).collect();
        write_vtu(&self.dir.join(format!("{}-regions.vtu", self.name)), &mesh, &nodes, &[])
    }

    /// Writes the collection. Returns the time of all writing.
    pub fn finish(self) -> Result<Spent, MeshError> {
        let path = self.collection();
        match self.failure {
            Some(error) => Err(error),
            None => {
                for (name, frames) in &self.skins {
                    write_pvd(&self.dir.join(format!("{}-{name}.pvd", self.name)), frames)?;
                }
                write_pvd(&path, &self.frames)?;
                Ok(self.spent)
            }
        }
    }
}

fn data(field: &Field) -> Data<'_> {
    Data { name: field.name, components: field.components, values: &field.values }
}
