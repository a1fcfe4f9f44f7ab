//! Coverage of the 95 % intervals of direct fits, and false verdicts, in synthetic tests with known constants.
//!
//! Every scenario is a binomial count, of 200 draws with probability 0.95 with a standard deviation of 3.1: 95 ± 3 %, widened by two of them, 88.9 % or more. That many hold however wide the
//! intervals are, so that their half-widths are compared with the scatter of the constants between the draws, which 100 draws know to 7 % ([`Coverage`]). The table of 2 000 draws in
//! `docs/verification.md` is that of the ignored test, within 95 ± 3 % itself.

use crate::common::Random;
use crate::common::coverage::{Coverage, draws};
use crate::common::made::table;
use durometer::calibrate::{
    Accuracy, ErrorModel, Experiment, FitOptions, FitResult, FitWarning, FittableLaw, Mode, Sample, SlackChoice,
    fit_experiment,
};
use rayon::prelude::*;

/// Errors of a scenario.
#[derive(Clone, Copy)]
enum Errors {
    /// Standard deviation \[Pa\]
    Independent(f64),
    /// AR(1): correlation of neighbours, standard deviation \[Pa\]
    Correlated(f64, f64),
    /// Specimens, relative standard deviation of the stiffness, standard deviation of a stress \[Pa\]
    Between(usize, f64, f64),
    /// Slack of strain, standard deviation \[Pa\]
    Slack(f64, f64),
    /// Standard deviations that the user states, of the zero of the stress \[Pa\] and of the scales of stress and strain, and one that the residuals show
    /// \[Pa\]
    Shared([f64; 3], f64),
}

struct Scenario {
    name: &'static str,
    law: &'static str,
    values: &'static [f64],
    rows: usize,
    stretch: [f64; 2],
    errors: Errors,
    slack: SlackChoice,
}

/// Largest share of draws of independent errors that pass as correlated \[%\]: 13 of 100 do, and four standard deviations.
const MOST_CORRELATED: f64 = 26.0;
/// Largest median half-width for use over the scatter, of errors of correlated neighbours: 7.2, and three times 7 %.
const WIDEST_IN_USE: f64 = 9.0;
const SEVERAL: &str = "independent, 60 rows, two minima";
const MU: &[f64] = &[0.1e6];
const MOONEY: &[f64] = &[0.04e6, 0.01e6];
const YEOH: &[f64] = &[0.05e6, -8e2, 30.0];
/// One mode: a second term with α₂ = 5 and one with about −10 are nearly alike, and fits end in both
const OGDEN: &[f64] = &[0.1e6, 1.6, 2e3, 5.0];

fn scenarios() -> Vec<Scenario> {
    use Errors::{Between, Correlated, Independent, Shared, Slack};
    use SlackChoice::{Auto, Yes};
    let of =
        |name, law, values, rows, stretch, errors, slack| Scenario { name, law, values, rows, stretch, errors, slack };
    vec![
        of("independent, 100 rows", "neo_hookean", MU, 100, [1.01, 2.0], Independent(2e3), Auto),
        of("independent, 100 rows", "yeoh", YEOH, 100, [1.01, 3.5], Independent(2e3), Auto),
        of("independent, 20 rows", "neo_hookean", MU, 20, [1.05, 2.0], Independent(2e3), Auto),
        of("independent, 20 rows", "yeoh", YEOH, 20, [1.05, 3.5], Independent(2e3), Auto),
        of("AR(1) 0.9, 300 rows", "neo_hookean", MU, 300, [1.01, 2.0], Correlated(0.9, 2e3), Auto),
        of("AR(1) 0.9, 300 rows", "yeoh", YEOH, 300, [1.01, 3.5], Correlated(0.9, 2e3), Auto),
        of("2 % scatter, 5 specimens", "neo_hookean", MU, 60, [1.01, 2.0], Between(5, 0.02, 50.0), Auto),
        of("2 % scatter, 5 specimens", "mooney_rivlin", MOONEY, 60, [1.01, 2.0], Between(5, 0.02, 50.0), Auto),
        of("3 % slack, by itself", "neo_hookean", MU, 100, [1.0, 2.0], Slack(0.03, 500.0), Auto),
        of("3 % slack, by itself", "mooney_rivlin", MOONEY, 100, [1.0, 2.0], Slack(0.03, 500.0), Auto),
        of("stated zero and scales", "neo_hookean", MU, 100, [1.01, 2.0], Shared([1e3, 0.01, 0.01], 500.0), Auto),
        of("stated zero and scales", "yeoh", YEOH, 100, [1.01, 3.5], Shared([1e3, 0.01, 0.01], 500.0), Auto),
        of("3 % slack, --slack yes", "neo_hookean", MU, 100, [1.0, 2.0], Slack(0.03, 500.0), Yes),
        of("3 % slack, --slack yes", "mooney_rivlin", MOONEY, 100, [1.0, 2.0], Slack(0.03, 500.0), Yes),
        of(SEVERAL, "ogden", OGDEN, 60, [1.02, 3.0], Independent(2e3), Auto),
    ]
}

