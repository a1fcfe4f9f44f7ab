//! Weights of the balls of a body over which guides and forces act. Each is computed once for all scenes on the body: a search or a derivative builds a scene
//! many times.

use crate::math::tensor::Vec3;
use crate::math::threads::locked;
use crate::mesh::TetMesh;
use crate::mesh::ball::ball_weights;
use crate::mesh::embed::EmbedError;
use std::collections::HashMap;
use std::sync::Mutex;

/// (node, w)
type Weights = Vec<(u32, f64)>;

/// Weights by the bit patterns of centre and radius.
#[derive(Debug, Default)]
pub struct Patches {
    known: Mutex<HashMap<[u64; 4], Weights>>,
}

impl Patches {
    /// Weights (node, w) of the ball of `radius` \[m\] around `center` \[m\] in the mesh of the body.
    ///
    /// # Errors
    ///
    /// Where the ball contains nothing of the body, its diameter is less than a millionth of that of the body, or it cuts a cell that is too slender.
    pub fn weights(&self, mesh: &TetMesh, center: Vec3, radius: f64) -> Result<Vec<(u32, f64)>, EmbedError> {
        let key = [center.x, center.y, center.z, radius].map(f64::to_bits);
        if let Some(found) = locked(&self.known).get(&key) {
            return Ok(found.clone());
        }
        let weights = ball_weights(mesh, center, radius)?;
        locked(&self.known).insert(key, weights.clone());
        Ok(weights)
    }
}
