//! Conclusions for the choice of a mesh: settings with cost and error bar, the sentences, the verdict or its refusal.
//!
//! A refusal lists reasons that are worded where they are found: limitations of one family in [`crate::study::estimate::family`], disagreement of
//! families in [`super::analysis`], a response without a limit in the scene.

use crate::report::names::title;
use crate::report::numbers::{capital, percent, seconds};
use crate::study::analysis::ByQuantity;
use crate::study::estimate::family::Estimate;
use crate::study::kinds::convergence::cases::Cases;
use crate::study::kinds::convergence::findings::{Bar, MeshErrors, MeshSetting, Recommendation, headline};
use crate::study::locking;
use crate::study::store::record::{CaseRecord, FamilyRecord, Role};
use crate::wording::{all, count, distinct, few};

/// Returns all settings that were run with the study's time steps, cheapest first. Seeds only show the scatter, so that a lucky one is not chosen.
pub fn settings(cases: &Cases, quantities: &[ByQuantity<MeshErrors>]) -> Vec<MeshSetting> {
    let mut out: Vec<(&CaseRecord, MeshSetting, usize)> = vec![];
    for (c, variant) in cases.stored.iter().flat_map(|c| c.variants().into_iter().map(move |v| (c, v))) {
        let r = &c.record;
        let family = cases.study.family_of(c, Some(variant)).filter(|f| f.role != Role::Seeds);
        let Some(family) = family.filter(|_| r.converged() && cases.at_study_step(variant, r)) else { continue };
        let is_own =
            |(of, ..): &(&CaseRecord, MeshSetting, usize)| of.has_mesh_of(r) && of.formulation == r.formulation;
        let at = out.iter().position(is_own).unwrap_or_else(|| {
            out.push((r, setting_of(r, family), 0));
            out.len() - 1
        });
        let (_, s, runs) = &mut out[at];
        if s.bars.iter().any(|b| b.variant == variant) {
            continue;
        }
        if !s.cases.contains(&r.id) {
            s.cases.push(r.id.clone());
        }
        s.cost_s += r.cpu_s;
        *runs += 1;
        for q in quantities.iter().filter(|q| q.variant == variant) {
            if let Some(e) = q.errors.iter().find(|e| e.id == r.id) {
                let (variant, quantity) = (q.variant.clone(), q.quantity.name.clone());
                let (value, error, bar, cost_s) = (e.value, e.error, e.bar, r.cpu_s);
                s.bars.push(Bar { variant, quantity, value, error, bar, cost_s });
            }
        }
    }
    let mean = |(_, s, runs): (&CaseRecord, MeshSetting, usize)| MeshSetting { cost_s: s.cost_s / runs as f64, ..s };
    let mut settings: Vec<MeshSetting> = out.into_iter().map(mean).collect();
    for s in &mut settings {
        for q in quantities.iter().filter(|q| q.deciding) {
            let bar = find(s, q).map_or(f64::INFINITY, |b| b.bar);
            if bar > s.worst || s.limited_by.is_empty() {
                let ran = cases.stored.iter().any(|c| c.is_of(&q.variant) && s.cases.contains(&c.record.id));
                let why = match (bar.is_finite(), ran) {
                    (true, _) => q.peak_title(),
                    (false, true) => format!("no error bar of the {}", q.peak_title()),
                    (false, false) => format!("no result in {}", q.variant_label),
                };
                (s.worst, s.limited_by) = (bar, why);
            }
        }
        if !quantities.iter().any(|q| q.deciding) {
            (s.worst, s.limited_by) = (f64::INFINITY, "no quantity decides".into());
        }
    }
    settings.sort_by(|a, b| a.cost_s.total_cmp(&b.cost_s));
    settings
}

/// The setting of a case, without its runs.
fn setting_of(c: &CaseRecord, family: &FamilyRecord) -> MeshSetting {
    MeshSetting {
        label: format!("{}, {}", title(&c.formulation), count(c.mesh.cells, "cell")),
        formulation: c.formulation.clone(),
        cells: c.mesh.cells,
        h_m: c.mesh.h_m,
        family: family.name.clone(),
        cases: vec![],
        cost_s: 0.0,
        bars: vec![],
        worst: 0.0,
        limited_by: String::new(),
    }
}

