//! Meshes: found by the hash of their request, else made now and kept.

use super::error::GenerateError;
use super::geometry_digest::{geometry_sha256, is_made};
use super::interpreter;
use super::manifest::Manifest;
use super::python::Mesher;
use super::request::{MeshRequest, Size, Source, TIME_LIMIT_S, conversion, without_field};
use crate::catalogue::{Home, Origin};
use crate::mesh::TetMesh;
use crate::mesh::read;
use crate::storage::{self, DATA_LIMIT};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A mesh with its manifest.
#[derive(Clone, PartialEq, Debug)]
pub struct Generated {
    pub mesh: TetMesh,
    pub manifest: Manifest,
    /// The first 16 hex digits of the hash of the request
    pub name: String,
    pub path: PathBuf,
    /// The mesher was called for it
    pub made: bool,
}

/// Where bodies and meshes are, and the Python that makes new ones.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct MeshStore {
    pub home: Home,
    pub python: PathBuf,
}

impl MeshStore {
    /// The meshes of the catalogue ([`Home::find`]). Python: DUROMETER_PYTHON, else that of the environment of the mesher, else the system's.
    pub fn find() -> Result<Self, GenerateError> {
        let home = Home::find()?;
        Ok(Self { python: interpreter::of(&home.environment), home })
    }

    /// The meshes of a project, made by this Python.
    pub fn of_project(folder: PathBuf, python: PathBuf) -> Self {
        Self { home: Home::project(folder, Origin::Named), python }
    }

    /// The same meshes without the mesher: one that is not stored is an error.
    #[must_use]
    pub fn stored_only(self) -> Self {
        // No program has the empty name
        Self { python: PathBuf::new(), ..self }
    }

