//! Members compared with a reference under one protocol: curve distances, differences of the peaks, hysteresis, cost.
//!
//! Pure: stored cases in, [`ComparisonFindings`] out. f is a quantity of a member, g the same of the reference:
//!
//! ```text
//! difference of the peaks (f̂ − ĝ)/|ĝ|
//! distance ‖f − g‖₂/‖g‖₂ and ‖f − g‖∞/|ĝ|       over the common time, see [`crate::study::curve`]
//! loop ∮ f dx over the last cycle of x          for f = T and x = L of a cable: the energy lost in a cycle
//! loop share |∮ f dx|/(Δf Δx)                    of the box around the cycle: 0 where loading and unloading agree
//! ```
//!
//! What the mesh does to a difference is the change of the difference on a finer mesh (family of role `finer`).

use crate::report::numbers::{capital, digits, percent, space, span};
use crate::study::analysis::{self, Analysis, ByQuantity};
use crate::study::curve::peak;
use crate::study::curve::{Curve, l2, lag};
use crate::study::kinds::comparison::sequence::{self, Sequence, sequences};
use crate::study::store::record::{Quantity, Role, StoredCase, StudyRecord};
use serde::{Deserialize, Serialize};

/// The member that the others are compared with, as it is stored with the study.
#[derive(Clone, Debug, Default, Serialize, Deserialize, PartialEq)]
pub struct ComparisonRecord {
    /// Empty where all families add up: each member is compared with the one before it
    #[serde(default)]
    pub reference: String,
}

/// Findings of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonFindings {
    /// The member that the others are compared with
    pub reference: String,
    /// \[variants × quantities\] those that the protocol imposes apart
    pub quantities: Vec<ByQuantity<MemberDifferences>>,
    pub costs: Vec<MemberCost>,
    /// Effects added one by one, per variant
    pub sequences: Vec<Sequence>,
}

/// The members in one quantity.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct MemberDifferences {
    /// Peak of the reference
    pub peak: f64,
    /// In the order of the study, the reference among them
    pub members: Vec<ComparedMember>,
}

/// One member against the reference.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct ComparedMember {
    pub member: String,
    pub case: String,
    pub peak: f64,
    /// (f̂ − ĝ)/|ĝ| \[–\]
    pub peak_difference: f64,
    /// Change of the difference on the finer mesh \[–\]
    pub mesh_drift: Option<f64>,
    /// ‖f − g‖₂/‖g‖₂ \[–\]
    pub distance: f64,
    /// ‖f − g‖∞/|ĝ| \[–\]
    pub largest: f64,
    /// Behind the reference \[s\]; none beyond first order
    pub lag_s: Option<f64>,
    /// ∮ f dx over the last cycle, unit of f times unit of x
    pub loop_area: Option<f64>,
    /// Of the box around the cycle \[–\]
    pub loop_share: Option<f64>,
}

/// Cost of a member, mean over the variants.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct MemberCost {
    pub member: String,
    pub formulation: String,
    pub cells: usize,
    pub dofs: usize,
    pub cpu_s: f64,
    /// Over the CPU time of the reference, where that has a result \[–\]
    pub ratio: Option<f64>,
    pub steps: usize,
    /// With those of refused steps
    pub newton_iterations: usize,
}

/// Analyses what is there; cases that are missing or did not converge are named.
pub fn analyse(
    study: &StudyRecord,
    comparison: &ComparisonRecord,
    stored: &[StoredCase],
) -> Analysis<ComparisonFindings> {
    let reference = comparison.reference.clone();
    let mut quantities =
        ByQuantity::each(study, stored, |variant, quantity| compare(study, stored, variant, quantity, &reference));
    quantities.retain(|q| q.members.len() < 2 || q.members.iter().any(|c| c.largest > 1e-9));
    let costs = costs(study, stored, &reference);
    let sequences = sequences(study, stored);
    let incomplete = study.incomplete(stored);
    for q in &mut quantities {
        q.sentence = sentence(study, q, &reference);
    }
    let found = ComparisonFindings { reference, quantities, costs, sequences };
    let verdict = match found.sequences.is_empty() {
        true => verdict(study, &found, incomplete.len()),
        false => sequence::verdict(&found.sequences, incomplete.len()),
    };
    Analysis { tolerance: study.tolerance, found, warnings: warnings(stored, &incomplete), incomplete, verdict }
}

