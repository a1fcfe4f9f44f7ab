//! Pictures of failures: the body of each failed case in the state farthest from rest.

use crate::report::canvas::{RGB, figure, mm};
use crate::report::figure::Figure;
use crate::report::panels::{Panels, headed};
use crate::report::surface::{Fit, Look, View, extent, surface};
use crate::study::case_outcome::CaseOutcome;
use crate::study::figures::first_of;
use crate::study::kinds::robustness::analysis::RobustnessFindings;
use crate::study::store::results::Results;

const EYE: [f64; 3] = [0.55, -1.0, 0.45];
const WIDE: f64 = 56.0;
const TALL: f64 = 42.0;
/// Largest number of panels; more would add nothing.
const MOST: usize = 9;

/// Draws the failed cases; `None` if no case failed.
pub fn draw(store: &Results, a: &RobustnessFindings) -> Option<Figure> {
    let failed = a.cases.iter().filter(|c| c.outcome == CaseOutcome::Fail);
    let mut shown: Vec<_> = failed
        .filter_map(|c| Some((c, store.skins.get(&c.case)?)))
        .filter(|(_, s)| s.displacement.iter().flatten().all(|x| x.is_finite()))
        .collect();
    let more = first_of(shown.len(), MOST, "failed cases");
    shown.truncate(MOST);
    if shown.is_empty() {
        return None;
    }
    let panels = Panels::new(shown.len(), (0.0, 4.0, 0.0), (44.0, WIDE));
    let tall = panels.tall(TALL, (8.0, 10.0));
    let frame = |k: usize| panels.frame(k, (6.0, tall + 8.0), tall).map(mm);
    let view = View::from(EYE);
    let mut under = String::new();
    for (k, (_, skin)) in shown.iter().enumerate() {
        let moved = skin.points.iter().zip(&skin.displacement);
        let moved: Vec<[f64; 3]> = moved.map(|(x, u)| std::array::from_fn(|i| x[i] + u[i])).collect();
        let fit = Fit::new(extent(moved.iter().map(|p| view.project(*p))), frame(k));
        let look = Look {
            color: &|_| RGB(0xdd, 0xe6, 0xee),
            edge: Some((RGB(0x33, 0x44, 0x55), 2.0)),
            outline: None,
            shade: 0.8,
        };
        under += &surface(&moved, &skin.facets(), &view, &fit, &look);
    }
    let svg = figure(panels.width(), panels.rows() * (tall + 8.0) + 2.0, &under, |area| {
        for (k, (case, _)) in shown.iter().enumerate() {
            let [left, top, ..] = frame(k);
            // The last panel has no margin on its right that a heading could extend into, as the others have
            let wide = mm(panels.each - 2.0);
            headed(area, (left, top), wide, None, &format!("{}: {}", case.case, case.status));
        }
    });
    let caption =
        format!("Failed cases at the state farthest from rest; the last good state is cases/<id>/last-0000.vtu.{more}");
    Some(Figure { name: "failures".into(), svg, caption })
}
