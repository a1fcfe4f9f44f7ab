//! Members compared with a reference under one protocol: curve distances, differences of the peaks, hysteresis, cost.
//!
//! Pure: stored cases in, [`ComparisonFindings`] out. f is a quantity of a member, g the same quantity of the reference:
//!
//! ```text
//! difference of the peaks (f̂ − ĝ)/ĝ             difference of the magnitudes if the signs agree, below −1 if they differ
//! distance ‖f − g‖₂/‖g − g₀‖₂ and ‖f − g‖∞/|ĝ|       on the samples of both, see [`crate::study::curve`]
//! loop ∮ f dx over the last cycle of x          for f = T and x = L of a cable: the energy lost in a cycle
//! loop share |∮ f dx|/(Δf Δx)                    of the box around the cycle: 0 where loading and unloading agree
//! ```
//!
//! Differences are relative to the scale of the tolerance ([`Tolerance`]), which is |ĝ| unless the absolute tolerance of the quantity is larger; the
//! text then gives the difference and the tolerance in the unit.
//!
//! A member cannot be compared with the reference if one of the two has no result, or if their runs do not cover the same time.
//!
//! The effect of the mesh on a difference is judged by its change on a finer mesh (family of role `finer`).

use crate::report::numbers::{capital, digits, percent, readable, significant, space, span};
use crate::study::analysis::{self, Analysis, ByQuantity};
use crate::study::curve::peak;
use crate::study::curve::{Curve, l2, lag};
use crate::study::estimate::tolerance::Tolerance;
use crate::study::kinds::comparison::findings::{
    ComparedMember, ComparisonFindings, ComparisonRecord, Incomparable, MemberCost, MemberDifferences,
};
use crate::study::kinds::comparison::sequence::{self, sequences};
use crate::study::kinds::comparison::{finer, samples};
use crate::study::store::record::{Member, Role, StoredCase, StudyQuantity, StudyRecord};
use crate::wording::few;
use std::collections::BTreeMap;

/// Analyses the stored cases; cases that are missing or did not converge are named.
pub fn analyse(
    study: &StudyRecord,
    comparison: &ComparisonRecord,
    stored: &[StoredCase],
) -> Analysis<ComparisonFindings> {
    let reference = comparison.reference.clone();
    let mut incomparable = vec![];
    let mut quantities = ByQuantity::each(study, stored, |variant, quantity| {
        compare((study, stored), variant, quantity, &reference, &mut incomparable)
    });
    quantities.retain(|q| {
        let imposed = is_imposed(q, &reference, study.tolerance);
        incomparable.retain(|i| !imposed || i.variant != q.variant || i.quantity != q.quantity.name);
        !imposed
    });
    let costs = costs(study, stored, &reference);
    let sequences = sequences(study, stored);
    let incomplete = study.incomplete(stored);
    for q in &mut quantities {
        let missing = incomparable.iter().filter(|i| i.variant == q.variant && i.quantity == q.quantity.name);
        q.sentence = sentence(study, q, &reference, &missing.collect::<Vec<_>>());
    }
    let found = ComparisonFindings { reference, quantities, incomparable, costs, sequences };
    let verdict = match found.sequences.is_empty() {
        true => verdict(study, &found, incomplete.len()),
        false => sequence::verdict(study, &found.sequences, incomplete.len()),
    };
    let mut warnings = warnings(stored, &incomplete);
    warnings.extend(finer::warning(study, &found));
    Analysis { tolerance: study.tolerance, found, warnings, incomplete, verdict }
}

/// The case of a member.
fn find<'a>(all: &[Member<'a>], member: &str) -> Option<&'a StoredCase> {
    all.iter().find(|(name, _)| *name == member)?.1
}

