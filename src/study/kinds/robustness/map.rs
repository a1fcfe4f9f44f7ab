//! Where a scene can be solved: the peak of a quantity over two axes, against a reference for each value along y.
//!
//! ```text
//! error = |peak − reference|/|reference|
//! ```

use crate::study::axis::AxisRecord;
use crate::study::case_outcome::CaseOutcome;
use crate::study::curve::{peak, peak_words};
use crate::study::kinds::robustness::record::MapRecord;
use crate::study::store::record::{StoredCase, StudyQuantity, StudyRecord};
use serde::Serialize;

/// Relative error \[–\] up to which an answer beyond the tolerance is poor; beyond it the answer is wrong.
const POOR: f64 = 0.1;

/// A map with a panel for every variant.
#[derive(Clone, Debug, Serialize, PartialEq)]
pub struct Map {
    pub family: String,
    pub setup: String,
    pub quantity: StudyQuantity,
    /// Kind of the peak over the cases of the map: `maximum`, `minimum`, `extreme` or `largest change of`
    pub peak_is: &'static str,
    pub axes: Vec<AxisRecord>,
    /// Peak of the reference for each value along y
    pub references: Vec<Option<f64>>,
    /// Cases of the study that serve as references but are not points of the map
    #[serde(skip)]
    pub reference_cases: Vec<MapPoint>,
    pub panels: Vec<Panel>,
}

#[derive(Clone, Debug, Serialize, PartialEq)]
pub struct Panel {
    pub variant: String,
    pub label: String,
    pub points: Vec<MapPoint>,
    /// Share of correct answers among the judged points \[–\], which exclude references and points without an answer; `None` if no point is judged
    pub holds: Option<f64>,
    /// Mean iterations and cuts per step over the points at each value of x
    pub iterations: Vec<f64>,
    pub cuts: Vec<f64>,
}

#[derive(Clone, Debug, Serialize, PartialEq)]
pub struct MapPoint {
    pub case: String,
    /// Index along x and y
    pub at: [usize; 2],
    pub grade: Grade,
    pub status: String,
    pub peak: Option<f64>,
    pub error: Option<f64>,
    pub iterations_per_step: f64,
    pub cuts: usize,
}

/// Trustworthiness of an answer.
#[derive(Clone, Copy, Debug, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Grade {
    /// The answer is within the tolerance of the study
    Right,
    /// The answer by which the others along x are judged
    Reference,
    /// Converged, but the reference has no answer
    Unjudged,
    /// The answer is not within the tolerance, but within 10 %
    Poor,
    /// Farther off than both the tolerance and 10 %, although the run converged
    Wrong,
    /// A stated reason instead of an answer
    Stated,
    /// A value that is not finite, or a panic
    Broken,
}

impl Map {
    /// Outcomes of the points and of their references by case. An inaccurate answer is what a map looks for and does not fail; a value that is not
    /// finite does.
    pub fn outcomes(&self) -> impl Iterator<Item = (String, CaseOutcome)> {
        self.panels.iter().flat_map(|p| &p.points).chain(&self.reference_cases).map(|p| {
            let outcome = match p.grade {
                Grade::Right => CaseOutcome::Pass,
                Grade::Reference | Grade::Unjudged => CaseOutcome::Unchecked,
                Grade::Stated => CaseOutcome::Stopped,
                Grade::Poor | Grade::Wrong => CaseOutcome::Inaccurate,
                Grade::Broken => CaseOutcome::Fail,
            };
            (p.case.clone(), outcome)
        })
    }
}

