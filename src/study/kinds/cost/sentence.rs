//! One sentence per quantity, and the verdict.

use crate::report::numbers::{capital, digits, percent, seconds, space, within};
use crate::study::analysis::{ByQuantity, without_result};
use crate::study::kinds::cost::findings::{CostOfAccuracy, Measure};
use crate::study::kinds::cost::line::{How, Line};

/// The cheapest setting that meets the tolerance and what the next better one would cost, for the peak and for the curve.
pub fn sentence(q: &ByQuantity<CostOfAccuracy>, tolerance: f64) -> String {
    let Some(r) = &q.reference else {
        return format!("{}: no reference, so no cost can be given.", capital(&q.title()));
    };
    if r.refused {
        let why = r.reasons.join("; ");
        return format!(
            "{}: no family can be a reference, so no error is known: family {}: {why}.",
            capital(&q.title()),
            r.family
        );
    }
    let (half, unit) = (r.peak_uncertainty * r.scale, space(&q.quantity.unit));
    let [peak, half] = [r.peak, half].map(|v| within(v, half).replace('-', "−"));
    format!(
        "{}: {}; {}. Reference: {} {peak}{unit} ± {half}{unit} {}.",
        capital(&q.title()),
        cheapest(q, Measure::Peak, tolerance),
        cheapest(q, Measure::Curve, tolerance),
        q.peak_is.trim_end_matches(" of"),
        r.from
    )
}

fn cheapest(q: &ByQuantity<CostOfAccuracy>, measure: Measure, tolerance: f64) -> String {
    let what = format!("of the {}", measure.words());
    let Some(answer) = q.answer(measure, tolerance) else { return format!("{what} nothing is known") };
    let Some(k) = answer.cheapest else {
        let best = (0..q.settings.len()).min_by(|a, b| q.bar(*a, measure).total_cmp(&q.bar(*b, measure)));
        return match best {
            Some(b) => format!(
                "{what} no setting meets {}, the best, {}, has an error bar of {} for {}",
                percent(tolerance),
                q.settings[b].label,
                percent(q.bar(b, measure)),
                seconds(q.settings[b].cost_s)
            ),
            None => format!("{what} there is no setting"),
        };
    };
    let s = &q.settings[k];
    let next = answer.next.map_or("none of the more expensive ones is better".into(), |n| {
        let better = &q.settings[n];
        let (bar, cost) = (percent(q.bar(n, measure)), seconds(better.cost_s));
        format!("the next better one, {}, {bar} for {cost}", better.label)
    });
    let (bar, cost) = (percent(q.bar(k, measure)), seconds(s.cost_s));
    format!("{what} the cheapest setting within {} is {}, {bar} for {cost} ({next})", percent(tolerance), s.label)
}

/// A ratio of costs below is none.
const RATIO: f64 = 1.5;

/// Most expensive over cheapest family at a level, where both have a cost of their own: the lines and the ratio.
fn ratio(q: &ByQuantity<CostOfAccuracy>, level: usize) -> Option<(&Line, &Line, f64)> {
    let of = |l: &Line| l.costs.get(level).copied().flatten();
    let by_cost: Vec<(&Line, f64)> = q.lines.iter().filter_map(|l| Some((l, of(l)?.seconds))).collect();
    let cheap = by_cost.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let expensive = by_cost.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let known = of(expensive.0).is_some_and(|p| p.how != How::AtMost);
    (known && expensive.1 > RATIO * cheap.1).then_some((cheap.0, expensive.0, expensive.1 / cheap.1))
}

/// `2.4`, `180`, `6e5`
fn times(x: f64) -> String {
    if x < 1e4 { format!("{x:.*}", digits(x)) } else { format!("{x:.0e}") }
}

/// Factor between the ends of an interval beyond which its upper end says nothing.
const WIDE: f64 = 1e3;

/// The cost of one family relative to that of a cheaper one, with the 95 % interval of an extrapolation, where it is one and has one.
fn relative_cost([expensive, cheap]: [&str; 2], ratio: f64, extrapolated: Option<Option<[f64; 2]>>) -> String {
    let would = |more: String| format!(", {expensive} would cost {} times as much as {cheap}{more}", times(ratio));
    match extrapolated {
        None => would(String::new()),
        Some(None) => would(" by extrapolation".into()),
        Some(Some([low, _])) if low < 1.0 => format!(
            ", and too few cases of {expensive} tell its cost: the 95 % interval of the extrapolation begins below the cost of {cheap}"
        ),
        Some(Some([low, high])) if high > WIDE * low => {
            format!(", {expensive} would cost at least {} times as much as {cheap} by extrapolation (95 %)", times(low))
        }
        Some(Some([low, high])) => would(format!(" by extrapolation (95 %: {} to {} times)", times(low), times(high))),
    }
}

pub fn verdict(quantities: &[ByQuantity<CostOfAccuracy>], tolerance: f64, missing: usize) -> String {
    if quantities.iter().all(|q| q.reference.is_none()) {
        return "No verdict: no quantity has a reference.".into();
    }
    let mut parts = vec![];
    for q in quantities {
        if q.reference.is_none() {
            parts.push(format!("the {} has no reference", q.title()));
            continue;
        }
        let Some(level) = q.answers.iter().filter(|a| a.measure == Measure::Peak).position(|a| a.level == tolerance)
        else {
            continue;
        };
        let answer = q.answer(Measure::Peak, tolerance).and_then(|a| a.cheapest);
        let title = format!("the {}", q.peak_title());
        if let Some(r) = q.reference.as_ref().filter(|r| r.refused) {
            parts.push(format!("{title} has no reference (family {}: {})", r.family, r.reasons.join("; ")));
            continue;
        }
        let mut words = match answer {
            Some(k) => {
                let s = &q.settings[k];
                format!("{title} costs {} ({})", seconds(s.cost_s), s.label)
            }
            None => format!("no setting is known to meet {title}"),
        };
        if let Some((cheap, expensive, ratio)) = ratio(q, level) {
            let cost = expensive.costs[level].filter(|p| p.how == How::Extrapolated);
            let own = cheap.costs[level].map_or(f64::NAN, |p| p.seconds);
            let interval = cost.map(|p| p.interval.map(|ends| ends.map(|end| end / own)));
            words += &relative_cost([&expensive.label, &cheap.label], ratio, interval);
        }
        parts.push(words);
    }
    if parts.is_empty() {
        return "No verdict: no quantity has a reference.".into();
    }
    format!("Within {}: {}.{}", percent(tolerance), parts.join("; "), without_result(missing))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_that_says_nothing_is_said_in_words() {
        let words = |extrapolated| relative_cost(["tet4", "tet10"], 7e4, extrapolated);
        assert_eq!(words(None), ", tet4 would cost 7e4 times as much as tet10");
        assert!(words(Some(Some([5e4, 9e4]))).ends_with("by extrapolation (95 %: 5e4 to 9e4 times)"));
        assert!(words(Some(Some([2.0, 9e16]))).contains("would cost at least 2.0 times as much as tet10"));
        let nothing = words(Some(Some([5.3e-8, 9e16])));
        assert!(nothing.contains("too few cases of tet4 tell its cost") && !nothing.contains("times"), "{nothing}");
    }
}