fn find<'a>(s: &'a MeshSetting, q: &ByQuantity<MeshErrors>) -> Option<&'a Bar> {
    s.bars.iter().find(|b| b.variant == q.variant && b.quantity == q.quantity.name)
}

/// Relative reduction of the error bar from which a more expensive setting counts as better; less is not worth its cost.
const BETTER: f64 = 0.1;

/// Whether an error bar is smaller than that of a cheaper setting by more than a difference in the last digits.
fn is_better(bar: f64, than: f64) -> bool {
    bar < (1.0 - BETTER) * than
}

/// States the verdict on a quantity: the cheapest setting that meets the tolerance, its bar, its cost, and the cost of the next better one.
pub fn sentence(settings: &[MeshSetting], q: &ByQuantity<MeshErrors>, tolerance: f64) -> String {
    let title = capital(&q.peak_title());
    if !q.supported {
        return format!("{title}: no verdict within {}. {}.", percent(tolerance), capital(&reasons(q, usize::MAX)));
    }
    let mut by_cost: Vec<(&MeshSetting, &Bar)> = settings.iter().filter_map(|s| Some((s, find(s, q)?))).collect();
    by_cost.sort_by(|a, b| a.1.cost_s.total_cmp(&b.1.cost_s));
    let reference = q
        .reference
        .as_ref()
        .map_or(String::new(), |r| format!(" (reference {} {})", r.words(&q.quantity.unit), r.from_words()));
    let Some(&(s, b)) = by_cost.iter().find(|(_, b)| b.bar <= tolerance) else {
        let best = by_cost.iter().min_by(|a, b| a.1.bar.total_cmp(&b.1.bar));
        let best = best.map_or(String::new(), |(s, b)| {
            format!("; the best, {}, reaches {} for {}", s.label, percent(b.bar), seconds(b.cost_s))
        });
        return format!("{title}: no setting meets {}{best}{reference}.", percent(tolerance));
    };
    let above = || by_cost.iter().filter(|(_, n)| n.cost_s > b.cost_s);
    let next = match above().find(|(_, n)| is_better(n.bar, b.bar)) {
        Some((n, nb)) => {
            let times = nb.cost_s / b.cost_s;
            let (bar, cost) = (percent(nb.bar), seconds(nb.cost_s));
            format!("; the next better one, {}, reaches {bar} for {cost} ({times:.1} times the cost)", n.label)
        }
        None if above().next().is_none() => "; none is more expensive".into(),
        None => format!("; none of the more expensive ones is better by more than {}", percent(BETTER)),
    };
    format!(
        "{title}: the cheapest setting that meets {} is {}, with an error bar of {} for {}{next}{reference}.",
        percent(tolerance),
        s.label,
        percent(b.bar),
        seconds(b.cost_s)
    )
}

/// Largest number of reasons per family in a verdict: the last ones, which speak against the family.
const LAST: usize = 3;

/// The reasons why the data do not support a reference: the last `most` reasons of each family, then those that families have in common.
fn reasons(q: &ByQuantity<MeshErrors>, most: usize) -> String {
    let of_family = |e: &Estimate| {
        let last = &e.reasons[e.reasons.len().saturating_sub(most)..];
        (!last.is_empty()).then(|| format!("family {}: {}", e.family, last.join("; ")))
    };
    let is_common = |reason: &&String| {
        let of = |e: &Estimate| reason.strip_prefix(&e.family).is_some_and(|rest| rest.starts_with(": "));
        !q.estimates.iter().any(of)
    };
    let common = q.reasons.iter().filter(is_common).cloned();
    q.estimates.iter().filter_map(of_family).chain(common).collect::<Vec<_>>().join("; ")
}