pub(super) fn analyse(map: &MapRecord, study: &StudyRecord, stored: &[StoredCase]) -> Map {
    let of = |family: &str, variant: Option<&str>, member: &str| {
        let wanted = |c: &&StoredCase| {
            let r = &c.record;
            r.family == family && r.member == member && variant.is_none_or(|v| r.variant == v)
        };
        stored.iter().find(wanted)
    };
    let is_stored = |v: &&String| stored.iter().any(|c| c.is_in(&map.family, v));
    let variants: Vec<&String> = study.variants.iter().filter(is_stored).collect();
    // The variant that the study names first, even if only other variants have results
    let members = || study.families.iter().filter(|f| f.name == map.family).flat_map(|f| &f.members);
    let is_of_map = |v: &&String| members().any(|m| m.variant == **v);
    let of_references = study.variants.iter().find(is_of_map).or(variants.first().copied());
    let reference = |y: usize| {
        let case = match &map.reference {
            Some(family) => of(family, None, map.rows.get(y)?),
            None => {
                let member = map.points.iter().find(|(_, at)| at[..] == [0, y])?.0;
                of(&map.family, Some(of_references?), member)
            }
        };
        case.filter(|c| c.record.converged()).and_then(|c| peak(c, &map.quantity.name))
    };
    let references: Vec<Option<f64>> = (0..map.axes[1].values.len()).map(reference).collect();
    let reference_cases = map.rows.iter().enumerate().filter_map(|(y, row)| {
        let case = of(map.reference.as_ref()?, None, row)?;
        Some(point(map, study.tolerance, case, [0, y], None))
    });
    let panel = |variant: &String| {
        let mut points: Vec<MapPoint> = (map.points.iter())
            .filter_map(|(member, at)| {
                let case = of(&map.family, Some(variant), member)?;
                Some(point(map, study.tolerance, case, [at[0], at[1]], references[at[1]]))
            })
            .collect();
        points.sort_by_key(|p| (p.at[1], p.at[0]));
        let holds_references = map.reference.is_none() && of_references == Some(variant);
        for p in points.iter_mut().filter(|p| holds_references && p.at[0] == 0 && p.grade == Grade::Right) {
            p.grade = Grade::Reference;
        }
        let count = |grade: Grade| points.iter().filter(|p| p.grade == grade).count();
        let judged = points.len() - count(Grade::Reference) - count(Grade::Unjudged);
        let mean = |x: usize, f: &dyn Fn(&MapPoint) -> f64| {
            let here: Vec<f64> = points.iter().filter(|p| p.at[0] == x).map(f).collect();
            here.iter().sum::<f64>() / here.len().max(1) as f64
        };
        let columns = 0..map.axes[0].values.len();
        let iterations = columns.clone().map(|x| mean(x, &|p| p.iterations_per_step)).collect();
        let cuts = columns.map(|x| mean(x, &|p| p.cuts as f64)).collect();
        let holds = (judged > 0).then(|| count(Grade::Right) as f64 / judged as f64);
        let label = study.labels.get(variant).unwrap_or(variant).clone();
        Panel { variant: variant.clone(), label, points, holds, iterations, cuts }
    };
    Map {
        family: map.family.clone(),
        setup: map.setup.clone(),
        quantity: map.quantity.clone(),
        peak_is: peak_words(stored.iter().filter(|c| c.record.family == map.family), &map.quantity.name),
        axes: map.axes.clone(),
        reference_cases: reference_cases.collect(),
        panels: variants.iter().copied().map(panel).collect(),
        references,
    }
}