impl Scenario {
    fn model(&self) -> FittableLaw {
        let terms = match self.law {
            "neo_hookean" => 1,
            "ogden" => self.values.len() / 2,
            _ => self.values.len(),
        };
        FittableLaw::new(self.law, Some(terms)).expect("registered")
    }

    fn draw(&self, seed: u64) -> Experiment {
        let mut random = Random::seed(1 + 7919 * seed);
        (0..40).for_each(|_| {
            random.unit();
        });
        let specimens = if let Errors::Between(k, ..) = self.errors { k } else { 1 };
        let [low, high] = self.stretch;
        let mut samples = vec![];
        for specimen in 0..specimens {
            let level = if let Errors::Between(_, s, _) = self.errors { 1.0 + s * random.normal() } else { 1.0 };
            let mut before = random.normal();
            let shared =
                if let Errors::Shared(sizes, _) = self.errors { sizes.map(|s| s * random.normal()) } else { [0.0; 3] };
            for k in 0..self.rows {
                let stretch = low + (high - low) * k as f64 / (self.rows - 1) as f64;
                let z = random.normal();
                let (real, error) = match self.errors {
                    Errors::Independent(size) | Errors::Between(_, _, size) => (stretch, size * z),
                    Errors::Shared(_, size) => (1.0 + (stretch - 1.0) / (1.0 + shared[2]), size * z + shared[0]),
                    Errors::Slack(e, size) => ((stretch - e).max(1.0), size * z),
                    Errors::Correlated(rho, size) => {
                        before = rho * before + (1.0 - rho * rho).sqrt() * z;
                        (stretch, size * before)
                    }
                };
                let stress = level * (1.0 + shared[1]) * self.model().stress(self.values, Mode::Uniaxial, real) + error;
                let line = k as u64 + 2;
                samples.push(Sample { mode: Mode::Uniaxial, stretch, stress, line, specimen, second: 1.0 });
            }
        }
        let mut e = table(samples);
        e.specimens = (0..specimens).map(|k| format!("{k}.csv")).collect();
        e
    }

    /// Bounds of the median half-width over the scatter of a constant: t of many degrees of freedom, of four between five specimens, and of few where neighbours are correlated, known to three times 7 %. The scatter
    /// between two minima is more than the intervals of most draws.
    fn width(&self) -> [f64; 2] {
        match self.errors {
            _ if self.name == SEVERAL => [1.0, 2.5],
            Errors::Between(..) => [2.0, 3.3],
            Errors::Correlated(..) => [2.0, 3.8],
            Errors::Independent(..) | Errors::Slack(..) | Errors::Shared(..) => [1.5, 2.5],
        }
    }

    /// Whether a fit of a law to the draw gives some constant another value over a shorter range.
    fn depends_on_range(&self, law: &str, seed: u64) -> bool {
        let mut o = FitOptions::new(law);
        o.terms = (law == self.law).then_some(self.model().terms);
        let r = fit_experiment(&self.draw(seed), &o).unwrap_or_else(|e| panic!("{}: {e}", self.name));
        assert!(r.range_dependence.len() > 3, "{}: {} ranges", self.name, r.range_dependence.len());
        r.range_spread.iter().any(|[low, high]| low < high)
    }