/// Returns the recommendation, or the reasons against one.
pub fn conclude(
    cases: &Cases,
    quantities: &[ByQuantity<MeshErrors>],
    settings: &[MeshSetting],
    incomplete: &[(String, String)],
) -> (Option<Recommendation>, String) {
    let tolerance = cases.study.tolerance;
    let refuse = |why: String| (None, format!("No verdict within {}: {why}", percent(tolerance)));
    if let Some(why) = cases.no_limit() {
        return refuse(format!(
            "{why}, so the answer has no limit as h → 0. Let forces act on areas that stay: guides with a radius of at least the largest h, faces in \
             place of single nodes; give sheets that wrinkle the thickness of cells."
        ));
    }
    let deciding: Vec<&ByQuantity<MeshErrors>> = quantities.iter().filter(|q| q.deciding).collect();
    if deciding.is_empty() {
        return refuse("the study lists no quantity.".into());
    }
    let missing = |q: &&&ByQuantity<MeshErrors>| !q.supported;
    let unsupported: Vec<&&ByQuantity<MeshErrors>> = deciding.iter().filter(missing).collect();
    if let Some(first) = unsupported.first() {
        let names: Vec<String> = unsupported.iter().map(|q| q.peak_title()).collect();
        let of = if names.len() > 1 { "Of the first one, " } else { "" };
        let why = capital(&format!("{of}{}.", reasons(first, LAST)));
        let lost = match incomplete.len() {
            0 => String::new(),
            1 => format!(" One case has no usable result: {}.", incomplete[0].0),
            n => {
                let ids: Vec<&String> = incomplete.iter().map(|(id, _)| id).collect();
                format!(" {n} cases have no usable result: {}.", few(&ids))
            }
        };
        return refuse(format!("the data do not support one for {}. {why}{lost}", names.join(", nor for ")));
    }
    let Some(s) = settings.iter().find(|s| s.worst <= tolerance) else {
        let best = settings.iter().filter(|s| s.worst.is_finite()).min_by(|a, b| a.worst.total_cmp(&b.worst));
        return refuse(best.map_or("no setting has an error bar in every variant.".into(), |s| {
            format!("no setting meets it; the best, {}, reaches {} ({}).", s.label, percent(s.worst), s.limited_by)
        }));
    };
    let next = settings.iter().find(|n| n.cost_s > s.cost_s && is_better(n.worst, s.worst));
    let variant = headline(quantities).map(|q| q.variant.as_str());
    let shown = |id: &&String| cases.stored.iter().any(|c| c.record.id == **id && variant.is_some_and(|v| c.is_of(v)));
    let case = s.cases.iter().find(shown).unwrap_or(&s.cases[0]).clone();
    let which = if deciding.len() == quantities.len() { "" } else { " of those that decide" };
    let unstable = unstable(cases, s);
    let (on, is) = claim(quantities, unstable.is_empty());
    let mut words = format!(
        "{on}{} {is} {}: error bar {} in the worst quantity{which} ({}), {} per case.",
        s.label,
        percent(tolerance),
        percent(s.worst),
        s.limited_by,
        seconds(s.cost_s)
    );
    words += &undecided(quantities, s, tolerance);
    if let Some(n) = next {
        let (bar, cost) = (percent(n.worst), seconds(n.cost_s));
        words += &format!(" The next better one, {}, reaches {bar} for {cost}.", n.label);
    }
    words += &input_words(quantities, s);
    words += &locked(cases, s);
    words += &unstable;
    words += &about_sizes(cases, settings, tolerance);
    words += &insensitive(quantities, s);
    let recommendation = Recommendation {
        case,
        cases: s.cases.clone(),
        label: s.label.clone(),
        error_bar: s.worst,
        limited_by: s.limited_by.clone(),
        cost_s: s.cost_s,
        next: next.map(|n| (n.label.clone(), n.worst, n.cost_s)),
    };
    (Some(recommendation), words)
}

/// How far the verdict goes: on an unstable branch nothing can be trusted, and bars may lack the share of the constants.
fn claim(quantities: &[ByQuantity<MeshErrors>], is_stable: bool) -> (&'static str, &'static str) {
    let is_whole = undetermined(quantities).is_empty() && without_share(quantities).next().is_none();
    match (is_stable, is_whole) {
        (true, true) => ("", "can be trusted within"),
        (true, false) => ("", "is within the tolerance of"),
        (false, _) => ("On an unstable branch of equilibria, ", "is within the tolerance of"),
    }
}

