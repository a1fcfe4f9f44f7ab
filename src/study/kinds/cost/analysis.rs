//! The analysis of the stored cases of a cost study.

use crate::math::statistics::range;
use crate::report::names;
use crate::study::analysis::{self, Analysis, ByQuantity};
use crate::study::curve::peak;
use crate::study::estimate::power_law::power_law;
use crate::study::estimate::step_size::has_steps_of;
use crate::study::kinds::cost::findings::*;
use crate::study::kinds::cost::line::Line;
use crate::study::kinds::cost::reference::{curve_error, members, reference, steps};
use crate::study::kinds::cost::sentence;
use crate::study::store::record::{CaseRecord, FamilyRecord, Role, StoredCase, StudyQuantity, StudyRecord};
use crate::wording::count;

/// Analyses the stored cases; cases that are missing or did not converge are named.
pub fn analyse(study: &StudyRecord, stored: &[StoredCase]) -> Analysis<CostFindings> {
    let mut levels = LEVELS.to_vec();
    if !levels.contains(&study.tolerance) {
        levels.push(study.tolerance);
        levels.sort_by(|a, b| b.total_cmp(a));
    }
    let mut quantities = ByQuantity::each(study, stored, |variant, quantity| {
        Some(cost_of_accuracy(study, stored, variant, quantity, &levels))
    });
    for q in &mut quantities {
        q.sentence = sentence::sentence(q, study.tolerance);
    }
    let growth = laws(study, stored);
    let incomplete = study.incomplete(stored);
    let warnings = warnings(study, stored, &quantities, &incomplete);
    let verdict = sentence::verdict(&quantities, study.tolerance, incomplete.len());
    let found = CostFindings { levels, quantities, growth };
    Analysis { tolerance: study.tolerance, found, incomplete, warnings, verdict }
}

fn cost_of_accuracy(
    study: &StudyRecord,
    stored: &[StoredCase],
    variant: &str,
    quantity: &StudyQuantity,
    levels: &[f64],
) -> CostOfAccuracy {
    let reference = reference(study, stored, variant, quantity);
    // No error is known against a refused reference
    let known = reference.as_ref().filter(|r| !r.refused);
    let mut settings = vec![];
    for family in study.families.iter().filter(|f| f.role != Role::Reference) {
        let cases = members(stored, family, variant);
        for (case, step_s) in cases.iter().copied().zip(steps(&cases)) {
            let is_there = settings.iter().any(|s: &CostedCase| s.case == case.record.id);
            let found = known.filter(|_| !is_there).and_then(|r| {
                let value = peak(case, &quantity.name)?;
                let of_curve = curve_error(r, case, quantity, study.tolerance)?;
                let errors = [(value - r.peak).abs() / r.scale, of_curve];
                errors.iter().all(|e| e.is_finite()).then(|| setting((case, step_s), family, variant, value, errors))
            });
            settings.extend(found);
        }
    }
    settings.sort_by(|a, b| a.cost_s.total_cmp(&b.cost_s));
    for m in MEASURES {
        let mut best = f64::INFINITY;
        for s in &mut settings {
            s.front[m as usize] = s.errors[m as usize] < best;
            best = best.min(s.errors[m as usize]);
        }
    }
    let line = |f: &FamilyRecord| {
        let of = |s: &&CostedCase| f.cases.contains(&s.case);
        let points = settings.iter().filter(of).map(|s| (s.cost_s, s.errors[0])).collect();
        Line::new(&f.name, names::family(&f.name), points, levels)
    };
    let lines = study.families.iter().filter(|f| f.role != Role::Reference).filter_map(line).collect();
    let mut q = CostOfAccuracy { reference, settings, lines, answers: vec![] };
    for measure in MEASURES {
        for &level in levels {
            let cheapest = (0..q.settings.len()).find(|&k| q.bar(k, measure) <= level);
            let next = cheapest.and_then(|c| {
                let error = |k: usize| q.settings[k].errors[measure as usize];
                (c + 1..q.settings.len()).find(|&k| error(k) < error(c))
            });
            q.answers.push(Cheapest { measure, level, cheapest, next });
        }
    }
    q
}

fn setting(
    (case, step_s): (&StoredCase, f64),
    family: &FamilyRecord,
    variant: &str,
    value: f64,
    errors: [f64; 2],
) -> CostedCase {
    let r = &case.record;
    let family_words = names::family(&family.name);
    let members = || case.members(&family.name, variant).collect::<Vec<_>>().join(", ");
    let label = match family.role {
        Role::TimeStep => format!("{family_words}, Δt = {}", milliseconds(step_s)),
        Role::Solver => format!("{family_words} {}", members()),
        _ => format!("{}, {}", names::title(&r.formulation), count(r.mesh.cells, "cell")),
    };
    let spread = (r.repeats.len() > 1).then(|| range(r.repeats.iter().map(|t| t.cpu_s)) / r.cpu_s);
    CostedCase {
        case: r.id.clone(),
        family: family.name.clone(),
        label,
        cost_s: r.cpu_s,
        // A time below the resolution of the clock is zero, which no spread can be relative to
        spread: spread.filter(|share| share.is_finite()),
        value,
        errors,
        front: [false; 2],
        dofs: r.dofs,
        factor_nnz: r.factor_nnz,
        flops: r.work.factor_flops * r.work.factorisations as f64,
        memory_bytes: r.work.memory_bytes,
        phases: r.phases.clone(),
    }
}