/// Compares all members in one quantity; those that cannot be compared are added to `incomparable`.
fn compare(
    (study, stored): (&StudyRecord, &[StoredCase]),
    variant: &str,
    quantity: &StudyQuantity,
    reference: &str,
    incomparable: &mut Vec<Incomparable>,
) -> Option<MemberDifferences> {
    let all = study.members_in(stored, Role::Members, variant);
    let finer = study.members_in(stored, Role::Finer, variant);
    let tolerance = quantity.tolerance(study.tolerance);
    let base = Base::new(study.member(reference), find(&all, reference), quantity, tolerance);
    let finer_peak = |member: &str| peak(find(&finer, member)?, &quantity.name);
    let on_finer = |member: &str| {
        finer_peak(member).zip(finer_peak(reference)).map(|(f, g)| (f - g) / with_sign_of(g, tolerance.scale(g)))
    };
    let mut members = vec![];
    for (member, case) in all {
        match base.as_ref().map_err(Clone::clone).and_then(|base| base.compare(case, quantity)) {
            Ok(mut found) => {
                found.member = member.into();
                let drift = on_finer(member).map(|d| (d - found.peak_difference).abs());
                found.mesh_drift = drift.filter(|drift| drift.is_finite());
                members.push(found);
            }
            Err(_) if member == reference => {}
            Err(why) => incomparable.push(Incomparable {
                variant: variant.into(),
                quantity: quantity.name.clone(),
                place: format!("{}, {}", quantity.label, study.label(variant)),
                member: member.into(),
                why,
            }),
        }
    }
    Some(MemberDifferences { peak: base.ok()?.peak, members })
}

/// The reference in one quantity.
struct Base {
    /// Name of the member in words
    name: String,
    curve: Curve,
    peak: f64,
    tolerance: Tolerance,
}

impl Base {
    /// # Errors
    ///
    /// The reason, in words, why nothing can be compared with it.
    fn new(
        name: String,
        case: Option<&StoredCase>,
        quantity: &StudyQuantity,
        tolerance: Tolerance,
    ) -> Result<Self, String> {
        let Some(case) = case else { return Err(format!("{name} has no result there")) };
        match (Curve::of(&case.series, &quantity.name), peak(case, &quantity.name)) {
            (Some(curve), Some(peak)) => Ok(Self { name, curve, peak, tolerance }),
            _ => Err(format!("{name} has no curve of it")),
        }
    }

    /// Compares a member with the reference on the samples of both.
    ///
    /// # Errors
    ///
    /// The reason, in words, why it cannot be compared.
    fn compare(&self, case: Option<&StoredCase>, quantity: &StudyQuantity) -> Result<ComparedMember, String> {
        let c = case.ok_or("it has no result there")?;
        let (f, g) = (Curve::of(&c.series, &quantity.name).ok_or("it has no curve of it")?, &self.curve);
        let own_peak = peak(c, &quantity.name).ok_or("it has no curve of it")?;
        let Some(t) = samples::of_both(&f, g) else {
            let [[a, b], [c, d]] = [samples::span(&f), samples::span(g)];
            return Err(format!("its curve is from {a} s to {b} s, that of {} from {c} s to {d} s", self.name));
        };
        let d: Vec<f64> = t.iter().map(|t| f.at(*t) - g.at(*t)).collect();
        let [of_f, of_g]: [Vec<f64>; 2] = [&f, g].map(|curve| t.iter().map(|t| curve.at(*t)).collect());
        let changes: Vec<f64> = of_g.iter().map(|value| value - g.start()).collect();
        let largest = d.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
        let nothing = largest == 0.0;
        let scale = self.tolerance.scale(self.peak);
        if scale == 0.0 && !nothing {
            return Err(format!("the peak of {} is zero, so that no difference is a share of it", self.name));
        }
        let share = |difference: f64, size: f64| if nothing { 0.0 } else { difference / size };
        let x = quantity.against.as_ref().and_then(|x| Curve::of(&c.series, &x.name));
        let cycle = x.as_ref().and_then(|x| f.hysteresis(x));
        Ok(ComparedMember {
            member: String::new(),
            case: c.record.id.clone(),
            peak: own_peak,
            peak_difference: share(own_peak - self.peak, with_sign_of(self.peak, scale)),
            mesh_drift: None,
            distance: share(l2(&t, &d), l2(&t, &changes).max(self.tolerance.scale(0.0))),
            largest: share(largest, scale),
            lag_s: lag(&t, &of_f, &of_g),
            loop_area: cycle.map(|c| c.0),
            loop_share: cycle.map(|c| c.1),
        })
    }
}

/// Gives a size the sign of a peak.
fn with_sign_of(peak: f64, size: f64) -> f64 {
    if peak < 0.0 { -size } else { size }
}

/// Whether the protocol imposes a quantity: there are several runs, and it is the same in all of them.
fn is_imposed(q: &ByQuantity<MemberDifferences>, reference: &str, tolerance: f64) -> bool {
    let scale = q.quantity.tolerance(tolerance).scale(q.peak);
    let base = q.members.iter().find(|c| c.member == reference).map(|c| &c.case);
    let mut others = q.members.iter().filter(|c| Some(&c.case) != base).peekable();
    others.peek().is_some() && others.all(|c| c.largest * scale <= 1e-9 * q.peak.abs())
}

