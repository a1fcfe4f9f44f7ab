//! A cable of a running reduced model: its length, and its contribution to the equations.

use crate::effect::Cable;
use crate::reduction::forces::{CableDrive, ReducedCable};
use crate::system::{BlockValues, EvalError, Want};

/// A cable with the workspace of its evaluations.
pub struct RunningCable {
    cable: Cable,
    /// W, row by row \[3 × guides, coordinates\]
    motion: Vec<f64>,
    coordinates: usize,
    pub drive: CableDrive,
    /// L \[m\]
    pub length: f64,
    /// \[coordinates\] ∂L/∂q
    pub gradient: Vec<f64>,
    /// \[3 × guides\]
    guides: Vec<f64>,
    along: Vec<f64>,
    values: BlockValues,
    /// \[6 × coordinates\]
    products: Vec<f64>,
}

impl RunningCable {
    pub fn new(of: &ReducedCable, coordinates: usize) -> Self {
        let rows = 3 * of.guides.len();
        Self {
            cable: of.cable(),
            motion: of.motion.clone(),
            coordinates,
            drive: of.drive.clone(),
            length: 0.0,
            gradient: vec![0.0; coordinates],
            guides: vec![0.0; rows],
            along: vec![0.0; rows],
            values: BlockValues::new(6),
            products: vec![0.0; 6 * coordinates],
        }
    }

    /// Computes the motions of the guides.
    fn place(&mut self, q: &[f64]) {
        for (w, row) in self.guides.iter_mut().zip(self.motion.chunks_exact(self.coordinates)) {
            *w = row.iter().zip(q).map(|(a, b)| a * b).sum();
        }
    }

    /// Computes the length and its gradient at the displacement coordinates q.
    pub fn evaluate(&mut self, q: &[f64]) -> Result<(), EvalError> {
        self.place(q);
        self.length = 0.0;
        self.along.fill(0.0);
        for s in 0..self.cable.segments() {
            self.cable.segment(&self.guides, s, 1.0, Want::Residual, &mut self.values)?;
            self.length += self.values.energy;
            for (a, end) in self.cable.ends(s).iter().enumerate() {
                (0..3).for_each(|i| self.along[3 * *end as usize + i] += self.values.r[3 * a + i]);
            }
        }
        self.gradient.fill(0.0);
        for (row, along) in self.motion.chunks_exact(self.coordinates).zip(&self.along) {
            self.gradient.iter_mut().zip(row).for_each(|(g, w)| *g += along * w);
        }
        Ok(())
    }

    /// Adds Σ ∂L/∂w · m times `factor` for other `motions` m of the guides, row by row \[3 × guides, tests\].
    pub fn add_along(&self, motions: &[f64], factor: f64, out: &mut [f64]) {
        let tests = out.len();
        for (row, along) in motions.chunks_exact(tests.max(1)).zip(&self.along) {
            out.iter_mut().zip(row).for_each(|(out, m)| *out += factor * along * m);
        }
    }

    /// Adds the tension times ∂²L/∂q² to K, whose rows have `stride` entries, column ≤ row; requires [`RunningCable::evaluate`] at the same position.
    pub fn add_hessian(&mut self, tension: f64, stride: usize, k: &mut [f64]) -> Result<(), EvalError> {
        let n = self.coordinates;
        for s in 0..self.cable.segments() {
            self.cable.segment(&self.guides, s, tension, Want::Tangent, &mut self.values)?;
            let ends = self.cable.ends(s);
            let size = 3 * ends.len();
            let row_of = |a: usize| 3 * ends[a / 3] as usize + a % 3;
            for a in 0..size {
                let product = &mut self.products[a * n..(a + 1) * n];
                product.fill(0.0);
                for b in 0..size {
                    let h = self.values.k[a.max(b) * size + a.min(b)];
                    let row = &self.motion[row_of(b) * n..][..n];
                    product.iter_mut().zip(row).for_each(|(p, w)| *p += h * w);
                }
            }
            for a in 0..size {
                let (row, product) = (&self.motion[row_of(a) * n..][..n], &self.products[a * n..][..n]);
                for (i, w) in row.iter().enumerate() {
                    k[i * stride..=i * stride + i].iter_mut().zip(product).for_each(|(k, p)| *k += w * p);
                }
            }
        }
        Ok(())
    }

    /// Returns g = free length + compliance · tension − L of a cable driven by length \[m\].
    pub fn gap(&self, inputs: &[f64], tension: f64) -> f64 {
        match &self.drive {
            CableDrive::Length { free, compliance } => free.at(inputs) + compliance * tension - self.length,
            CableDrive::Tension(_) => 0.0,
        }
    }

    /// Whether the cable is driven by length.
    pub fn by_length(&self) -> bool {
        matches!(self.drive, CableDrive::Length { .. })
    }
}
