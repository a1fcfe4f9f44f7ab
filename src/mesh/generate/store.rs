//! The mesh store: meshes are found by the hash of their request, or else made and stored.

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

/// A mesh with its manifest and its file.
#[derive(Clone, PartialEq, Debug)]
pub struct Generated {
    pub mesh: TetMesh,
    pub manifest: Manifest,
    /// First 16 hex digits of the hash of the request
    pub name: String,
    pub path: PathBuf,
    /// Whether the mesher was called for it
    pub made: bool,
}

/// Location of bodies and meshes, and the Python that makes new meshes.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct MeshStore {
    pub home: Home,
    pub python: PathBuf,
}

impl MeshStore {
    /// Finds the meshes of the catalogue ([`Home::find`]). Python is DUROMETER_PYTHON, or else that of the environment of the mesher, or else that of
    /// the system.
    pub fn find() -> Result<Self, GenerateError> {
        let home = Home::find()?;
        Ok(Self { python: interpreter::of(&home.environment), home })
    }

    /// Uses the meshes of a project, made by this Python.
    pub fn of_project(folder: PathBuf, python: PathBuf) -> Self {
        Self { home: Home::project(folder, Origin::Named), python }
    }

    /// Disables the mesher: a mesh that is not stored is then an error.
    #[must_use]
    pub fn stored_only(self) -> Self {
        // No program has an empty name
        Self { python: PathBuf::new(), ..self }
    }

    /// Returns the mesher of this folder.
    pub fn mesher(&self) -> Mesher<'_> {
        Mesher { home: &self.home, python: &self.python }
    }

    /// Returns where the mesh of a request is stored: committed with its body, or else in the cache; `None` if it is not stored.
    pub fn stored(&self, request: &MeshRequest) -> Result<Option<PathBuf>, GenerateError> {
        let (_, name) = request.resolve(&self.home.path)?;
        Ok(self.lookup(request, &name))
    }

    /// Returns the file name of the mesh of a request.
    pub fn file_name(&self, request: &MeshRequest) -> Result<String, GenerateError> {
        Ok(format!("{}.msh.gz", request.resolve(&self.home.path)?.1))
    }

    /// Returns, in ascending order, the numbers of cells for which a mesh is stored that otherwise has the same request.
    pub fn stored_sizes(&self, request: &MeshRequest) -> Result<Vec<u64>, GenerateError> {
        let Some(Size::Cells { tolerance, .. }) = request.size else { return Ok(vec![]) };
        let mut counts = vec![];
        for folder in self.folders(request) {
            for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
                let mesh = entry.path();
                let is_mesh =
                    is_made(&entry.file_name().to_string_lossy()) && mesh.extension().is_some_and(|x| x == "gz");
                // An unreadable manifest is refused when the mesh is used
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
        // A power failure may have removed one of the two files
        let mut whole = files.into_iter().filter(|p| p.is_file() && manifest_path(p).is_file()).peekable();
        whole.peek()?;
        let now = self.geometry_sha256(request);
        whole.find(|path| {
            // An unreadable manifest is refused when the mesh is used
            read_manifest(&manifest_path(path)).map_or(true, |manifest| manifest.geometry_sha256 == now)
        })
    }

    /// Returns the digest of the Python code of the requested body.
    fn geometry_sha256(&self, request: &MeshRequest) -> Option<String> {
        match &request.source {
            Source::Body { name, .. } => geometry_sha256(&self.home.path, name),
            Source::File { .. } => None,
        }
    }

    /// Returns the folders of committed and of generated meshes.
    fn folders(&self, request: &MeshRequest) -> [PathBuf; 2] {
        [self.home.path.join("meshes").join(request.folder()), self.home.meshes.clone()]
    }

    /// Returns the mesh of a request: a stored one, or else one that is made now and stored with the generated meshes. `progress` receives the
    /// mesher's lines.
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

    /// Commits a mesh: obtains it as [`MeshStore::mesh`] does, then moves it from the generated meshes to `meshes/<body>`. Returns the mesh file.
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

    /// Returns the volume mesh of a file in another format, in its units, as MSH: converted earlier, or else now by the mesher and stored with the
    /// generated meshes.
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

    /// Commits a converted mesh: obtains it as [`MeshStore::converted`] does, then moves it from the generated meshes to `meshes/file`. Returns the
    /// mesh file.
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

    /// Returns the folder of committed meshes of this name; the folder of the program itself accepts none.
    fn committed(&self, name: &str) -> Result<PathBuf, GenerateError> {
        let folder = self.home.path.join("meshes").join(name);
        if self.home.origin == Origin::Program {
            return Err(GenerateError::NotKept { folder });
        }
        std::fs::create_dir_all(&folder).map_err(|e| GenerateError::io(&folder, &e))?;
        Ok(folder)
    }

    /// Returns the volume mesh to which this mesh file was converted; `None` if it was not.
    pub fn stored_conversion(&self, path: &Path, format: &str) -> Result<Option<PathBuf>, GenerateError> {
        let (_, name) = conversion(path, format)?;
        Ok(self.converted_file(&name))
    }

    /// Returns a converted mesh: one stored with the committed meshes, or else a generated one.
    fn converted_file(&self, name: &str) -> Option<PathBuf> {
        let folders = [self.home.path.join("meshes/file"), self.home.meshes.clone()];
        folders.map(|folder| folder.join(format!("{name}.msh.gz"))).into_iter().find(|file| file.is_file())
    }

    /// Returns a temporary folder in the cache, in which no other process writes, and the path at which a mesh of this name is stored.
    fn places(&self, name: &str) -> Result<(TempDir, PathBuf), GenerateError> {
        let cache = &self.home.meshes;
        let folder = std::fs::create_dir_all(cache)
            .and_then(|()| tempfile::Builder::new().prefix(".").suffix(".part").tempdir_in(cache));
        let folder = folder.map_err(|e| GenerateError::io(cache, &e))?;
        Ok((folder, cache.join(format!("{name}.msh.gz"))))
    }

    /// Calls the mesher, which writes under a temporary name. The manifest is stored first, so that every stored mesh has one.
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
        // Its state before the mesher reads it
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
            // Nothing that cannot be read back is stored.
            serde_json::from_value::<Manifest>(value.clone()).map_err(bad)?;
            read(&part, 1.0)?;
            let text = serde_json::to_string_pretty(&value).map_err(bad)? + "\n";
            storage::write(&manifest, text.as_bytes()).map_err(|e| GenerateError::io(&manifest, &e))?;
            storage::keep(&part, &target).map_err(|e| GenerateError::io(&target, &e))?;
            Ok(target)
        })
    }
}

/// Reduces the path of a meshed file to its name: its folder is specific to this machine.
fn without_folders(request: &mut serde_json::Value) {
    let Some(path) = request.pointer_mut("/parameters/path") else { return };
    let name =
        path.as_str().and_then(|text| Path::new(text).file_name()).map(|name| name.to_string_lossy().into_owned());
    if let Some(name) = name {
        *path = name.into();
    }
}

/// Returns the path of the manifest next to a mesh file.
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
