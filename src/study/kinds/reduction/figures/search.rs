//! Figure of a greedy search: estimated error over the number of training states.

use crate::report::canvas::{INK, PALETTE, line, mark};
use crate::report::figure::{Figure, Sample};
use crate::report::plot::{Axis, Plot};
use crate::study::kinds::reduction::analysis::ReductionFindings;
use crate::study::kinds::reduction::figures::{SHAPES, sheet};
use crate::study::kinds::reduction::record::SearchStep;

/// Reads an estimate of a step, if it has one.
type Read = fn(&SearchStep) -> Option<f64>;

/// Draws the largest and the median estimate at the candidates.
pub fn search(a: &ReductionFindings) -> Option<Figure> {
    let derived = a.derived.as_ref()?;
    let series: [(Read, &str); 2] = [(|s| s.largest, "largest at the candidates"), (|s| s.median, "median")];
    let known = |read: Read| -> Vec<(f64, f64)> {
        let all = derived.search.iter().filter_map(|s| Some((s.states as f64, read(s)?)));
        all.filter(|(_, error)| *error > 0.0).collect()
    };
    if known(series[0].0).len() < 2 {
        return None;
    }
    let sample = |k: usize| Sample::Mark(SHAPES[k], if k == 0 { PALETTE[0] } else { INK });
    let entries = series.iter().enumerate().map(|(k, (_, name))| (sample(k), name.to_string())).collect();
    let svg = sheet(1, entries, |_, area, frame| {
        let all = || series.iter().flat_map(|(read, _)| known(*read));
        let most = all().map(|(states, _)| states).fold(0.0, f64::max);
        let x = Axis::linear([0.0, most].into_iter(), "training states");
        let y = Axis::log(all().map(|(_, error)| error), "estimated error / largest change");
        let plot = Plot { area, frame, x, y };
        plot.grid();
        for (k, (read, _)) in series.iter().enumerate() {
            let color = if k == 0 { PALETTE[0] } else { INK };
            let points: Vec<_> = known(*read).into_iter().map(|(states, error)| plot.at(states, error)).collect();
            line(area, &points, color, 4);
            points.iter().for_each(|at| mark(area, SHAPES[k], *at, 14, color));
        }
        plot.axes(true);
    });
    let caption = "Estimated errors at the candidates of the greedy plan over the number of training states. New states are computed where the estimate is largest, so that the largest falls \
                   towards the median."
        .into();
    Some(Figure { name: "search".into(), svg, caption })
}