/// Converged cases of the families with this role.
fn of_role<'a>(
    study: &'a StudyRecord,
    stored: &'a [StoredCase],
    role: Role,
    variant: &'a str,
) -> impl Iterator<Item = &'a StoredCase> {
    let families = study.families.iter().filter(move |f| f.role == role);
    let cases = families.flat_map(|f| &f.cases);
    cases
        .filter_map(|id| stored.iter().find(|c| c.record.id == *id))
        .filter(move |c| c.record.variant == variant && c.record.converged())
}

fn compare(
    study: &StudyRecord,
    stored: &[StoredCase],
    variant: &str,
    quantity: &Quantity,
    reference: &str,
) -> Option<MemberDifferences> {
    let cases: Vec<&StoredCase> = of_role(study, stored, Role::Members, variant).collect();
    let finer: Vec<&StoredCase> = of_role(study, stored, Role::Finer, variant).collect();
    let base = cases.iter().find(|c| c.record.member == reference)?;
    let (g, g_peak) = (Curve::of(&base.series, &quantity.name)?, peak(base, &quantity.name)?);
    let difference = |c: &StoredCase, g_peak: f64| Some((peak(c, &quantity.name)? - g_peak) / g_peak.abs());
    let finer_of = |member: &str| finer.iter().find(|c| c.record.member == member);
    let members = (cases.iter())
        .filter_map(|c| {
            let f = Curve::of(&c.series, &quantity.name)?;
            let t = f.common(&g);
            let d: Vec<f64> = t.iter().map(|t| f.at(*t) - g.at(*t)).collect();
            let on: Vec<f64> = t.iter().map(|t| g.at(*t)).collect();
            let peak_difference = difference(c, g_peak)?;
            let on_finer = finer_of(&c.record.member).zip(finer_of(reference));
            let on_finer = on_finer.and_then(|(c, base)| difference(c, peak(base, &quantity.name)?));
            let x = quantity.against.as_ref().and_then(|x| Curve::of(&c.series, &x.name));
            let cycle = x.as_ref().and_then(|x| f.hysteresis(x));
            Some(ComparedMember {
                member: c.record.member.clone(),
                case: c.record.id.clone(),
                peak: peak(c, &quantity.name)?,
                peak_difference,
                mesh_drift: on_finer.map(|d| (d - peak_difference).abs()),
                distance: l2(&t, &d) / l2(&t, &on),
                largest: d.iter().fold(0.0, |m: f64, d| m.max(d.abs())) / g_peak.abs(),
                lag_s: lag(&t, &d.iter().zip(&on).map(|(d, g)| d + g).collect::<Vec<_>>(), &on),
                loop_area: cycle.map(|c| c.0),
                loop_share: cycle.map(|c| c.1),
            })
        })
        .collect();
    Some(MemberDifferences { peak: g_peak, members })
}

fn costs(study: &StudyRecord, stored: &[StoredCase], reference: &str) -> Vec<MemberCost> {
    let all: Vec<&StoredCase> = study.variants.iter().flat_map(|v| of_role(study, stored, Role::Members, v)).collect();
    let mut members: Vec<&str> = vec![];
    for c in &all {
        if !members.contains(&c.record.member.as_str()) {
            members.push(&c.record.member);
        }
    }
    let mut costs: Vec<MemberCost> = (members.iter())
        .map(|member| {
            let own: Vec<_> = all.iter().map(|c| &c.record).filter(|r| r.member == *member).collect();
            MemberCost {
                member: member.to_string(),
                formulation: own[0].formulation.clone(),
                cells: own[0].mesh.cells,
                dofs: own[0].dofs,
                cpu_s: own.iter().map(|r| r.cpu_s).sum::<f64>() / own.len() as f64,
                ratio: None,
                steps: own.iter().map(|r| r.steps).sum::<usize>() / own.len(),
                newton_iterations: own.iter().map(|r| r.all_iterations()).sum::<usize>() / own.len(),
            }
        })
        .collect();
    let base = costs.iter().find(|p| p.member == reference).map(|p| p.cpu_s);
    costs.iter_mut().for_each(|p| p.ratio = base.map(|base| p.cpu_s / base));
    costs
}

/// `+3.2 %`
pub fn signed(x: f64) -> String {
    if x < 0.0 { format!("−{}", percent(-x)) } else { format!("+{}", percent(x)) }
}