    /// The mesher of this folder.
    pub fn mesher(&self) -> Mesher<'_> {
        Mesher { home: &self.home, python: &self.python }
    }

    /// Where the answer to a request is stored: committed with its body, else in the cache. None: nowhere yet.
    pub fn stored(&self, request: &MeshRequest) -> Result<Option<PathBuf>, GenerateError> {
        let (_, name) = request.resolve(&self.home.path)?;
        Ok(self.lookup(request, &name))
    }

    /// Name of the file of the answer to a request.
    pub fn file_name(&self, request: &MeshRequest) -> Result<String, GenerateError> {
        Ok(format!("{}.msh.gz", request.resolve(&self.home.path)?.1))
    }

    /// The numbers of cells that a request can ask for, with all else as in this one, and find stored; rising.
    pub fn stored_sizes(&self, request: &MeshRequest) -> Result<Vec<u64>, GenerateError> {
        let Some(Size::Cells { tolerance, .. }) = request.size else { return Ok(vec![]) };
        let mut counts = vec![];
        for folder in self.folders(request) {
            for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
                let mesh = entry.path();
                let is_mesh =
                    is_made(&entry.file_name().to_string_lossy()) && mesh.extension().is_some_and(|x| x == "gz");
                // A manifest that cannot be read is refused where the mesh is
                let manifest = is_mesh.then(|| read_manifest(&manifest_path(&mesh)).ok()).flatten();
                counts.extend(manifest.and_then(|manifest| manifest.request["size"]["cells"].as_u64()));
            }
        }
        counts.sort_unstable();
        counts.dedup();
        let stored = |count: &u64| {
            let request = MeshRequest { size: Some(Size::Cells { count: *count, tolerance }), ..request.clone() };
            self.stored(&request).map(|found| found.is_some())
        };
        let mut out = vec![];
        for count in counts {
            if stored(&count)? {
                out.push(count);
            }
        }
        Ok(out)
    }

    fn lookup(&self, request: &MeshRequest, name: &str) -> Option<PathBuf> {
        let files = self.folders(request).map(|folder| folder.join(format!("{name}.msh.gz")));
        // A power cut may have taken the name of one of the two
        let mut whole = files.into_iter().filter(|p| p.is_file() && manifest_path(p).is_file()).peekable();
        whole.peek()?;
        let now = self.geometry_sha256(request);
        whole.find(|path| {
            // A manifest that cannot be read is refused where the mesh is
            read_manifest(&manifest_path(path)).map_or(true, |manifest| manifest.geometry_sha256 == now)
        })
    }

    /// Digest of the Python of the body that is asked for.
    fn geometry_sha256(&self, request: &MeshRequest) -> Option<String> {
        match &request.source {
            Source::Body { name, .. } => geometry_sha256(&self.home.path, name),
            Source::File { .. } => None,
        }
    }

    /// The folders of committed and of made meshes.
    fn folders(&self, request: &MeshRequest) -> [PathBuf; 2] {
        [self.home.path.join("meshes").join(request.folder()), self.home.meshes.clone()]
    }

    /// The mesh of a request: a stored one, else made now and kept with the made meshes. `progress` gets the mesher's lines.
    pub fn mesh(&self, request: &MeshRequest, progress: &mut dyn FnMut(&str)) -> Result<Generated, GenerateError> {
        let (json, name) = request.resolve(&self.home.path)?;
        let stored = self.lookup(request, &name);
        let made = stored.is_none();
        let path = match stored {
            Some(path) => path,
            None => self.make(request, json, &name, progress)?,
        };
        let manifest = read_manifest(&manifest_path(&path))?;
        if !made {
            manifest.repairs.iter().for_each(|repair| progress(&format!("repaired: {repair}")));
        }
        Ok(Generated { mesh: read(&path, 1.0)?, manifest, name, path, made })
    }

    /// Keeps a mesh: as [`MeshStore::mesh`], then moved from the made meshes to `meshes/<body>`. Returns the mesh file.
    pub fn commit(&self, request: &MeshRequest, progress: &mut dyn FnMut(&str)) -> Result<PathBuf, GenerateError> {
        let folder = self.committed(request.folder())?;
        let generated = self.mesh(request, progress)?;
        let target = folder.join(format!("{}.msh.gz", generated.name));
        if target != generated.path {
            for (from, to) in
                [(manifest_path(&generated.path), manifest_path(&target)), (generated.path, target.clone())]
            {
                storage::keep(&from, &to).map_err(|e| GenerateError::io(&to, &e))?;
            }
        }
        Ok(target)
    }

    /// The volume mesh of a file in another format, in its units, as MSH: converted before, else now by the mesher, and kept with the made meshes.
    pub fn converted(
        &self,
        path: &Path,
        format: &str,
        progress: &mut dyn FnMut(&str),
    ) -> Result<PathBuf, GenerateError> {
        let (mut asked, name) = conversion(path, format)?;
        if let Some(file) = self.converted_file(&name) {
            return Ok(file);
        }
        let (folder, target) = self.places(&name)?;
        let part = folder.path().join(target.file_name().unwrap_or_default());
        asked["output"] = serde_json::json!(part);
        let label = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let answer = self.mesher().call(
            &serde_json::json!({ "convert": asked }),
            &format!("of {label}"),
            TIME_LIMIT_S,
            progress,
        );
        answer.and_then(|_| storage::keep(&part, &target).map_err(|e| GenerateError::io(&target, &e)))?;
        Ok(target)
    }

    /// Keeps a converted mesh: as [`MeshStore::converted`], then moved from the made meshes to `meshes/file`. Returns the mesh file.
    pub fn commit_converted(
        &self,
        path: &Path,
        format: &str,
        progress: &mut dyn FnMut(&str),
    ) -> Result<PathBuf, GenerateError> {
        let folder = self.committed("file")?;
        let made = self.converted(path, format, progress)?;
        let target = folder.join(made.file_name().unwrap_or_default());
        if target != made {
            storage::keep(&made, &target).map_err(|e| GenerateError::io(&target, &e))?;
        }
        Ok(target)
    }

    /// The folder of committed meshes of this name; the program's own takes none.
    fn committed(&self, name: &str) -> Result<PathBuf, GenerateError> {
        let folder = self.home.path.join("meshes").join(name);
        if self.home.origin == Origin::Program {
            return Err(GenerateError::NotKept { folder });
        }
        std::fs::create_dir_all(&folder).map_err(|e| GenerateError::io(&folder, &e))?;
        Ok(folder)
    }

    /// The volume mesh that this mesh file was converted to; none before.
    pub fn stored_conversion(&self, path: &Path, format: &str) -> Result<Option<PathBuf>, GenerateError> {
        let (_, name) = conversion(path, format)?;
        Ok(self.converted_file(&name))
    }

    /// A converted mesh: one that lies with the committed ones, else a made one.
    fn converted_file(&self, name: &str) -> Option<PathBuf> {
        let folders = [self.home.path.join("meshes/file"), self.home.meshes.clone()];
        folders.map(|folder| folder.join(format!("{name}.msh.gz"))).into_iter().find(|file| file.is_file())
    }

    /// A temporary folder in the cache, in which no other process writes, and where a mesh is kept under this name.
    fn places(&self, name: &str) -> Result<(TempDir, PathBuf), GenerateError> {
        let cache = &self.home.meshes;
        let folder = std::fs::create_dir_all(cache)
            .and_then(|()| tempfile::Builder::new().prefix(".").suffix(".part").tempdir_in(cache));
        let folder = folder.map_err(|e| GenerateError::io(cache, &e))?;
        Ok((folder, cache.join(format!("{name}.msh.gz"))))
    }

    /// Calls the mesher. It writes under a temporary name; the manifest is kept first, so a mesh has always one.
    fn make(
        &self,
        asked: &MeshRequest,
        mut json: serde_json::Value,
        name: &str,
        progress: &mut dyn FnMut(&str),
    ) -> Result<PathBuf, GenerateError> {
        let (folder, target) = self.places(name)?;
        let part = folder.path().join(target.file_name().unwrap_or_default());
        json["output"] = serde_json::json!(part);
        // As it is before the mesher reads it
        let geometry = self.geometry_sha256(asked);
        self.mesher().call(&json, name, asked.time_limit_s, progress).and_then(|answer| {
            let manifest = manifest_path(&target);
            let bad = |e: serde_json::Error| GenerateError::Manifest { file: manifest.clone(), fact: e.to_string() };
            let mut value: serde_json::Value = serde_json::from_str(&answer).map_err(bad)?;
            if let Some(request) = value.get_mut("request") {
                *request = without_field(request);
                if let Some(request) = request.as_object_mut() {
                    request.shift_remove("output");
                }
                without_folders(request);
            }
            if let (Some(geometry), Some(entries)) = (&geometry, value.as_object_mut()) {
                entries.insert("geometry_sha256".into(), geometry.clone().into());
            }
            // Nothing that cannot be read back is kept.
            serde_json::from_value::<Manifest>(value.clone()).map_err(bad)?;
            read(&part, 1.0)?;
            let text = serde_json::to_string_pretty(&value).map_err(bad)? + "\n";
            storage::write(&manifest, text.as_bytes()).map_err(|e| GenerateError::io(&manifest, &e))?;
            storage::keep(&part, &target).map_err(|e| GenerateError::io(&target, &e))?;
            Ok(target)
        })
    }
}

/// Leaves the name of a meshed file alone: its folder is one of this machine.
fn without_folders(request: &mut serde_json::Value) {
    let Some(path) = request.pointer_mut("/parameters/path") else { return };
    let name =
        path.as_str().and_then(|text| Path::new(text).file_name()).map(|name| name.to_string_lossy().into_owned());
    if let Some(name) = name {
        *path = name.into();
    }
}

/// The manifest next to a mesh file.
pub fn manifest_path(mesh: &Path) -> PathBuf {
    let text = mesh.to_string_lossy();
    let stem = text.strip_suffix(".gz").unwrap_or(&text);
    PathBuf::from(format!("{}.json", stem.strip_suffix(".msh").unwrap_or(stem)))
}

/// Reads a manifest.
pub fn read_manifest(path: &Path) -> Result<Manifest, GenerateError> {
    let bad = |fact: String| GenerateError::Manifest { file: path.to_path_buf(), fact };
    let text = storage::read_text(path, DATA_LIMIT).map_err(|e| bad(e.to_string()))?;
    serde_json::from_str(&text).map_err(|e| bad(e.to_string()))
}
