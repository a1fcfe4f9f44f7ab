//! Convergence analysis of stored cases: which mesh can be trusted, with what error bar, at what price.
//!
//! Pure: records and curves in, [`Analysis`] out; nothing is solved, read or written. The formulae are in
//! [`crate::study::estimate`], the errors of the cases in [`errors`], the sentences in [`verdict`] and [`warnings`].

pub mod errors;
pub mod figures;
pub mod report;
pub mod verdict;
pub mod warnings;

use crate::study::curve::{Curve, peak, starts_elsewhere};
use crate::study::estimate::curve::CurveStudy;
use crate::study::estimate::family::{Estimate, Level};
use crate::study::estimate::reference::Reference;
use crate::study::estimate::{curve, family, reference};
use crate::study::record::{CaseRecord, FamilyRecord, Quantity, Role, StoredCase, StudyRecord};
use errors::{CaseError, Noise, TimeStep};
use serde::Serialize;
use verdict::{Recommendation, Setting};

/// Quantities that decide which case is recommended, where a variant lists them; else all it lists.
pub const DECIDING: [&str; 2] = ["bending_angle_deg", "cable_tension_N"];

/// Everything that is said about a study.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Analysis {
    pub tolerance: f64,
    /// \[variants × quantities\]
    pub quantities: Vec<QuantityAnalysis>,
    /// Mesh + formulation, cheapest first
    pub settings: Vec<Setting>,
    pub recommended: Option<Recommendation>,
    /// Cases without a usable result: (id, what is wrong)
    pub incomplete: Vec<(String, String)>,
    /// `wall_s`, or `cpu_s` if any case ran beside another
    pub cost: &'static str,
    pub warnings: Vec<String>,
    /// In words, refusals included
    pub verdict: String,
}

/// One quantity in one variant.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct QuantityAnalysis {
    pub variant: String,
    /// The variant in words
    pub variant_label: String,
    pub quantity: Quantity,
    pub deciding: bool,
    /// Judged by its largest change, since it does not start at zero
    pub change: bool,
    /// One per family of meshes with two or more results
    pub estimates: Vec<Estimate>,
    /// (family, curves)
    pub curves: Vec<(String, CurveStudy)>,
    pub noise: Option<Noise>,
    pub time_step: Option<TimeStep>,
    pub reference: Option<Reference>,
    pub errors: Vec<CaseError>,
    /// A reference within the tolerance exists
    pub supported: bool,
    /// Why not, or what limits it
    pub reasons: Vec<String>,
    pub sentence: String,
}

impl QuantityAnalysis {
    pub fn estimate(&self, family: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.family == family)
    }

    /// The family the study is about.
    pub fn sizes(&self) -> Option<&Estimate> {
        self.estimates.iter().find(|e| e.role == Role::Sizes)
    }

    /// `peak bending angle, tension control`
    pub fn title(&self) -> String {
        let what = if self.change { "largest change of" } else { "peak" };
        format!("{what} {}, {}", self.quantity.label, self.variant_label)
    }
}

impl Analysis {
    pub fn find(&self, variant: &str, quantity: &str) -> Option<&QuantityAnalysis> {
        self.quantities.iter().find(|q| q.variant == variant && q.quantity.name == quantity)
    }

    /// The peak bending angle where it is not kinematic: under tension control if that was run.
    pub fn headline(&self) -> Option<&QuantityAnalysis> {
        self.find("tension", DECIDING[0])
            .filter(|q| !q.estimates.is_empty())
            .or_else(|| self.quantities.iter().find(|q| q.quantity.name == DECIDING[0] && !q.estimates.is_empty()))
            .or(self.quantities.first())
    }
}

/// The stored cases by family and variant.
pub struct Cases<'a> {
    pub study: &'a StudyRecord,
    pub stored: &'a [StoredCase],
    /// Time step of the mesh studies \[s\]
    pub dt_s: f64,
    pub shared: bool,
}

impl<'a> Cases<'a> {
    fn new(study: &'a StudyRecord, stored: &'a [StoredCase]) -> Self {
        let sizes = study.families.iter().find(|f| f.role == Role::Sizes).or(study.families.first());
        let of = |id: &String| stored.iter().find(|c| c.record.id == *id);
        let dt_s = sizes.and_then(|f| f.cases.iter().find_map(of)).map_or(f64::NAN, |c| c.record.dt_s);
        Self { study, stored, dt_s, shared: stored.iter().any(|c| c.record.shared) }
    }

