//! Counts how many error bars of all problems contain the truth.
//!
//! Pure: stored cases in, [`CoverageFindings`] out.

use crate::report::numbers::{capital, percent};
use crate::study::analysis::{self, Analysis};
use crate::study::kinds::coverage::mark::{Estimator, Mark, Standing, marks};
use crate::study::kinds::coverage::record::CoverageRecord;
use crate::study::kinds::coverage::share::{Effectivity, Share};
use crate::study::kinds::coverage::truth::{Truth, truth};
use crate::study::store::record::{StoredCase, StudyRecord};
use crate::wording::{all, count};

/// Share of bars that must hold, and largest median of bar over error, for a positive verdict.
pub const LEAST_SHARE: f64 = 0.95;
pub const MOST_RATIO: f64 = 4.0;
/// Required share of effectivities from 0.7 to 1.4 on smooth problems, and from 0.5 to 2 on all.
pub const LEAST_NEAR: f64 = 0.8;
pub const LEAST_WITHIN: f64 = 0.9;

/// Findings of a coverage study.
#[derive(Clone, Debug, PartialEq)]
pub struct CoverageFindings {
    /// Number of problems in all materials
    pub problems: usize,
    pub truths: Vec<Truth>,
    pub marks: Vec<Mark>,
    /// Share of bars that hold: of all bars first, then by group
    pub shares: Vec<Share>,
    /// Effectivities of estimates from one run: on smooth problems, on singular ones, on all
    pub effectivities: Vec<Effectivity>,
}

impl CoverageFindings {
    pub fn count(&self, estimator: Estimator, standing: Standing) -> usize {
        self.marks.iter().filter(|m| m.estimator == estimator && m.standing == standing).count()
    }

    pub fn whole(&self, estimator: Estimator) -> Option<&Share> {
        self.shares.iter().find(|s| s.estimator == estimator)
    }

    /// Whether bars hold often enough and are narrow enough.
    pub fn passes(&self) -> bool {
        Estimator::ALL
            .iter()
            .all(|e| self.whole(*e).is_some_and(|s| s.share() >= LEAST_SHARE && s.median_ratio <= MOST_RATIO))
    }
}

/// Analyses the stored cases; cases that are missing or did not converge are named.
pub fn analyse(study: &StudyRecord, coverage: &CoverageRecord, stored: &[StoredCase]) -> Analysis<CoverageFindings> {
    let (mut truths, mut all, mut problems) = (vec![], vec![], 0);
    for problem in &coverage.problems {
        for material in &study.variants {
            let found = problem.quantities.iter().filter_map(|q| truth(study, stored, problem, material, q));
            let found: Vec<Truth> = found.collect();
            problems += usize::from(!found.is_empty());
            all.extend(found.iter().flat_map(|truth| marks(study, stored, problem, truth)));
            truths.extend(found);
        }
    }
    let incomplete = study.incomplete(stored);
    let found = CoverageFindings {
        problems,
        truths,
        shares: shares(study, &all),
        effectivities: effectivities(&all),
        marks: all,
    };
    let verdict = verdict(&found, incomplete.len());
    let mut warnings = analysis::warnings(&incomplete);
    warnings.extend(refusals(stored));
    Analysis { tolerance: study.tolerance, found, incomplete, warnings, verdict }
}

/// The cases whose errors could not be estimated from their own runs, each with the reason.
fn refusals(stored: &[StoredCase]) -> impl Iterator<Item = String> {
    let why = |c: &StoredCase| c.record.one_run.as_ref()?.missing();
    stored.iter().filter_map(move |c| Some(format!("{} has no estimate from its run: {}.", c.record.id, why(c)?)))
}