    fn fit(&self, seed: u64) -> FitResult {
        let mut o = FitOptions::new(self.law);
        (o.terms, o.slack, o.ranges) = (Some(self.model().terms), self.slack, 0);
        if let Errors::Shared([zero, stress, strain], _) = self.errors {
            let stated = [
                format!("stress_zero={} Pa", 1.96 * zero),
                format!("stress_scale={}", 1.96 * stress),
                format!("strain_scale={}", 1.96 * strain),
            ];
            o.accuracy = stated
                .iter()
                .map(|text| text.parse().expect("valid"))
                .fold(Accuracy::default(), |a, b: Accuracy| b.or(&a));
        }
        fit_experiment(&self.draw(seed), &o).unwrap_or_else(|e| panic!("{}: {e}", self.name))
    }

    fn count(&self, draws: u64) -> Counts {
        let all: Vec<FitResult> = (0..draws).into_par_iter().map(|seed| self.fit(seed)).collect();
        let percent =
            |is: &dyn Fn(&FitResult) -> bool| 100.0 * all.iter().filter(|r| is(r)).count() as f64 / draws as f64;
        let of = |k: usize| {
            let found: Vec<_> = all.iter().map(|r| (r.parameters[k].value, r.parameters[k].interval)).collect();
            Coverage::of(self.values[k], &found)
        };
        Counts {
            constants: (0..self.values.len()).map(of).collect(),
            in_use: Coverage::of(
                self.values[0],
                &all.iter().map(|r| (r.parameters[0].value, r.in_use[0])).collect::<Vec<_>>(),
            ),
            pattern: percent(&|r| r.warnings.iter().any(|w| matches!(w, FitWarning::Systematic { .. }))),
            slack: percent(&|r| !r.slack.is_empty()),
            correlated: percent(&|r| matches!(r.errors, ErrorModel::Correlated { .. })),
        }
    }
}

/// Of the draws, percentages but for the constants.
struct Counts {
    constants: Vec<Coverage>,
    /// The intervals for use of the first constant
    in_use: Coverage,
    pattern: f64,
    slack: f64,
    correlated: f64,
}

