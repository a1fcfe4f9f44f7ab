//! Work–precision diagram of meshes and reduced models together, from seconds down to microseconds.

use crate::report::canvas::{Mark as Shape, PALETTE, line, mark};
use crate::report::figure::{Figure, Sample};
use crate::report::plot::{Axis, Plot};
use crate::study::kinds::reduction::analysis::ReductionFindings;
use crate::study::kinds::reduction::figures::{sheet, time_unit};

/// A series of the figure: its shape, its name, and the time and error of each of its points.
struct Series {
    shape: Shape,
    name: &'static str,
    points: Vec<(f64, Vec<f64>)>,
}

/// Draws the distances from the reference over the time of a step.
pub fn meshes(a: &ReductionFindings) -> Option<Figure> {
    let derived = a.derived.as_ref()?;
    let of = derived.comparison.as_ref()?;
    let share = |errors: &[f64]| errors.iter().zip(&of.sizes).map(|(e, size)| e / size).collect::<Vec<f64>>();
    let mut by_cells: Vec<_> = of.meshes.iter().skip(1).collect();
    by_cells.sort_by_key(|m| m.cells);
    let models = derived.models.iter().zip(&of.models);
    let series = [
        Series {
            shape: Shape::Square,
            name: "meshes",
            points: by_cells.iter().map(|m| (m.step_s, share(&m.errors))).collect(),
        },
        Series {
            shape: Shape::Triangle,
            name: "the mesh of the models",
            points: of.meshes.iter().take(1).map(|m| (m.step_s, share(&m.errors))).collect(),
        },
        Series {
            shape: Shape::Circle,
            name: "reduced models",
            points: models.filter_map(|(m, errors)| Some((m.leap_s[0], share(errors.as_ref()?)))).collect(),
        },
    ];
    let all = || series.iter().flat_map(|s| &s.points);
    let errors = || all().flat_map(|(_, errors)| errors.iter().copied()).filter(|e| *e > 0.0);
    errors().next()?;
    let (factor, unit) = time_unit(all().map(|(time, _)| *time).fold(0.0, f64::max));
    let color = |k: usize| PALETTE[k % PALETTE.len()];
    let shown = series.iter().filter(|s| !s.points.is_empty());
    let shapes = shown.map(|s| (Sample::Mark(s.shape, crate::report::canvas::INK), s.name.to_string()));
    let quantities = a.quantities.iter().enumerate().map(|(k, q)| (Sample::Line(color(k)), q.label.clone()));
    let svg = sheet(1, shapes.chain(quantities).collect(), |_, area, frame| {
        let x = Axis::log(all().map(|(time, _)| factor * time), &format!("time of a step [{unit}]"));
        let y = Axis::log(errors(), "largest distance / largest change");
        let plot = Plot { area, frame, x, y };
        plot.grid();
        for k in 0..a.quantities.len() {
            for s in &series {
                let points = s.points.iter().filter(|(_, errors)| errors[k] > 0.0);
                let points: Vec<_> = points.map(|(time, errors)| plot.at(factor * time, errors[k])).collect();
                line(area, &points, color(k), 4);
                points.iter().for_each(|at| mark(area, s.shape, *at, 16, color(k)));
            }
        }
        plot.axes(true);
    });
    let caption = format!(
        "Largest distance from a mesh of {} cells over the CPU time of a step, at {} states that were held back. A reduced model comes no nearer to the reference than its own mesh, but for chance; \
         its step is one from state to state.",
        of.reference_cells, of.points
    );
    Some(Figure { name: "meshes".into(), svg, caption })
}
