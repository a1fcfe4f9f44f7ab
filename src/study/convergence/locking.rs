//! Cases whose pressures look locked: which ones, and what the verdict has to say of them.

use super::Cases;
use super::verdict::Setting;
use crate::study::record::CaseRecord;

/// What to do about the alarm.
pub const REMEDY: &str = "take formulation = \"mixed\", or show by a finer mesh that the answer stays";

/// Pressure scatter [–] of a case that raises the alarm.
fn alarm(c: &CaseRecord) -> Option<f64> {
    c.locking.filter(|l| l.alarm).map(|l| l.pressure_scatter)
}

/// Ids of the cases that raise the alarm, and a sentence about them.
pub fn alarms(cases: &Cases) -> (Vec<String>, Option<String>) {
    let records = || cases.stored.iter().map(|c| &c.record);
    let raised: Vec<(&CaseRecord, f64)> = records().filter_map(|c| Some((c, alarm(c)?))).collect();
    let mut formulations: Vec<&str> = raised.iter().map(|(c, _)| c.formulation.as_str()).collect();
    formulations.sort_unstable();
    formulations.dedup();
    let each = |name: &&str| {
        let of = || raised.iter().filter(|(c, _)| c.formulation == **name);
        let all = records().filter(|c| c.formulation == **name).count();
        let (lo, hi) = of().fold((f64::INFINITY, 0.0f64), |(a, b), (_, s)| (a.min(*s), b.max(*s)));
        format!("{} of {all} cases of {name} (by {lo:.2} to {hi:.2})", of().count())
    };
    let words: Vec<String> = formulations.iter().map(each).collect();
    let sentence = (!words.is_empty()).then(|| {
        format!(
            "Locking alarm: pressures that scatter from cell to cell by more than half of the deviatoric stress in {}. \
             Their stiffness is partly the mesh's: {REMEDY}.",
            words.join(" and ")
        )
    });
    (raised.into_iter().map(|(c, _)| c.id.clone()).collect(), sentence)
}

/// Does the recommended setting raise the alarm?
pub fn of_recommended(cases: &Cases, setting: &Setting) -> String {
    let of = cases.stored.iter().map(|c| &c.record).filter(|c| setting.cases.contains(&c.id));
    let worst = of.filter_map(alarm).fold(0.0, f64::max);
    if worst == 0.0 {
        return String::new();
    }
    format!(
        " But it raises the locking alarm (pressure scatter {worst:.2}): it is within the tolerance in the judged quantities, its \
         pressures are not to be used; {REMEDY}."
    )
}