fn study(scenarios: Vec<Scenario>, draws: u64, tolerance: f64, false_alarms: f64) {
    println!(
        "| errors | law | covered [%] | half-width over scatter | in use [%] | pattern reported [%] | slack fitted [%] | correlated [%] | mean error of the first [%] |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut wrong = vec![];
    for s in scenarios {
        let Counts { constants, in_use, pattern, slack, correlated } = s.count(draws);
        let list = |of: &dyn Fn(&Coverage) -> String| constants.iter().map(of).collect::<Vec<_>>().join(", ");
        let (covered, wide) = (list(&|c| format!("{:.1}", c.covered)), list(&|c| format!("{:.2}", c.wide)));
        println!(
            "| {} | {} | {covered} | {wide} | {:.1}, {:.2} | {pattern:.1} | {slack:.1} | {correlated:.1} | {:+.2} |",
            s.name,
            s.model().label(),
            in_use.covered,
            in_use.wide,
            constants[0].bias
        );
        // A shared zero is in the residuals too, and counts as scatter once more; an interval over several minima holds what lies between them
        let more = if matches!(s.errors, Errors::Shared(..)) || s.name == SEVERAL { 1.0 } else { 0.0 };
        let [narrowest, widest] = s.width();
        let is_off = |c: &Coverage| {
            c.covered < 95.0 - tolerance
                || c.covered > 95.0 + tolerance + more
                || !(narrowest..=widest).contains(&c.wide)
        };
        let first = &constants[0];
        // Misfits of neighbours that are correlated are in the interval for use
        let useful = if let Errors::Correlated(..) = s.errors { WIDEST_IN_USE } else { widest };
        let is_use_off = in_use.covered < first.covered || !(first.wide..=useful).contains(&in_use.wide);
        // The second minimum draws the constants
        let is_biased = s.name != SEVERAL && first.bias.abs() > 5.0 * first.bias_error;
        let is_model_off = match s.errors {
            Errors::Correlated(..) => correlated < 95.0 || slack > 5.0,
            Errors::Slack(..) => correlated > MOST_CORRELATED || slack < 95.0,
            Errors::Independent(..) | Errors::Between(..) => correlated > MOST_CORRELATED || slack > 5.0,
            // Their zero and scales pass as correlation in half of the draws
            Errors::Shared(..) => slack > 5.0,
        };
        if constants.iter().any(is_off) || pattern > false_alarms || is_use_off || is_biased || is_model_off {
            wrong.push(format!(
                "{} {}: {constants:?}, in use {in_use:?}, pattern {pattern}, slack {slack}, correlated {correlated}",
                s.name, s.law
            ));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// 3 % and two standard deviations of 200 draws, √(0.95·0.05/200) = 1.54 %; false alarms 5 % and two of them.
#[test]
fn the_headline_covers_in_95_of_100_tests() {
    // The second law of each kind of errors, slack by itself
    study(scenarios().into_iter().skip(1).step_by(2).take(6).collect(), draws(100), 3.0 + 2.0 * 1.54, 5.0 + 2.0 * 1.54);
}

/// Intervals that follow the least minimum alone hold the second term in half of the draws.
#[test]
fn intervals_hold_every_minimum() {
    study(
        scenarios().into_iter().filter(|s| s.name == SEVERAL).collect(),
        draws(50),
        3.0 + 2.0 * 1.54,
        5.0 + 2.0 * 1.54,
    );
}

/// The published table.
#[test]
#[ignore = "2 000 draws of every scenario"]
fn the_published_table_of_coverage() {
    study(scenarios(), 2000, 3.0, 5.0 + 2.0 * 0.49);
}

/// Of data of the law itself some constant is said to be another one over shorter ranges in 5 % of the draws at most, three standard deviations of the count allowed: the constants
/// of the shortest ranges are far off, and within their own errors. A law that does not describe the data has other
/// constants over shorter ranges in four of five draws at least: in the others its misfit, smooth as it is, passes as correlation of the errors.
#[test]
fn shorter_ranges_have_other_constants_where_the_law_does_not_fit() {
    const DRAWS: u64 = 120;
    const TWO_TERMS: &[f64] = &[60e3, 2e3];
    let of = |name, values, rows, errors| {
        let (law, stretch, slack) = ("yeoh", [1.01, 2.5], SlackChoice::No);
        Scenario { name, law, values, rows, stretch, errors, slack }
    };
    let most = 0.05 + 3.0 * (0.05 * 0.95 / DRAWS as f64).sqrt();
    for s in [
        of("independent, 150 rows", TWO_TERMS, 150, Errors::Independent(1.1e3)),
        of("independent, 20 rows", TWO_TERMS, 20, Errors::Independent(1.1e3)),
        of("AR(1) 0.9, 150 rows", TWO_TERMS, 150, Errors::Correlated(0.9, 1.1e3)),
    ] {
        let alarms = (0..DRAWS).into_par_iter().filter(|seed| s.depends_on_range("yeoh", *seed)).count();
        println!("{}: {alarms} of {DRAWS}", s.name);
        assert!(alarms as f64 <= most * DRAWS as f64, "{}: {alarms} of {DRAWS}", s.name);
    }
    let s = of("Neo-Hookean law of Yeoh's data", &[60e3, 6e3], 150, Errors::Independent(1.1e3));
    let seen = (0..DRAWS).into_par_iter().filter(|seed| s.depends_on_range("neo_hookean", *seed)).count();
    println!("{}: {seen} of {DRAWS}", s.name);
    assert!(10 * seen as u64 >= 8 * DRAWS, "{}: {seen} of {DRAWS}", s.name);
}
