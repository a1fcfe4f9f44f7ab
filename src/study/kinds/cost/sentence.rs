//! One sentence per quantity, and the verdict.

use crate::report::numbers::{capital, minus_signs, percent, seconds, space, times, within};
use crate::study::analysis::{ByQuantity, without_result};
use crate::study::kinds::cost::findings::{CostOfAccuracy, Measure};
use crate::study::kinds::cost::line::{How, LevelCost, Line};

/// The cheapest setting that meets the tolerance and the cost of the next better one, for the peak and for the curve.
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
    let [peak, half] = [r.peak, half].map(|v| minus_signs(&within(v, half)));
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

/// Ratio of costs below which they count as equal.
const RATIO: f64 = 1.5;

/// The cheapest and the most expensive family at a level, if both have their own cost and the ratio is significant.
fn extremes(q: &ByQuantity<CostOfAccuracy>, level: usize) -> Option<[(&str, LevelCost); 2]> {
    let own = |l: &Line| l.costs.get(level).copied().flatten();
    let by_cost: Vec<(&str, LevelCost)> = q.lines.iter().filter_map(|l| Some((l.label.as_str(), own(l)?))).collect();
    let cheap = by_cost.iter().min_by(|a, b| a.1.seconds.total_cmp(&b.1.seconds))?;
    let expensive = by_cost.iter().max_by(|a, b| a.1.seconds.total_cmp(&b.1.seconds))?;
    let known = expensive.1.how != How::AtMost;
    (known && expensive.1.seconds > RATIO * cheap.1.seconds).then_some([*cheap, *expensive])
}

/// Ratio of the ends of an interval above which its upper end is not informative.
const WIDE: f64 = 1e3;

/// The cost of one family relative to that of a cheaper one. The interval of the ratio runs from the smallest cost of the former over the largest of
/// the latter to the largest over the smallest.
fn relative_cost([(cheap, less), (expensive, more)]: [(&str, LevelCost); 2]) -> String {
    let [low, high] = [more.ends()[0] / less.ends()[1], more.ends()[1] / less.ends()[0]];
    let would = |factor: String, how: &str| format!(", {expensive} would cost {factor} times as much as {cheap}{how}");
    let ratio = times(more.seconds / less.seconds);
    let extrapolated = [more, less].iter().any(|cost| cost.how == How::Extrapolated);
    match extrapolated {
        false if less.how == How::AtMost => would(format!("at least {ratio}"), ""),
        false => would(ratio, ""),
        true if low <= 1.0 => format!(
            ", and too few cases tell whether {expensive} would cost more than {cheap}: the 95 % interval of the ratio of their costs begins below 1"
        ),
        true if high > WIDE * low => would(format!("at least {}", times(low)), " by extrapolation (95 %)"),
        true => would(ratio, &format!(" by extrapolation (95 %: {} to {} times)", times(low), times(high))),
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
        words += &extremes(q, level).map_or(String::new(), relative_cost);
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

    fn cost(seconds: f64, how: How, interval: Option<[f64; 2]>) -> LevelCost {
        LevelCost { seconds, how, interval }
    }

    #[test]
    fn an_interval_that_says_nothing_is_said_in_words() {
        let words = |less, more| relative_cost([("tet10", less), ("tet4", more)]);
        let over = |less, ends| words(less, cost(7e4, How::Extrapolated, Some(ends)));
        let known = cost(1.0, How::Between, None);
        assert_eq!(words(known, cost(7e4, How::Between, None)), ", tet4 would cost 7e4 times as much as tet10");
        assert!(over(known, [5e4, 9e4]).ends_with("by extrapolation (95 %: 5e4 to 9e4 times)"));
        assert!(over(known, [2.0, 9e16]).contains("would cost at least 2.0 times as much as tet10"));
        let nothing = over(known, [5.3e-8, 9e16]);
        assert!(nothing.contains("too few cases tell whether tet4 would cost more than tet10"), "{nothing}");
        assert!(!nothing.contains("times"), "{nothing}");
    }

    /// The interval of a ratio combines those of both costs: 50 to 90 s over 0.5 to 2 s is 25 to 180. Costs with overlapping intervals have no order.
    #[test]
    fn the_interval_of_a_ratio_is_of_both_costs() {
        let words =
            |less| relative_cost([("tet10", less), ("tet4", cost(70.0, How::Extrapolated, Some([50.0, 90.0])))]);
        let own = |ends| words(cost(1.0, How::Extrapolated, Some(ends)));
        assert!(
            own([0.5, 2.0])
                .ends_with(", tet4 would cost 70 times as much as tet10 by extrapolation (95 %: 25 to 180 times)")
        );
        assert!(own([1e-4, 2.0]).ends_with("at least 25 times as much as tet10 by extrapolation (95 %)"));
        let overlap = own([1e-4, 60.0]);
        assert!(overlap.contains("too few cases") && !overlap.contains("times"), "{overlap}");
        // A cost of at most that of the coarsest case may be lower by an unknown amount
        let least = words(cost(1.0, How::AtMost, None));
        assert!(least.ends_with("would cost at least 50 times as much as tet10 by extrapolation (95 %)"), "{least}");
        let measured = relative_cost([("b", cost(0.32, How::AtMost, None)), ("a", cost(0.7, How::Between, None))]);
        assert_eq!(measured, ", a would cost at least 2.2 times as much as b");
    }
}
