//! Closed forms of the response of a series in each test, linear in its factors.
//!
//! With the relaxation function R(t) = c₀ + Σ cᵢ e^{−t/τᵢ} and the response y of a test, y = c₀ φ₀ + Σ cᵢ φ(τᵢ):
//!
//! | test | φ₀ | φ(τ) |
//! |---|---|---|
//! | relaxation, step at t = 0 | 1 | e^{−t/τ} |
//! | relaxation, strain proportional to t up to r | min(t/r, 1) | (τ/r)(1 − e^{−t/τ}) up to r, then (τ/r)(1 − e^{−r/τ}) e^{−(t−r)/τ} |
//! | history of strain e | e | ∫ e^{−(t−s)/τ} de(s), exact between data points where e is linear |
//! | dynamic | 1 and 0 | ω²τ²/(1 + ω²τ²) and ωτ/(1 + ω²τ²) |
//! | creep | as in relaxation, with the stress in place of the strain | φ₀ minus the φ(τ) of relaxation |
//!
//! In creep the series consists of compliances, J(t) = c₀ + Σ cᵢ(1 − e^{−t/τᵢ}); `retardation` turns it into one of moduli.
//!
//! At finite strain with a law, uniaxial and incompressible, the history variables are those of the effect `viscoelastic`: its stress S̃ is diag(a,
//! b, b) with a = ⅔ P/λ and b = −⅓ λ² P, P the elastic nominal stress, and an arm with the history stress h has the nominal stress λ h_a − h_b/λ², so
//! that φ(τ) = λ ∫ e^{−(t−s)/τ} da − λ⁻² ∫ e^{−(t−s)/τ} db. At a held stretch after a step φ(τ) = P e^{−t/τ}.
//!
//! Sources: Ferry, *Viscoelastic Properties of Polymers*, 1980, ch. 3; Simo, CMAME 60, 1987. Zapas & Phillips (J. Res. NBS 75A, 1971) shift the time
//! by half the ramp instead, which is exact for slow terms only.

use nalgebra::DVector;
use serde::Serialize;

/// The test that gave the data.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TestKind {
    /// Stress, force or modulus over time at a held strain
    Relaxation,
    /// Strain over time under a held stress
    Creep,
    /// Stress over a measured strain, both over time: loading, unloading, holding
    History,
    /// Storage and loss modulus over frequency
    Dynamic,
}

impl TestKind {
    pub const ALL: [Self; 4] = [Self::Relaxation, Self::Creep, Self::History, Self::Dynamic];

    /// Name in files and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Relaxation => "relaxation",
            Self::Creep => "creep",
            Self::History => "history",
            Self::Dynamic => "dynamic",
        }
    }

    /// Name of the measured values whose errors are fitted.
    pub(super) fn responses(self) -> &'static str {
        match self {
            Self::Relaxation | Self::History => "stresses",
            Self::Creep => "strains",
            Self::Dynamic => "moduli",
        }
    }
}

impl std::str::FromStr for TestKind {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|k| k.name() == word).ok_or_else(|| {
            let known: Vec<&str> = Self::ALL.iter().map(|k| k.name()).collect();
            format!("\"{word}\" is not a kind of experiment; known: {}", known.join(", "))
        })
    }
}

/// Load of an arm in a test with a measured strain: the sum over its parts of `by` times the convolution of `path`.
#[derive(Clone, PartialEq, Debug)]
pub struct Driven {
    /// (path, by), both at the data points
    pub parts: Vec<(Vec<f64>, Vec<f64>)>,
    /// Elastic response at the data points
    pub elastic: Vec<f64>,
}

/// Data of a test in SI units, ready for a fit.
#[derive(Clone, PartialEq, Debug)]
pub struct Record {
    pub kind: TestKind,
    /// Name of the file
    pub file: String,
    /// SHA-256 of its bytes; empty for data that do not come from a file
    pub sha256: String,
    /// t \[s\] from the beginning of the loading, ascending; for a dynamic test ω \[rad/s\]
    pub x: Vec<f64>,
    /// Response; for a dynamic test the storage moduli followed by the loss moduli
    pub y: Vec<f64>,
    /// Duration of the loading at a constant rate \[s\]; 0 for a step
    pub ramp: f64,
    /// The measured load, in a test with a measured strain
    pub driven: Option<Driven>,
    /// Unit of the factors: `Pa`, `N`, `1`, or `of the law`
    pub unit: String,
    /// Held stress of a creep test \[Pa\], if it is known
    pub stress: Option<f64>,
    /// Notes on reading and on changes
    pub notes: Vec<String>,
    /// Records of further specimens in the same test, which have no further ones themselves
    pub more: Vec<Record>,
}