    /// Converged cases of a family in a variant.
    pub fn of(&self, family: &FamilyRecord, variant: &str) -> Vec<&'a StoredCase> {
        (self.stored.iter())
            .filter(|c| c.record.converged() && c.record.variant == variant && family.cases.contains(&c.record.id))
            .collect()
    }

    /// Runs with the time step of the mesh studies.
    pub fn at_study_step(&self, c: &CaseRecord) -> bool {
        (c.dt_s / self.dt_s - 1.0).abs() < 1e-6
    }

    /// Price of a case \[s\].
    pub fn cost(&self, c: &CaseRecord) -> f64 {
        if self.shared { c.cpu_s } else { c.wall_s }
    }
}

/// Analyses what is there; cases that are missing or did not converge are named, not guessed.
pub fn analyse(study: &StudyRecord, stored: &[StoredCase]) -> Analysis {
    let cases = Cases::new(study, stored);
    let mut quantities = vec![];
    for variant in &study.variants {
        let listed = study.quantities.get(variant).map_or(&[][..], |q| q);
        let any = listed.iter().any(|q| DECIDING.contains(&q.name.as_str()));
        for quantity in listed {
            let deciding = !any || DECIDING.contains(&quantity.name.as_str());
            quantities.push(analyse_quantity(&cases, variant, quantity, deciding));
        }
    }
    let incomplete = study.incomplete(stored);
    let settings = verdict::settings(&cases, &quantities);
    for q in &mut quantities {
        q.sentence = verdict::sentence(&settings, q, study.tolerance);
    }
    let warnings = warnings::warnings(&cases, &quantities, &incomplete);
    let (recommended, verdict) = verdict::conclude(&cases, &quantities, &settings, &incomplete);
    let cost = if cases.shared { "cpu_s" } else { "wall_s" };
    Analysis { tolerance: study.tolerance, quantities, settings, recommended, incomplete, cost, warnings, verdict }
}

fn analyse_quantity(cases: &Cases, variant: &str, quantity: &Quantity, deciding: bool) -> QuantityAnalysis {
    let study = cases.study;
    let noise = errors::noise(cases, variant, &quantity.name);
    let (mut estimates, mut curves) = (vec![], vec![]);
    for f in &study.families {
        if matches!(f.role, Role::Seeds | Role::TimeStep) {
            continue;
        }
        let members = cases.of(f, variant);
        let level = |c: &&StoredCase| {
            Some(Level { id: c.record.id.clone(), h: c.record.mesh.h_m, f: peak(c, &quantity.name)? })
        };
        let scatter = noise.as_ref().filter(|n| n.formulation == f.formulation).map(|n| n.scatter);
        let levels = members.iter().filter_map(level).collect();
        estimates.extend(family::estimate((&f.name, f.role, &f.formulation), levels, scatter, study.tolerance));
        let mut series: Vec<_> = (members.iter())
            .filter_map(|c| Some((c.record.id.clone(), c.record.mesh.h_m, Curve::of(&c.series, &quantity.name)?)))
            .collect();
        series.sort_by(|a, b| a.1.total_cmp(&b.1));
        if series.len() >= 2 {
            let formal = family::formal_order(&f.formulation);
            curves.extend(curve::compare(&series, formal).map(|c| (f.name.clone(), c)));
        }
    }
    let of_variant = cases.stored.iter().filter(|c| c.record.variant == variant);
    let change = of_variant.filter_map(|c| Curve::of(&c.series, &quantity.name)).any(|c| starts_elsewhere(&c));
    let reference = reference::choose(&estimates);
    let errors = errors::errors(cases, variant, &quantity.name, reference.as_ref());
    let time_step = errors::time_step(cases, variant, &quantity.name, &estimates);
    let supported = reference.as_ref().is_some_and(|r| r.uncertainty <= study.tolerance * r.value.abs());
    let mut reasons = vec![];
    match &reference {
        None => reasons.push("no family of meshes has two converged cases".to_string()),
        Some(r) if !supported => {
            for e in &estimates {
                reasons.extend(e.reasons.iter().map(|reason| format!("{}: {reason}", e.family)));
            }
            if r.disagreement > study.tolerance * r.value.abs() {
                reasons.push("the families disagree by more than the tolerance".into());
            }
        }
        Some(r) => reasons.extend(
            r.others
                .iter()
                .filter(|o| !o.overlaps)
                .map(|o| format!("the interval of family {} does not overlap the one of {}", o.family, r.family)),
        ),
    }
    let quantity = quantity.clone();
    QuantityAnalysis {
        variant: variant.to_string(),
        variant_label: study.label(variant),
        quantity,
        deciding,
        change,
        estimates,
        curves,
        noise,
        time_step,
        reference,
        errors,
        supported,
        reasons,
        sentence: String::new(),
    }
}
