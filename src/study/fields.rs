//! Fields of a run for ParaView: a VTU file per state on the time grid and a PVD collection of them.

use crate::mesh::validate::MeshError;
use crate::mesh::vtu::{Data, write_pvd, write_surface, write_vtu};
use crate::scene::Scene;
use crate::system::State;
use cpu_time::ThreadTime;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Writes `<name>-0000.vtu`, … and `<name>.pvd`, and the same of every skin as `<name>-<skin>`. What writing took is kept, so that it does not count as a price.
pub struct Fields {
    dir: PathBuf,
    name: String,
    frames: Vec<(f64, String)>,
    /// Per skin: its name and its frames
    skins: Vec<(String, Vec<(f64, String)>)>,
    failure: Option<MeshError>,
    wall: Duration,
    cpu: Duration,
}

impl Fields {
    pub fn new(dir: impl Into<PathBuf>, name: &str) -> Self {
        let (wall, cpu) = (Duration::ZERO, Duration::ZERO);
        Self { dir: dir.into(), name: name.into(), frames: vec![], skins: vec![], failure: None, wall, cpu }
    }

    /// The collection, there when all states are.
    pub fn collection(&self) -> PathBuf {
        self.dir.join(format!("{}.pvd", self.name))
    }

    /// Displacement [m] and largest principal stretch [–] at the nodes. After a failure nothing more is written;
    /// [`Fields::finish`] reports it.
    pub fn add(&mut self, scene: &Scene, state: &State) {
        if self.failure.is_some() {
            return;
        }
        let (wall, cpu) = (Instant::now(), ThreadTime::now());
        let stretch = scene.nodal_stretch(&state.x);
        let data = [
            Data { name: "displacement_m", components: 3, values: &state.x[..3 * scene.body.mesh.points.len()] },
            Data { name: "stretch", components: 1, values: &stretch },
        ];
        let frame = format!("{}-{:04}.vtu", self.name, self.frames.len());
        self.failure = write_vtu(&self.dir.join(&frame), &scene.body.mesh, &data, &[]).err();
        let count = self.frames.len();
        self.frames.push((state.t, frame));
        if count == 0 {
            self.skins = scene.skins.iter().map(|skin| (skin.name.clone(), vec![])).collect();
        }
        for (skin, (name, frames)) in scene.skins.iter().zip(&mut self.skins) {
            let frame = format!("{}-{name}-{count:04}.vtu", self.name);
            let u = skin.displacement(&state.x);
            let data = Data { name: "displacement_m", components: 3, values: &u };
            let written = write_surface(&self.dir.join(&frame), &skin.surface, &[data]);
            self.failure = self.failure.take().or(written.err());
            frames.push((state.t, frame));
        }
        self.wall += wall.elapsed();
        self.cpu += cpu.elapsed();
    }

    /// Writes the collection. Returns the wall and CPU seconds that all writing took.
    pub fn finish(self) -> Result<(f64, f64), MeshError> {
        let path = self.collection();
        match self.failure {
            Some(error) => Err(error),
            None => {
                for (name, frames) in &self.skins {
                    write_pvd(&self.dir.join(format!("{}-{name}.pvd", self.name)), frames)?;
                }
                write_pvd(&path, &self.frames)?;
                Ok((self.wall.as_secs_f64(), self.cpu.as_secs_f64()))
            }
        }
    }
}