impl Record {
    /// This specimen and the further ones.
    pub fn specimens(&self) -> impl Iterator<Item = &Self> {
        std::iter::once(self).chain(&self.more)
    }

    /// Responses of all specimens.
    pub fn values(&self) -> DVector<f64> {
        DVector::from_vec(self.specimens().flat_map(|r| r.y.iter().copied()).collect())
    }

    /// Specimen of each value, counted from 0.
    pub fn specimen_of_rows(&self) -> Vec<usize> {
        self.specimens().enumerate().flat_map(|(k, r)| vec![k; r.y.len()]).collect()
    }

    /// Values of each curve: one curve for each specimen, or storage and loss.
    pub fn curves(&self) -> Vec<Vec<usize>> {
        let mut found = vec![];
        let mut from = 0;
        for r in self.specimens() {
            let n = r.x.len();
            found.push((from..from + n).collect());
            if self.kind == TestKind::Dynamic {
                found.push((from + n..from + 2 * n).collect());
            }
            from += r.y.len();
        }
        found
    }

    /// Shortest and longest time \[s\] that the data resolve.
    pub fn span(&self) -> [f64; 2] {
        let of = |x: f64| if self.kind == TestKind::Dynamic { 1.0 / x } else { x };
        let positive = self.specimens().flat_map(|r| &r.x).copied().filter(|x| *x > 0.0).map(of);
        positive.fold([f64::INFINITY, 0.0], |[a, b], t| [a.min(t), b.max(t)])
    }

    /// φ(τ) at every value of all specimens; φ₀ for `None`.
    pub fn column(&self, tau: Option<f64>) -> DVector<f64> {
        if self.more.is_empty() {
            return self.own_column(tau);
        }
        let own = |r: &Self| r.own_column(tau).iter().copied().collect::<Vec<_>>();
        DVector::from_vec(self.specimens().flat_map(own).collect())
    }

    fn own_column(&self, tau: Option<f64>) -> DVector<f64> {
        match self.kind {
            TestKind::Relaxation => {
                DVector::from_iterator(self.x.len(), self.x.iter().map(|t| held(*t, self.ramp, tau)))
            }
            TestKind::Creep => {
                let one = |t: &f64| match tau {
                    None => held(*t, self.ramp, None),
                    tau => held(*t, self.ramp, None) - held(*t, self.ramp, tau),
                };
                DVector::from_iterator(self.x.len(), self.x.iter().map(one))
            }
            TestKind::Dynamic => {
                let part = |loss: bool| {
                    self.x.iter().map(move |omega| match tau {
                        None => f64::from(u8::from(!loss)),
                        Some(tau) => {
                            let w = omega * tau;
                            if loss { w / (1.0 + w * w) } else { w * w / (1.0 + w * w) }
                        }
                    })
                };
                DVector::from_iterator(2 * self.x.len(), part(false).chain(part(true)))
            }
            TestKind::History => {
                let driven = self.driven.as_ref().expect("a history has what drives it");
                let Some(tau) = tau else { return DVector::from_column_slice(&driven.elastic) };
                let mut sum = DVector::zeros(self.x.len());
                for (path, by) in &driven.parts {
                    let memory = convolved(&self.x, path, tau);
                    sum.iter_mut().zip(memory.iter().zip(by)).for_each(|(s, (h, by))| *s += h * by);
                }
                sum
            }
        }
    }

    /// This record with some of its data points; `rows` gives their indices into `x` for each specimen.
    pub fn thinned(&self, rows: &dyn Fn(&Self) -> Vec<usize>) -> Self {
        let more = self.more.iter().map(|r| r.thinned(rows)).collect();
        let (n, rows) = (self.x.len(), rows(self));
        let pick = |v: &[f64], from: usize| rows.iter().map(|k| v[from + k]).collect::<Vec<f64>>();
        let mut y = pick(&self.y, 0);
        if self.kind == TestKind::Dynamic {
            y.extend(pick(&self.y, n));
        }
        Self { x: pick(&self.x, 0), y, more, ..self.clone() }
    }
}