fn costs(study: &StudyRecord, stored: &[StoredCase], reference: &str) -> Vec<MemberCost> {
    let of_variants = study.variants.iter().flat_map(|v| study.members_in(stored, Role::Members, v));
    let all: Vec<(&str, &StoredCase)> = of_variants.filter_map(|(member, case)| Some((member, case?))).collect();
    let mut members: Vec<&str> = vec![];
    for (member, _) in &all {
        if !members.contains(member) {
            members.push(member);
        }
    }
    let mut costs: Vec<MemberCost> = (members.iter())
        .map(|member| {
            let own: Vec<_> = all.iter().filter(|(name, _)| name == member).map(|(_, c)| &c.record).collect();
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

/// A difference in words: `3.2 %`, or in the unit if the absolute tolerance decides.
pub fn amount(q: &ByQuantity<MemberDifferences>, share: f64, tolerance: f64) -> String {
    let own = q.quantity.tolerance(tolerance);
    match own.is_absolute(q.peak) {
        true => significant(share * own.scale(q.peak), 3) + &space(&q.quantity.unit),
        false => percent(share),
    }
}

/// A signed difference in words: `+3.2 %` of the magnitude, or the difference of the values in the unit if the absolute tolerance decides.
pub fn signed(q: &ByQuantity<MemberDifferences>, share: f64, tolerance: f64) -> String {
    let is_less = match q.quantity.tolerance(tolerance).is_absolute(q.peak) {
        true => with_sign_of(q.peak, share) < 0.0,
        false => share < 0.0,
    };
    let sign = if is_less { "−" } else { "+" };
    format!("{sign}{}", amount(q, share.abs(), tolerance))
}

fn sentence(
    study: &StudyRecord,
    q: &ByQuantity<MemberDifferences>,
    reference: &str,
    missing: &[&Incomparable],
) -> String {
    let tolerance = study.tolerance;
    let unit = space(&q.quantity.unit);
    let peak = readable(q.peak, digits(q.peak));
    let mut words = format!("{}: {peak}{unit} with {}", capital(&q.peak_title()), study.member(reference));
    let others: Vec<&ComparedMember> = q.members.iter().filter(|c| c.member != reference).collect();
    let (near, far): (Vec<_>, Vec<_>) = others.iter().partition(|c| c.peak_difference.abs() <= tolerance);
    let list = |members: &[&&ComparedMember]| {
        members
            .iter()
            .map(|c| format!("{} {}", study.member(&c.member), signed(q, c.peak_difference, tolerance)))
            .collect::<Vec<_>>()
            .join(", ")
    };
    if !near.is_empty() {
        words += &format!("; within {}: {}", amount(q, tolerance, tolerance), list(&near));
    }
    if !far.is_empty() {
        words += &format!("; beyond: {}", list(&far));
    }
    if !missing.is_empty() {
        let names: Vec<String> = missing.iter().map(|i| format!("{} ({})", study.member(&i.member), i.why)).collect();
        words += &format!("; not comparable: {}", names.join(", "));
    }
    words.extend(finer::sentence(study, q, reference).map(|sentence| format!(". {sentence}")));
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
    out.extend(analysis::warnings_of_costs(stored));
    out
}

/// The curve in which a member differs most from the reference.
type Worst<'a> = (&'a ByQuantity<MemberDifferences>, &'a ComparedMember);

/// Whether a member can replace the reference.
enum Replaces<'a> {
    /// It can in every curve
    Yes(Worst<'a>),
    No(Worst<'a>),
    /// It agrees wherever it can be compared, but it cannot be compared in these curves
    Open(Vec<&'a Incomparable>),
}

/// All members except the reference, as far as there is something to compare.
fn replacements(a: &ComparisonFindings, tolerance: f64) -> Vec<(&str, Replaces<'_>)> {
    let of = |member: &'_ str| {
        let own =
            a.quantities.iter().flat_map(|q| q.members.iter().filter(|c| c.member == member).map(move |c| (q, c)));
        let without: Vec<&Incomparable> = a.incomparable.iter().filter(|i| i.member == member).collect();
        match own.max_by(|x, y| x.1.largest.total_cmp(&y.1.largest)) {
            Some(worst) if worst.1.largest > tolerance => Some(Replaces::No(worst)),
            _ if !without.is_empty() => Some(Replaces::Open(without)),
            worst => worst.map(Replaces::Yes),
        }
    };
    let members = a.costs.iter().map(|p| p.member.as_str()).filter(|m| *m != a.reference);
    members.filter_map(|member| Some((member, of(member)?))).collect()
}

/// Returns whether each member can replace the reference.
pub fn decisions(a: &Analysis<ComparisonFindings>) -> BTreeMap<String, String> {
    let one = |(member, replaces): (&str, Replaces)| {
        let answer = match replaces {
            Replaces::Yes(_) => "yes",
            Replaces::No(_) => "no",
            Replaces::Open(_) => "not comparable",
        };
        (format!("{member} can replace {}", a.reference), answer.into())
    };
    replacements(a, a.tolerance).into_iter().map(one).collect()
}

/// The peaks in words, such as `its maximum is 13 % higher: 68.3° against 60.4°`; two negative peaks are compared in magnitude
fn peaks(q: &ByQuantity<MemberDifferences>, c: &ComparedMember, tolerance: f64) -> String {
    let [own, base] = [c.peak, q.peak].map(|peak| significant(peak, 3) + &space(&q.quantity.unit));
    let peak = q.peak_is.trim_end_matches(" of");
    if own == base {
        return format!("its {peak} is the same, {base}");
    }
    let amount = amount(q, c.peak_difference.abs(), tolerance);
    let (least, most) = (c.peak.min(q.peak), c.peak.max(q.peak));
    let is_less = c.peak.abs() < q.peak.abs();
    let differs = match (least < 0.0, most > 0.0) {
        (true, true) => format!("has the other sign and differs by {amount}"),
        (true, false) => format!("is {amount} {} in magnitude", if is_less { "smaller" } else { "larger" }),
        (false, _) => format!("is {amount} {}", if is_less { "lower" } else { "higher" }),
    };
    format!("its {peak} {differs}: {own} against {base}")
}

/// The verdict: which members are interchangeable, how far the others are off, and their costs.
fn verdict(study: &StudyRecord, a: &ComparisonFindings, missing: usize) -> String {
    if a.quantities.is_empty() || a.costs.iter().all(|p| p.member == a.reference) {
        return format!(
            "No verdict: there is no pair of converged cases to compare with {} in a quantity that is not imposed.",
            study.member(&a.reference)
        );
    }
    let (mut same, mut open): (Vec<String>, Vec<String>) = (vec![], vec![]);
    let mut apart: Vec<(f64, String)> = vec![];
    for (member, replaces) in replacements(a, study.tolerance) {
        let name = study.member(member);
        match replaces {
            Replaces::Yes((q, c)) => same.push(format!("{name} ({})", amount(q, c.largest, study.tolerance))),
            Replaces::No((q, c)) => {
                let (differs, place) = (amount(q, c.largest, study.tolerance), q.title());
                let peaks = peaks(q, c, study.tolerance);
                apart.push((c.largest, format!("{name} by {differs} in the {place} ({peaks})")));
            }
            Replaces::Open(without) => {
                let places: Vec<String> = without.iter().map(|i| format!("{}: {}", i.place, i.why)).collect();
                open.push(format!("{name} ({})", few(&places)));
            }
        }
    }
    apart.sort_by(|x, y| y.0.total_cmp(&x.0));
    let apart: Vec<String> = apart.into_iter().map(|x| x.1).collect();
    let absolute = a.quantities.iter().any(|q| q.quantity.tolerance(study.tolerance).is_absolute(q.peak));
    let or_absolute = if absolute { " or the absolute tolerance" } else { "" };
    let tolerance = format!("{} of the peak{or_absolute}", percent(study.tolerance));
    let mut words = match same.is_empty() {
        true => format!("No member can replace {} within {tolerance} in every curve.", study.member(&a.reference)),
        false => {
            format!(
                "Within {tolerance}, in every curve, {} can replace {}.",
                same.join(", "),
                study.member(&a.reference)
            )
        }
    };
    if !apart.is_empty() {
        words += &format!(" At most they differ: {}.", apart.join("; "));
    }
    if !open.is_empty() {
        words += &format!(" Not comparable in every curve: {}.", open.join("; "));
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