/// A grouping of bars: the property that they are grouped by, and the function that gives the group of a bar.
type Group = (&'static str, fn(&Mark) -> String);

const GROUPS: [Group; 8] = [
    ("all", |_| "all".into()),
    ("problem", |m| if m.fresh { "fresh".into() } else { "bounds were chosen on it".into() }),
    ("formulation", |m| m.formulation.clone()),
    ("material", |m| m.material.clone()),
    ("body", |m| m.body.clone()),
    ("solution", |m| if m.smooth { "smooth".into() } else { "singular edges".into() }),
    ("boundary", |m| if m.curved { "curved".into() } else { "flat".into() }),
    ("locking", |m| if m.locks { "alarm".into() } else { "no alarm".into() }),
];

fn shares(study: &StudyRecord, marks: &[Mark]) -> Vec<Share> {
    let mut out = vec![];
    for (by, group) in GROUPS {
        let mut names: Vec<String> = vec![];
        for name in marks.iter().map(group) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        for name in names {
            for estimator in Estimator::ALL {
                let own = |m: &&Mark| m.counts() && m.estimator == estimator && group(m) == name;
                let own: Vec<&Mark> = marks.iter().filter(own).collect();
                let label = if by == "material" { study.label(&name) } else { name.clone() };
                out.extend(Share::new(estimator, by, &label, &own));
            }
        }
    }
    let own = |m: &&Mark| m.counts() && m.estimator == Estimator::ManyRuns && m.defensible;
    let defensible: Vec<&Mark> = marks.iter().filter(own).collect();
    out.extend(Share::new(Estimator::ManyRuns, "family", "within the tolerance", &defensible));
    out
}

fn effectivities(marks: &[Mark]) -> Vec<Effectivity> {
    let of = |name: &str, wanted: &dyn Fn(&Mark) -> bool| {
        let own = |m: &&Mark| m.counts() && m.estimator == Estimator::OneRun && wanted(m);
        Effectivity::new(name, &marks.iter().filter(own).collect::<Vec<_>>())
    };
    let groups = [
        of("smooth", &|m| m.smooth),
        of("singular edges", &|m| !m.smooth),
        of("all", &|_| true),
        of("fresh and smooth", &|m| m.fresh && m.smooth),
        of("fresh", &|m| m.fresh),
    ];
    groups.into_iter().flatten().collect()
}

/// The reasons why no bar of an estimator counts.
fn without_bars(a: &CoverageFindings, estimator: Estimator) -> String {
    let reasons = [
        (
            Standing::Refused,
            "of families that are refused, since they diverge, lock, or do not resolve the thinnest wall",
        ),
        (Standing::TruthUncertain, "of truths that are not known to a tenth of them"),
    ];
    let counted = reasons.map(|(standing, why)| (a.count(estimator, standing), why));
    let why: Vec<String> = counted.iter().filter(|(n, _)| *n > 0).map(|(n, why)| format!("{n} {why}")).collect();
    match &why[..] {
        [] => format!("there is no bar from {}", estimator.words()),
        why => format!("no bar from {} counts: {}", estimator.words(), all(why)),
    }
}

/// How many bars of an estimator contain the truth, in words.
fn part(s: &Share) -> String {
    let [lo, hi] = s.interval.map(percent);
    format!(
        "from {} {} of {} bars contain the truth ({}, 95 % interval {lo} to {hi}), and the median bar is {:.2} times the error",
        s.estimator.words(),
        s.hold,
        s.bars,
        percent(s.share()),
        s.median_ratio
    )
}

fn verdict(a: &CoverageFindings, missing: usize) -> String {
    if a.truths.is_empty() {
        let words = "No verdict: no problem has two families of its truth with two converged meshes each.";
        return words.to_string() + &analysis::without_result(missing);
    }
    let absent = Estimator::ALL.into_iter().filter(|e| a.whole(*e).is_none());
    let absent: Vec<String> = absent.map(|e| without_bars(a, e)).collect();
    let parts: Vec<String> = Estimator::ALL.into_iter().filter_map(|e| a.whole(e)).map(part).collect();
    let over = format!("over {}, {}", count(a.problems, "problem"), parts.join("; "));
    if !absent.is_empty() {
        let known = if parts.is_empty() { String::new() } else { format!(" {}.", capital(&over)) };
        return format!("No verdict: {}.{known}{}", absent.join("; "), analysis::without_result(missing));
    }
    let mut words = format!(
        "{}: {over}.",
        if a.passes() { "The bars hold" } else { "The bars do not hold as often, or are wider, than asked for" },
    );
    let fresh = |e: Estimator| a.shares.iter().find(|s| s.estimator == e && s.by == "problem" && s.group == "fresh");
    if let [Some(one), Some(many)] = Estimator::ALL.map(fresh) {
        words += &format!(
            " Of the problems that took no part in the choice of the bounds, {} of {} and {} of {} bars do.",
            one.hold, one.bars, many.hold, many.bars
        );
    }
    let uncertain: usize = Estimator::ALL.iter().map(|e| a.count(*e, Standing::TruthUncertain)).sum();
    words += &format!(" {uncertain} bars are left out, whose truth is not known to a tenth of them.");
    let refused = a.count(Estimator::ManyRuns, Standing::Refused);
    if refused > 0 {
        words +=
            &format!(" {refused} families are refused, since they diverge, lock, or do not resolve the thinnest wall.");
    }
    words + &analysis::without_result(missing)
}