/// Formats a time in milliseconds: `10 ms`, `2.5 ms`.
fn milliseconds(s: f64) -> String {
    let ms = (1e6 * s).round() / 1e3;
    format!("{ms} ms")
}

/// The growth laws of time and memory over the cells, for each variant and formulation with at least three meshes.
fn laws(study: &StudyRecord, stored: &[StoredCase]) -> Vec<GrowthLaw> {
    let mut out = vec![];
    let meshes = |f: &&FamilyRecord| matches!(f.role, Role::Sizes | Role::Element);
    for variant in &study.variants {
        for family in study.families.iter().filter(meshes) {
            let cases = members(stored, family, variant);
            for of in [Grows::Time, Grows::Memory] {
                let value = |r: &CaseRecord| match of {
                    Grows::Time => Some(r.cpu_s),
                    Grows::Memory => r.work.memory_bytes.map(|b| b as f64),
                };
                let mut points: Vec<(f64, f64)> =
                    cases.iter().filter_map(|c| Some((c.record.mesh.cells as f64, value(&c.record)?))).collect();
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                let (Some(law), Some((last, others))) = (power_law(&points), points.split_last()) else { continue };
                if law.points < 3 {
                    continue;
                }
                let check = power_law(others).map(|g| g.at(last.0) / last.1);
                let next_cells = 2.0 * last.0;
                let (variant, formulation) = (variant.clone(), family.formulation_of(&cases).into());
                // More cells do not take less than the largest measured value
                let most = points.iter().map(|p| p.1).fold(0.0, f64::max);
                let next = law.predict(next_cells).at_least(most);
                out.push(GrowthLaw { variant, formulation, of, points, law, next_cells, next, check });
            }
        }
    }
    out
}

fn warnings(
    study: &StudyRecord,
    stored: &[StoredCase],
    quantities: &[ByQuantity<CostOfAccuracy>],
    incomplete: &[(String, String)],
) -> Vec<String> {
    let mut out = analysis::warnings(incomplete);
    let varies = |variant: &str| {
        let mut own = stored.iter().filter(|c| c.record.converged() && c.is_of(variant)).map(|c| &c.record);
        own.next().is_some_and(|first| own.any(|other| !has_steps_of(first, other)))
    };
    out.extend(analysis::warnings_of_steps(study, stored, varies));
    out.extend(analysis::warnings_of_costs(stored));
    if stored.iter().any(|c| c.record.shared) {
        out.push("The memory of a case is measured where it runs alone, as with `--jobs 1`.".into());
    }
    let settings = || quantities.iter().flat_map(|q| &q.settings);
    let spreads = settings().filter_map(|s| Some((s.spread?, s)));
    if let Some((spread, s)) = spreads.max_by(|a, b| a.0.total_cmp(&b.0)) {
        let spread = crate::report::numbers::percent(spread);
        out.push(format!("Costs scatter from run to run by up to {spread} of the median ({}).", s.case));
    }
    for q in quantities {
        let title = crate::report::numbers::capital(&q.title());
        let Some(r) = &q.reference else {
            out.push(format!("{title}: no family has the two cases that a reference needs."));
            continue;
        };
        if r.refused {
            continue;
        }
        let signs =
            |family: &str, above: bool| q.settings.iter().any(|s| s.family == family && (s.value > r.peak) == above);
        let lucky = q.lines.iter().filter(|l| signs(&l.family, true) && signs(&l.family, false));
        let lucky: Vec<&str> = lucky.map(|l| l.label.as_str()).collect();
        if !lucky.is_empty() {
            out.push(format!(
                "{title}: the error changes its sign along {}; where it is least there, that is luck, and the next mesh or step need not be better.",
                lucky.join(", ")
            ));
        }
        let known = r.peak_uncertainty.max(r.curve_uncertainty);
        if LEVELS.iter().any(|l| *l < known) {
            out.push(format!(
                "{title}: the reference itself is known to {} (peak) and {} (curve); no setting can be said to meet less.{}",
                crate::report::numbers::percent(r.peak_uncertainty),
                crate::report::numbers::percent(r.curve_uncertainty),
                if r.reasons.is_empty() { String::new() } else { format!(" {}.", crate::report::numbers::capital(&r.reasons.join("; "))) }
            ));
        }
    }
    analysis::add_notes(&mut out, stored);
    out
}