/// The quantities that do not decide, with their bars in the recommended setting.
fn undecided(quantities: &[ByQuantity<MeshErrors>], setting: &MeshSetting, tolerance: f64) -> String {
    let bar = |q: &ByQuantity<MeshErrors>| match find(setting, q).map(|b| b.bar) {
        Some(bar) if bar <= tolerance && q.supported => format!("{} ({})", q.peak_title(), percent(bar)),
        Some(bar) if bar <= tolerance => {
            format!("{} ({}, from a reference without support)", q.peak_title(), percent(bar))
        }
        Some(bar) => format!("{} ({}, above the tolerance)", q.peak_title(), percent(bar)),
        None => format!("{} (no error bar)", q.peak_title()),
    };
    let words: Vec<String> = quantities.iter().filter(|q| !q.deciding).map(bar).collect();
    if words.is_empty() { String::new() } else { format!(" Not decided by: {}.", words.join("; ")) }
}

/// Discretisation and constants, separately and together, for the deciding quantity in which the two together are largest.
fn input_words(quantities: &[ByQuantity<MeshErrors>], setting: &MeshSetting) -> String {
    let both = |q: &ByQuantity<MeshErrors>| Some((find(setting, q)?.bar, q.inputs.as_ref()?.share));
    let deciding = quantities.iter().filter(|q| q.deciding && both(q).is_some());
    let total = |q: &ByQuantity<MeshErrors>| both(q).map_or(0.0, |(bar, share)| bar.hypot(share));
    let Some(q) = deciding.max_by(|a, b| total(a).total_cmp(&total(b))) else { return String::new() };
    let (Some((bar, share)), Some(inputs)) = (both(q), &q.inputs) else { return String::new() };
    format!(
        " Constants ({}) are known within the 95 % intervals of the law file only: of the {}, {} are discretisation, {} constants, together {} \
         (root of the sum of squares; {}).",
        inputs.constants.join(", "),
        q.peak_title(),
        percent(bar),
        percent(share),
        percent(bar.hypot(share)),
        if inputs.correlated { "the constants are correlated as the file says" } else { "the file has no covariance" }
    )
}

/// States the share of the constants for the deciding quantity in which it is largest.
pub fn constants_alone(quantities: &[ByQuantity<MeshErrors>]) -> String {
    let known = quantities.iter().filter(|q| q.deciding).filter_map(|q| Some((q, q.inputs.as_ref()?)));
    known.max_by(|a, b| a.1.share.total_cmp(&b.1.share)).map_or(String::new(), |(q, inputs)| {
        format!(
            " Whatever the mesh, constants ({}) that are known within the 95 % intervals of the law file only leave {} of the {} open.",
            inputs.constants.join(", "),
            percent(inputs.share),
            q.peak_title()
        )
    })
}

/// Constants under deciding quantities whose interval is open.
fn undetermined(quantities: &[ByQuantity<MeshErrors>]) -> Vec<String> {
    distinct(quantities.iter().filter(|q| q.deciding).flat_map(|q| q.undetermined.iter().cloned()))
}

/// States that the share of constants with an open interval is unknown; empty if there are no such constants.
pub fn undetermined_words(quantities: &[ByQuantity<MeshErrors>]) -> String {
    let open = undetermined(quantities);
    if open.is_empty() {
        return String::new();
    }
    format!(
        " Constants ({}) have no closed interval in their law file: the error bars are of the mesh alone, and the values may be off by any \
         share of the constants.",
        open.join(", ")
    )
}

/// The deciding quantities to which the contribution of constants is unknown.
fn without_share(quantities: &[ByQuantity<MeshErrors>]) -> impl Iterator<Item = &ByQuantity<MeshErrors>> {
    quantities.iter().filter(|q| q.deciding && !q.without_share.is_empty())
}

