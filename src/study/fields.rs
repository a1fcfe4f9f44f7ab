//! Fields of a run for ParaView: a VTU file per state on the time grid and a PVD collection of them.

use crate::mesh::validate::MeshError;
use crate::mesh::vtu::{Data, write_pvd, write_vtu};
use crate::scene::Scene;
use crate::scene::output::{Field, FieldSpec};
use crate::system::State;
use cpu_time::ThreadTime;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// What is written where nothing is chosen.
pub const USUAL: [FieldSpec; 2] = [FieldSpec::Displacement, FieldSpec::Stretch];

/// Writes `<name>-0000.vtu`, … and `<name>.pvd`. What writing took is kept, so that it does not count as a price.
pub struct Fields {
    dir: PathBuf,
    name: String,
    what: Vec<FieldSpec>,
    frames: Vec<(f64, String)>,
    failure: Option<MeshError>,
    wall: Duration,
    cpu: Duration,
}

impl Fields {
    pub fn new(dir: impl Into<PathBuf>, name: &str, what: &[FieldSpec]) -> Self {
        let (wall, cpu) = (Duration::ZERO, Duration::ZERO);
        Self { dir: dir.into(), name: name.into(), what: what.to_vec(), frames: vec![], failure: None, wall, cpu }
    }

    /// The collection, there when all states are.
    pub fn collection(&self) -> PathBuf {
        self.dir.join(format!("{}.pvd", self.name))
    }

    /// The fields of a state, the one of this number on the time grid. After a failure nothing more is written;
    /// [`Fields::finish`] reports it.
    pub fn add(&mut self, scene: &Scene, state: &State, number: usize) {
        if self.failure.is_some() {
            return;
        }
        let (wall, cpu) = (Instant::now(), ThreadTime::now());
        let fields = scene.fields(state, &self.what);
        let (nodes, cells): (Vec<&Field>, Vec<&Field>) = fields.iter().partition(|f| f.at_nodes);
        let (nodes, cells): (Vec<Data>, Vec<Data>) =
            (nodes.into_iter().map(data).collect(), cells.into_iter().map(data).collect());
        let frame = format!("{}-{number:04}.vtu", self.name);
        self.failure = write_vtu(&self.dir.join(&frame), &scene.body.mesh, &nodes, &cells).err();
        self.frames.push((state.t, frame));
        self.wall += wall.elapsed();
        self.cpu += cpu.elapsed();
    }

    /// Writes the collection. Returns the wall and CPU seconds that all writing took.
    pub fn finish(self) -> Result<(f64, f64), MeshError> {
        let path = self.collection();
        match self.failure {
            Some(error) => Err(error),
            None => write_pvd(&path, &self.frames).map(|()| (self.wall.as_secs_f64(), self.cpu.as_secs_f64())),
        }
    }
}

fn data(field: &Field) -> Data<'_> {
    Data { name: field.name, components: field.components, values: &field.values }
}