fn point(map: &MapRecord, tolerance: f64, case: &StoredCase, at: [usize; 2], reference: Option<f64>) -> MapPoint {
    let r = &case.record;
    let found = peak(case, &map.quantity.name).filter(|_| r.converged());
    let finite = |v: &Vec<f64>| v.iter().all(|x| x.is_finite());
    let own = map.quantity.tolerance(tolerance);
    let of_scale = |(p, r): (f64, f64)| (own.scale(r) > 0.0).then(|| (p - r).abs() / own.scale(r));
    let error = found.zip(reference).and_then(of_scale);
    let grade = match (r.converged(), error) {
        (false, _) if r.broke() => Grade::Broken,
        (false, _) => Grade::Stated,
        _ if !case.series.columns.values().all(finite) => Grade::Broken,
        (_, Some(e)) if e <= tolerance => Grade::Right,
        (_, Some(e)) if e <= POOR => Grade::Poor,
        (_, Some(_)) => Grade::Wrong,
        (_, None) => Grade::Unjudged,
    };
    MapPoint {
        case: r.id.clone(),
        at,
        grade,
        status: r.status.clone(),
        peak: found,
        error,
        iterations_per_step: r.all_iterations() as f64 / r.steps.max(1) as f64,
        cuts: r.cuts,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ExtremeKind;
    use crate::solve::Status;
    use crate::study::store::record::{PANICKED, ProbeRecord, Series};

    fn study() -> StudyRecord {
        serde_json::from_value(serde_json::json!({
            "study": "", "kind": "robustness", "question": "", "expectation": "", "tolerance": 0.01, "quantities": {},
            "variants": ["strict"], "families": [], "version": ""
        }))
        .expect("a record")
    }

    /// The reference of a row may end with a stated reason; it fails only if it broke. Nothing is then compared with it.
    #[test]
    fn references_have_outcomes_of_their_own() {
        let axis = |name: &str| AxisRecord {
            name: name.into(),
            keys: vec![],
            label: name.into(),
            symbol: name.into(),
            unit: String::new(),
            values: vec!["1".into(), "2".into(), "3".into()],
            numbers: vec![1.0, 2.0, 3.0],
        };
        let statuses = [("a", Status::Converged.name()), ("b", "StepTooSmall"), ("c", PANICKED)];
        let stored = statuses.map(|(member, status)| {
            let mut case = StoredCase::new(Default::default(), Series::default());
            let r = &mut case.record;
            (r.id, r.family, r.member) = (member.into(), "map-reference".into(), member.into());
            r.status = status.into();
            case
        });
        let map = MapRecord {
            family: "map".into(),
            setup: String::new(),
            quantity: StudyQuantity::default(),
            axes: vec![axis("dt"), axis("load")],
            points: Default::default(),
            reference: Some("map-reference".into()),
            rows: statuses.map(|(member, _)| member.to_string()).into(),
        };
        let found = analyse(&map, &study(), &stored);
        let outcomes: Vec<CaseOutcome> = found.outcomes().map(|(_, outcome)| outcome).collect();
        assert_eq!(outcomes, [CaseOutcome::Unchecked, CaseOutcome::Stopped, CaseOutcome::Fail]);
    }

    /// Three steps at two loads; the second step is right, the third one is off by 5 %. The first are the references of the others and do not count
    /// as right answers.
    #[test]
    fn the_reference_is_not_judged_by_itself() {
        let axis = |name: &str, count: usize| AxisRecord {
            name: name.into(),
            keys: vec![],
            label: name.into(),
            symbol: name.into(),
            unit: String::new(),
            values: (0..count).map(|k| k.to_string()).collect(),
            numbers: (0..count).map(|k| k as f64).collect(),
        };
        let (mut points, mut stored) = (std::collections::BTreeMap::new(), vec![]);
        for (x, y) in (0..3).flat_map(|x| (0..2).map(move |y| (x, y))) {
            let member = format!("x{x}_y{y}");
            points.insert(member.clone(), vec![x, y]);
            let mut case = StoredCase::new(Default::default(), Series::default());
            let r = &mut case.record;
            (r.id, r.family, r.variant, r.member) = (member.clone(), "map".into(), "strict".into(), member);
            r.status = Status::Converged.name().into();
            let peak = [1.0, 1.001, 1.05][x];
            let probe = ProbeRecord {
                peak,
                peak_is: ExtremeKind::Maximum,
                peak_t_s: 1.0,
                last: peak,
                opposite: None,
                motion: None,
            };
            r.probes.insert("angle_deg".into(), probe);
            stored.push(case);
        }
        let quantity = StudyQuantity { name: "angle_deg".into(), ..StudyQuantity::default() };
        let axes = vec![axis("dt", 3), axis("load", 2)];
        let setup = String::new();
        let mut map = MapRecord { family: "map".into(), setup, quantity, axes, points, reference: None, rows: vec![] };
        let study = study();
        let panel = analyse(&map, &study, &stored).panels.remove(0);
        let grades: Vec<Grade> = panel.points.iter().map(|p| p.grade).collect();
        let row = [Grade::Reference, Grade::Right, Grade::Poor];
        assert_eq!((grades, panel.holds), ([row, row].concat(), Some(0.5)));
        // An absolute error of 0.05 is accepted, whatever the value
        map.quantity.absolute_tolerance = Some(0.06);
        assert_eq!(analyse(&map, &study, &stored).panels.remove(0).holds, Some(1.0));
        // A tolerance above the bound of poor answers takes precedence
        map.quantity.absolute_tolerance = None;
        for (tolerance, off, grade) in [
            (0.2, 0.15, Grade::Right),
            (0.2, 0.25, Grade::Wrong),
            (0.01, 0.15, Grade::Wrong),
            (0.01, 0.05, Grade::Poor),
            (0.06, 0.05, Grade::Right),
        ] {
            let last = |case: &&mut StoredCase| case.record.member.starts_with("x2");
            let probes = stored.iter_mut().filter(last).map(|case| &mut case.record.probes);
            probes.for_each(|probes| probes.get_mut("angle_deg").expect("recorded").peak = 1.0 + off);
            let study = StudyRecord { tolerance, ..study.clone() };
            let points = analyse(&map, &study, &stored).panels.remove(0).points;
            assert_eq!(points[2].grade, grade, "{off} with a tolerance of {tolerance}");
        }
        stored[2].series.columns.insert("other".into(), vec![0.0, f64::NAN, 1.0]);
        assert!(analyse(&map, &study, &stored).panels[0].points.iter().any(|p| p.grade == Grade::Broken));
    }
}