/// States which bars lack the share of constants that are known within intervals, because the quantity has no derivative by them.
pub fn without_share_words(quantities: &[ByQuantity<MeshErrors>]) -> String {
    let titles: Vec<String> = without_share(quantities).map(|q| format!("the {}", q.peak_title())).collect();
    if titles.is_empty() {
        return String::new();
    }
    let constants = distinct(without_share(quantities).flat_map(|q| q.without_share.iter().cloned()));
    format!(
        " Constants ({}) are known within the 95 % intervals of the law file only, and no derivative of {} by them is there: their share is \
         not known, and these error bars are of the mesh alone.",
        constants.join(", "),
        all(&titles)
    )
}

/// A warning if a recommended setting raises the locking alarm.
fn locked(cases: &Cases, setting: &MeshSetting) -> String {
    let of = cases.stored.iter().map(|c| &c.record).filter(|c| setting.cases.contains(&c.id));
    let worst = of.filter_map(locking::alarm).fold(0.0, f64::max);
    if worst == 0.0 {
        return String::new();
    }
    format!(
        " But it raises the locking alarm (pressure scatter {worst:.2}): within the tolerance in the judged quantities, its \
         pressures are of no use; {}.",
        locking::REMEDY
    )
}

/// A warning if a recommended setting has unstable equilibria.
fn unstable(cases: &Cases, setting: &MeshSetting) -> String {
    let of = cases.stored.iter().map(|c| &c.record).filter(|c| setting.cases.contains(&c.id));
    let unstable: Vec<&str> = of.filter(|c| c.solver.unstable_steps > 0).map(|c| c.id.as_str()).collect();
    if unstable.is_empty() {
        return String::new();
    }
    format!(
        " States of {} are unstable (negative eigenvalues of the tangent): the body may leave them for another branch, which \
         the error bar does not cover.",
        unstable.join(", ")
    )
}

/// The study asks about the sizes: a sentence if none of them will do.
fn about_sizes(cases: &Cases, settings: &[MeshSetting], tolerance: f64) -> String {
    let Some(family) = cases.study.families.iter().find(|f| f.role == Role::Sizes) else { return String::new() };
    let of: Vec<&MeshSetting> = settings.iter().filter(|s| s.cases.iter().any(|c| family.cases.contains(c))).collect();
    let best = of.iter().filter(|s| s.worst.is_finite()).min_by(|a, b| a.worst.total_cmp(&b.worst));
    best.filter(|s| s.worst > tolerance).map_or(String::new(), |s| {
        let (bar, name) = (percent(s.worst), &family.name);
        let none = match of.len() {
            1 => format!("The only mesh of family {name} does not: it"),
            n => format!("None of the {n} meshes of family {name} does: the best, {},", s.label),
        };
        format!(" {none} has an error bar of {bar} ({}).", s.limited_by)
    })
}

/// A warning if a deciding quantity that hardly depends on the mesh hides the error of the one that limits the setting in the same variant.
fn insensitive(quantities: &[ByQuantity<MeshErrors>], setting: &MeshSetting) -> String {
    let spread = |q: &ByQuantity<MeshErrors>| {
        let e = q.sizes()?;
        let (first, last) = (e.values.first()?, e.values.last()?);
        Some(((last - first) / first).abs())
    };
    let bar = |q: &ByQuantity<MeshErrors>| find(setting, q).map_or(f64::INFINITY, |b| b.bar);
    let deciding: Vec<(&ByQuantity<MeshErrors>, f64)> =
        quantities.iter().filter(|q| q.deciding).filter_map(|q| Some((q, spread(q)?))).collect();
    let mut words = String::new();
    for (q, least) in &deciding {
        let others = deciding.iter().filter(|(other, _)| other.variant == q.variant);
        let limit = others.max_by(|a, b| bar(a.0).total_cmp(&bar(b.0)));
        let Some((limit, most)) = limit.filter(|(_, most)| *least < most / 3.0) else { continue };
        words += &format!(
            " {}: from the coarsest to the finest size the {} moves by {} only, the {} by {}; the {} limits.",
            capital(&q.variant_label),
            q.quantity.label,
            percent(*least),
            limit.quantity.label,
            percent(*most),
            limit.quantity.label
        );
    }
    words
}
