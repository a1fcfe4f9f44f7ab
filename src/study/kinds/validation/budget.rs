//! The uncertainty of a prediction by where it comes from.
//!
//! Sources and data belong to groups, `load`, `geometry`, `calibration: zero`. Independent contributions add as squares; what the mesh, the time
//! steps and the response surface leave open are groups of their own.

use crate::math::statistics::root;
use crate::study::kinds::validation::joint::Influence;
use serde::{Deserialize, Serialize};

/// Half-width of a 95 % interval in standard deviations, of a normal distribution.
pub const COVERAGE: f64 = 1.959_963_985;

/// One group of sources.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contribution {
    pub group: String,
    /// Standard deviation of the prediction by this group \[unit of the quantity\]
    pub deviation: f64,
    /// Half-width of the 95 % interval of the prediction without this group
    pub without: f64,
}

/// Groups of sources, of data and of the own errors of a prediction, by name.
pub struct Groups<'a> {
    pub sources: &'a [String],
    /// \[data\] independent errors of each: (group, share of the variance)
    pub data: &'a [Vec<(String, f64)>],
    pub own: &'a [String],
}

/// Contributions, largest first. `numerical`: standard deviations of the groups that no measurement has, such as the mesh; `factor`: by which
/// the statistical part is widened.
pub fn contributions(
    influence: &Influence,
    groups: &Groups,
    factor: f64,
    numerical: &[(&str, f64)],
) -> Vec<Contribution> {
    let mut variances: Vec<(String, f64)> = vec![];
    let mut add = |group: &str, variance: f64| match variances.iter_mut().find(|(g, _)| g == group) {
        Some((_, sum)) => *sum += variance,
        None => variances.push((group.into(), variance)),
    };
    let wide = factor * factor;
    influence.sources.iter().zip(groups.sources).for_each(|(d, g)| add(g, wide * d * d));
    for (d, shares) in influence.data.iter().zip(groups.data) {
        shares.iter().for_each(|(g, share)| add(g, wide * share * d * d));
    }
    influence.own.iter().zip(groups.own).for_each(|(d, g)| add(g, wide * d * d));
    numerical.iter().for_each(|(g, d)| add(g, d * d));
    let total: f64 = variances.iter().map(|(_, v)| v).sum();
    variances.retain(|(_, v)| *v > 0.0);
    variances.sort_by(|a, b| b.1.total_cmp(&a.1));
    let one =
        |(group, v): (String, f64)| Contribution { group, deviation: v.sqrt(), without: COVERAGE * root(total - v) };
    variances.into_iter().map(one).collect()
}

/// Half-width of the 95 % interval.
pub fn half_width(all: &[Contribution]) -> f64 {
    COVERAGE * all.iter().map(|c| c.deviation * c.deviation).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Variances of a group add, the largest group is first, and what remains without it is what the others make.
    #[test]
    fn groups_add_as_squares() {
        let influence = Influence { sources: vec![0.3, -0.4], data: vec![1.0], own: vec![2.0] };
        let groups = Groups {
            sources: &["load".into(), "load".into()],
            data: &[vec![("zero".into(), 0.25), ("noise".into(), 0.75)]],
            own: &["zero".into()],
        };
        let all = contributions(&influence, &groups, 1.0, &[("mesh", 0.1), ("steps", 0.0)]);
        let names: Vec<&str> = all.iter().map(|c| c.group.as_str()).collect();
        assert_eq!(names, ["zero", "noise", "load", "mesh"]);
        assert!((all[0].deviation - 4.25_f64.sqrt()).abs() < 1e-14 && (all[2].deviation - 0.5).abs() < 1e-14);
        assert!((half_width(&all) - COVERAGE * (4.25_f64 + 0.75 + 0.25 + 0.01).sqrt()).abs() < 1e-13);
        assert!((all[0].without - COVERAGE * (0.75_f64 + 0.25 + 0.01).sqrt()).abs() < 1e-13);
        let wider = contributions(&influence, &groups, 2.0, &[("mesh", 0.1)]);
        assert!((wider[3].deviation - 0.1).abs() < 1e-14 && (wider[2].deviation - 1.0).abs() < 1e-14);
    }
}