fn sentence(study: &StudyRecord, q: &ByQuantity<MemberDifferences>, reference: &str) -> String {
    let tolerance = study.tolerance;
    let unit = space(&q.quantity.unit);
    let mut words =
        format!("{}: {:.*}{unit} with {}", capital(&q.peak_title()), digits(q.peak), q.peak, study.member(reference));
    let others: Vec<&ComparedMember> = q.members.iter().filter(|c| c.member != reference).collect();
    let (near, far): (Vec<_>, Vec<_>) = others.iter().partition(|c| c.peak_difference.abs() <= tolerance);
    let list = |members: &[&&ComparedMember]| {
        members
            .iter()
            .map(|c| format!("{} {}", study.member(&c.member), signed(c.peak_difference)))
            .collect::<Vec<_>>()
            .join(", ")
    };
    if !near.is_empty() {
        words += &format!("; within {}: {}", percent(tolerance), list(&near));
    }
    if !far.is_empty() {
        words += &format!("; beyond: {}", list(&far));
    }
    let drift = others.iter().filter_map(|c| c.mesh_drift).fold(f64::NAN, f64::max);
    if drift.is_finite() {
        words += &format!(". A finer mesh changes these differences by at most {}", percent(drift));
    }
    let lossy: Vec<String> = (q.members.iter())
        .filter_map(|c| {
            c.loop_share.filter(|s| *s > 0.01).map(|s| format!("{} {}", study.member(&c.member), percent(s)))
        })
        .collect();
    if let (Some(x), false) = (&q.quantity.against, lossy.is_empty()) {
        words += &format!(". Hysteresis against {}, of the box around a cycle: {}", x.label, lossy.join(", "));
    }
    words + "."
}

fn warnings(stored: &[StoredCase], incomplete: &[(String, String)]) -> Vec<String> {
    let mut out = analysis::warnings(incomplete);
    analysis::add_notes(&mut out, stored);
    if stored.iter().any(|c| c.record.shared) {
        out.push("Cases ran at the same time: costs are CPU seconds, and `--jobs 1` gives quieter ones.".into());
    }
    out
}

/// Which members are interchangeable, how far the others are off, what they cost.
fn verdict(study: &StudyRecord, a: &ComparisonFindings, missing: usize) -> String {
    let members: Vec<&str> = a.costs.iter().map(|p| p.member.as_str()).filter(|m| *m != a.reference).collect();
    if a.quantities.is_empty() || members.is_empty() {
        return format!(
            "No verdict: there is no pair of converged cases to compare with {} in a quantity that is not imposed.",
            study.member(&a.reference)
        );
    }
    let worst = |member: &str| {
        let own =
            a.quantities.iter().flat_map(|q| q.members.iter().filter(|c| c.member == member).map(move |c| (q, c)));
        own.max_by(|x, y| x.1.largest.total_cmp(&y.1.largest))
    };
    let mut same: Vec<String> = vec![];
    let mut apart: Vec<(f64, String)> = vec![];
    for member in members {
        let Some((q, c)) = worst(member) else { continue };
        if c.largest <= study.tolerance {
            same.push(format!("{} ({})", study.member(member), percent(c.largest)));
        } else {
            apart.push((
                c.largest,
                format!(
                    "{} by {} in the {}, {}",
                    study.member(member),
                    percent(c.largest),
                    q.quantity.label,
                    q.variant_label
                ),
            ));
        }
    }
    apart.sort_by(|x, y| y.0.total_cmp(&x.0));
    let apart: Vec<String> = apart.into_iter().map(|x| x.1).collect();
    let tolerance = percent(study.tolerance);
    let mut words = match same.is_empty() {
        true => format!(
            "No member can replace {} within {tolerance} of the peak in every curve.",
            study.member(&a.reference)
        ),
        false => {
            format!(
                "Within {tolerance} of the peak, in every curve, {} can replace {}.",
                same.join(", "),
                study.member(&a.reference)
            )
        }
    };
    if !apart.is_empty() {
        words += &format!(" At most they differ: {}.", apart.join("; "));
    }
    let ratios: Vec<(&str, f64)> = a.costs.iter().filter_map(|p| Some((p.member.as_str(), p.ratio?))).collect();
    let others: Vec<&(&str, f64)> = ratios.iter().filter(|(member, _)| *member != a.reference).collect();
    if let Some(times) = span(others.iter().map(|(_, ratio)| *ratio), |ratio| format!("{ratio:.2}")) {
        let who = match others[..] {
            [(member, _)] => study.member(member),
            _ => "Another member".into(),
        };
        words += &format!(" {} costs {times} times as much as {}.", capital(&who), study.member(&a.reference));
    }
    words + &analysis::without_result(missing)
}
