//! A scene assembled on its mesh, which is read or made once, in a thread of its own without the interpreter lock.

use crate::raised::{Raised, Turn};
use crate::solve::Link;
use durometer::material::KnownLaws;
use durometer::scene::{Body, RefinementWatch, SceneSpec, changed_scene, refine};
use durometer::study::store::record::CaseRecord;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// A scene assembled on its mesh, and the exceptions of its laws in Python.
#[derive(Clone)]
pub struct Built {
    pub scene: Arc<durometer::scene::Scene>,
    pub raised: Arc<Raised>,
    /// Why the refined mesh misses its tolerance, and the remedy
    pub missed: Option<String>,
    /// Time taken by the assembly \[s\]
    pub build_s: f64,
}

/// The failure of work in the separate thread.
pub type Failed = Box<dyn std::error::Error + Send + Sync>;

/// Reads or makes the mesh, refined if the scene asks for it, and assembles the scene with the laws that it knows.
pub fn assembled(file: &Path, text: &str, known_laws: &KnownLaws, link: &Arc<Link>) -> Result<Built, Failed> {
    let raised = Arc::new(Raised::default());
    let _turn = raised.begin(link).map(Turn::with_ending_laws);
    let (spec, text) = changed_scene(file, text, &[], known_laws)?;
    let (body, missed) = body(file, &spec, &text, link)?;
    let building = Instant::now();
    let scene = durometer::scene::Scene::build(file, spec, text, body)?;
    let build_s = building.elapsed().as_secs_f64();
    Ok(Built { scene: Arc::new(scene), raised: raised.clone(), missed, build_s })
}

impl Built {
    /// Does work on the scene, which an exception in one of its laws ends. If the scene has laws in Python and other work on it is in progress, the work
    /// is done on a copy with its own laws, so that exceptions are not mixed up.
    pub fn during<T>(&self, link: &Arc<Link>, work: impl FnOnce(&durometer::scene::Scene) -> T) -> Result<T, Failed> {
        if !self.raised.has_laws() {
            return Ok(work(&self.scene));
        }
        if let Some(_turn) = self.raised.begin(link) {
            return Ok(work(&self.scene));
        }
        let _turn = Raised::by(link);
        let durometer::scene::Scene { file, spec, text, body, .. } = &*self.scene;
        Ok(work(&durometer::scene::Scene::build(file, spec.clone(), text.clone(), body.clone())?))
    }
}

/// Returns the mesh, and if its refinement missed the tolerance, a description of what is missing.
fn body(file: &Path, spec: &SceneSpec, text: &str, link: &Arc<Link>) -> Result<(Arc<Body>, Option<String>), Failed> {
    let body = Arc::new(Body::load(file, &spec.mesh, &mut |_| {})?);
    let Some(wanted) = &spec.mesh.refine else { return Ok((body, None)) };
    let mut watch = RefinementWatch {
        step: &mut |_| {},
        mesher: &mut |_| {},
        progress: &mut |progress| link.progress(progress),
        stop: None,
    };
    let found = refine((file, spec, text), wanted, body, None, &mut watch)?;
    Ok((found.body.clone(), found.missed()))
}

/// A run with its record, which is made without the interpreter lock like the run itself: it evaluates laws, and uses threads that may wait for Python.
pub struct Done {
    pub run: durometer::scene::Run,
    pub record: Box<CaseRecord>,
}
