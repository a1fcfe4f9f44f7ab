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

pub fn verdict(quantities: &[ByQuantity<CostOfAccuracy>], tolerance: f64, missing: usize) -> String {
    let mut parts = vec![];
    for q in quantities {
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
                format!("{title} costs {} by {}", seconds(s.cost_s), s.label)
            }
            None => format!("no setting is known to meet {title}"),
        };
        if let Some((cheap, expensive, ratio)) = ratio(q, level) {
            let cost = expensive.costs[level].filter(|p| p.how == How::Extrapolated);
            let own = cheap.costs[level].map_or(f64::NAN, |p| p.seconds);
            let extrapolated = cost.map_or(String::new(), |p| match p.interval {
                Some([low, high]) => {
                    format!(" by extrapolation (95 %: {} to {} times)", times(low / own), times(high / own))
                }
                None => " by extrapolation".into(),
            });
            let ratio = times(ratio);
            words +=
                &format!(", {} would cost {ratio} times as much as {}{extrapolated}", expensive.label, cheap.label);
        }
        parts.push(words);
    }
    if parts.is_empty() {
        return "No verdict: no quantity has a reference.".into();
    }
    format!("Within {}: {}.{}", percent(tolerance), parts.join("; "), without_result(missing))
}