/// φ of a strain that is proportional to t up to the end of the ramp and is then held; `None`: without relaxation.
fn held(t: f64, ramp: f64, tau: Option<f64>) -> f64 {
    let Some(tau) = tau else { return if ramp > 0.0 { (t / ramp).min(1.0) } else { 1.0 } };
    match ramp {
        0.0 => (-t / tau).exp(),
        r if t < r => -tau / r * (-t / tau).exp_m1(),
        r => -tau / r * (-r / tau).exp_m1() * (-(t - r) / tau).exp(),
    }
}

/// ∫ e^{−(t−s)/τ} dp(s) at the times of p, which is linear in between; before the first time p is zero, so that it jumps there.
fn convolved(t: &[f64], p: &[f64], tau: f64) -> Vec<f64> {
    let mut h = p[0];
    let mut out = vec![h];
    for k in 1..t.len() {
        let x = (t[k] - t[k - 1]) / tau;
        // (1 − e^{−x})/x → 1
        let mean = if x < 1e-8 { 1.0 - 0.5 * x } else { -(-x).exp_m1() / x };
        h = (-x).exp() * h + (p[k] - p[k - 1]) * mean;
        out.push(h);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(kind: TestKind, x: Vec<f64>, ramp: f64) -> Record {
        let y = vec![0.0; x.len()];
        let driven = None;
        Record {
            kind,
            file: "test".into(),
            sha256: String::new(),
            x,
            y,
            ramp,
            driven,
            unit: "Pa".into(),
            stress: None,
            notes: vec![],
            more: vec![],
        }
    }

    /// The ramp as a limit of many small steps: the sum over 20 000 steps at the midpoints of their intervals equals the integral to 1e-8.
    #[test]
    fn a_ramp_is_a_sequence_of_steps() {
        let (ramp, tau, n) = (0.7, 0.3, 20_000);
        for t in [0.2, 0.7, 1.9] {
            let steps = (0..n).map(|k| ramp * (f64::from(k) + 0.5) / f64::from(n)).filter(|s| *s < t);
            let sum: f64 = steps.map(|s| (-(t - s) / tau).exp()).sum::<f64>() / f64::from(n);
            let own = record(TestKind::Relaxation, vec![t], ramp).column(Some(tau))[0];
            assert!((own - sum).abs() < 2e-4, "t = {t}: {own}, {sum}");
            if t >= ramp {
                assert!((own - sum).abs() < 1e-8, "t = {t}: {own}, {sum}");
            }
        }
    }

    /// A measured strain that is a ramp has the response of the ramp, independently of the data points.
    #[test]
    fn a_history_of_a_ramp_is_the_ramp() {
        let t: Vec<f64> = vec![0.0, 0.1, 0.35, 0.5, 0.9, 2.0, 10.0];
        let e: Vec<f64> = t.iter().map(|t| (t / 0.5_f64).min(1.0)).collect();
        let mut history = record(TestKind::History, t.clone(), 0.0);
        history.driven = Some(Driven { parts: vec![(e.clone(), vec![1.0; e.len()])], elastic: e });
        let ramp = record(TestKind::Relaxation, t, 0.5);
        for tau in [1e-3, 0.4, 7.0, 1e9] {
            let difference = (history.column(Some(tau)) - ramp.column(Some(tau))).amax();
            assert!(difference < 1e-14, "τ = {tau}: {difference:e}");
        }
    }

    /// Creep is the complement of relaxation, and the moduli are those of a Maxwell element at ωτ = 1.
    #[test]
    fn creep_and_dynamic_columns() {
        let t = vec![0.0, 0.3, 4.0];
        let (creep, relaxation) = (record(TestKind::Creep, t.clone(), 0.2), record(TestKind::Relaxation, t, 0.2));
        let sum = creep.column(Some(0.8)) + relaxation.column(Some(0.8));
        assert!((sum - creep.column(None)).amax() < 1e-15);
        let dynamic = record(TestKind::Dynamic, vec![2.0], 0.0);
        assert_eq!(dynamic.column(Some(0.5)).as_slice(), [0.5, 0.5]);
        assert_eq!(dynamic.column(None).as_slice(), [1.0, 0.0]);
    }
}
