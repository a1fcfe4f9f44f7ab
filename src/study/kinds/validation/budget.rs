//! The uncertainty of a prediction, broken down by its sources.
//!
//! Sources and data belong to groups such as `load`, `geometry` or `calibration: zero`. Independent contributions add as squares; the uncertainties
//! due to the mesh, the time steps and the response surface are groups of their own.

use crate::math::statistics::root;
use crate::study::kinds::validation::joint::Influence;
use serde::{Deserialize, Serialize};

/// Half-width of the 95 % interval of a normal distribution, in standard deviations.
pub const COVERAGE: f64 = 1.959_963_985;

/// One group of sources.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contribution {
    pub group: String,
    /// Standard deviation of the prediction due to this group \[unit of the quantity\]
    pub deviation: f64,
    /// Half-width of the 95 % interval of the prediction without this group
    pub without: f64,
}

/// Groups of the sources, of the data and of the own errors of a prediction, by name.
pub struct Groups<'a> {
    pub sources: &'a [String],
    /// Independent errors of each datum: (group, share of the variance)
    pub data: &'a [Vec<(String, f64)>],
    pub own: &'a [String],
}

/// Returns the contributions, largest first. `numerical` gives the standard deviations of the groups that no measurement has, such as the mesh;
/// `factor` widens the statistical part.
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

/// Returns the half-width of the 95 % interval.
pub fn half_width(all: &[Contribution]) -> f64 {
    COVERAGE * all.iter().map(|c| c.deviation * c.deviation).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Variances of a group add, the largest group comes first, and the remainder without it is what the others contribute.
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
