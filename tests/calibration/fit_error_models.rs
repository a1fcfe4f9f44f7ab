//! Coverage of the 95 % intervals where the errors grow with the stress, where they differ between modes, where weights follow from the data, where modes lie in files of their own, and where specimens
//! end at different stretches; and what is said of each.
//!
//! Of 200 draws with probability 0.95 the standard deviation is 1.54 %: accepted are 95 − 3 % and two of them, 88.9 % or more, also of 100. Half-widths are compared with the scatter of the constants between the
//! draws, so that an interval which covers by its width alone fails, and one that is a fifth too narrow does ([`Coverage`]).

use crate::common::Random;
use crate::common::coverage::{Coverage, draws};
use crate::common::made::table;
use durometer::calibrate::{
    ColumnChoice, ErrorModel, Experiment, FitOptions, FitResult, FitWarning, FittableLaw, Loss, Mode, Preparation,
    Sample, SlackChoice, Weighting, fit_experiment,
};
use rayon::prelude::*;

/// Draws of a line, unless the environment asks for others
const DRAWS: u64 = 100;
/// 95 − 3 − 2·1.54 %
const LEAST: f64 = 88.9;
/// Median half-width over the scatter: two standard deviations of that of 100 draws, 14 %, below 1.96
const NARROWEST: f64 = 1.66;

/// A curve: mode, largest stretch, rows, file.
type Curve = (Mode, f64, usize, usize);

/// Errors of a drawn test.
#[derive(Clone, Copy, Default)]
struct Noise {
    /// Standard deviation of every stress \[Pa\]
    size: f64,
    /// The same over the stress \[–\]
    relative: f64,
    /// Of the level of each file \[–\]
    level: f64,
    /// Part of the data points that are multiplied by a factor
    outliers: (f64, f64),
    /// Correlation of neighbours
    rho: f64,
    /// Errors of each reading alone in addition, over those
    white: f64,
    /// Factors of the standard deviation of each curve; none: one size
    curves: &'static [f64],
}

struct Case {
    law: &'static str,
    values: &'static [f64],
    curves: Vec<Curve>,
    noise: Noise,
    weighting: Weighting,
    loss: Loss,
}

impl Case {
    fn new(law: &'static str, values: &'static [f64], curves: Vec<Curve>, noise: Noise) -> Self {
        Self { law, values, curves, noise, weighting: Weighting::Absolute, loss: Loss::Squares }
    }

    fn model(&self) -> FittableLaw {
        let terms = if ["neo_hookean", "gent"].contains(&self.law) { 1 } else { self.values.len() };
        FittableLaw::new(self.law, Some(terms)).expect("registered")
    }

    fn samples(&self, seed: u64) -> Vec<Sample> {
        let mut random = Random::seed(1 + 7919 * seed);
        (0..40).for_each(|_| {
            random.unit();
        });
        let files = 1 + self.curves.iter().map(|c| c.3).max().expect("a curve");
        let levels: Vec<f64> = (0..files).map(|_| 1.0 + self.noise.level * random.normal()).collect();
        let mut samples = vec![];
        for (place, (mode, end, rows, specimen)) in self.curves.iter().enumerate() {
            let own = self.noise.curves.get(place).copied().unwrap_or(1.0);
            let mut before = random.normal();
            for k in 0..*rows {
                let stretch = 1.02 + (end - 1.02) * k as f64 / (rows - 1) as f64;
                let law = levels[*specimen] * self.model().stress(self.values, *mode, stretch);
                let rho = self.noise.rho;
                before = rho * before + (1.0 - rho * rho).sqrt() * random.normal();
                let alone = if self.noise.white > 0.0 { self.noise.white * random.normal() } else { 0.0 };
                let error = own * (self.noise.size + self.noise.relative * law.abs()) * (before + alone);
                let (part, factor) = self.noise.outliers;
                let stress = (law + error) * if random.unit() < part { factor } else { 1.0 };
                let line = samples.len() as u64 + 2;
                samples.push(Sample { mode: *mode, stretch, stress, line, specimen: *specimen, second: 1.0 });
            }
        }
        samples
    }

    fn fit(&self, samples: Vec<Sample>) -> FitResult {
        let files = 1 + samples.iter().map(|s| s.specimen).max().expect("a row");
        let mut e = table(samples);
        e.specimens = (0..files).map(|k| format!("{k}.csv")).collect();
        let mut o = FitOptions::new(self.law);
        (o.terms, o.ranges) = (Some(self.model().terms), 0);
        o.modes = Mode::ALL.into_iter().filter(|m| self.curves.iter().any(|c| c.0 == *m)).collect();
        (o.weighting, o.loss) = (self.weighting, self.loss);
        fit_experiment(&e, &o).unwrap_or_else(|e| panic!("{}: {e}", self.law))
    }

    /// Prints and returns what the draws gave.
    fn study(&self, name: &str) -> Counts {
        self.study_of(draws(DRAWS), name)
    }

    fn study_of(&self, count: u64, name: &str) -> Counts {
        let all: Vec<FitResult> = (0..count).into_par_iter().map(|seed| self.fit(self.samples(seed))).collect();
        let n = all.len() as f64;
        let percent = |is: &dyn Fn(&FitResult) -> bool| 100.0 * all.iter().filter(|r| is(r)).count() as f64 / n;
        let of = |k: usize| {
            let found: Vec<_> = all.iter().map(|r| (r.parameters[k].value, r.parameters[k].interval)).collect();
            Coverage::of(self.values[k], &found)
        };
        let counts = Counts {
            constants: (0..self.values.len()).map(of).collect(),
            correlated: percent(&|r| matches!(r.errors, ErrorModel::Correlated { .. })),
            unequal: percent(&|r| matches!(r.errors, ErrorModel::Unequal { .. } | ErrorModel::UnequalCurves { .. })),
            hint: percent(&|r| r.warnings.contains(&FitWarning::Unequal)),
            apart: percent(&|r| r.warnings.iter().any(|w| matches!(w, FitWarning::UnequalCurves { .. }))),
            pattern: percent(&|r| r.warnings.iter().any(|w| matches!(w, FitWarning::Systematic { .. }))),
        };
        println!("{name}: {counts:?}");
        counts
    }
}

/// Whether a constant is covered by intervals of a width that its scatter asks for.
fn is_held(c: &Coverage, widest: f64) -> bool {
    c.covered >= LEAST && (NARROWEST..=widest).contains(&c.wide)
}

/// Percentages of the draws.
#[derive(Debug)]
struct Counts {
    constants: Vec<Coverage>,
    correlated: f64,
    unequal: f64,
    hint: f64,
    apart: f64,
    pattern: f64,
}

impl Counts {
    fn hold(&self, widest: f64) {
        // 5 % and two standard deviations of 200 draws
        assert!(self.pattern <= 8.1, "{self:?}");
        for c in &self.constants {
            assert!(is_held(c, widest), "{self:?}");
        }
    }
}

const YEOH: &[f64] = &[2e4, 500.0];
const MOONEY: &[f64] = &[2e4, 5e3];

fn one(end: f64, rows: usize) -> Vec<Curve> {
    vec![(Mode::Uniaxial, end, rows, 0)]
}

/// Relative weights follow from the law: those of the measured stresses made μ 0.5 % too small (89 % covered), and their roughness counted as correlation (300 rows: ±30 % instead of
/// ±0.5 %).
#[test]
fn relative_weights_are_unbiased() {
    let noise = Noise { relative: 0.05, ..Noise::default() };
    for (law, values, rows) in [("neo_hookean", &[3e4][..], 40), ("neo_hookean", &[3e4], 300), ("yeoh", YEOH, 40)] {
        let case = Case { weighting: Weighting::Relative, ..Case::new(law, values, one(4.0, rows), noise) };
        let found = case.study(&format!("relative weights, {law}, {rows} rows"));
        found.hold(2.3);
        // Two to four standard deviations of the mean of 100 draws, and 15 % of correlated ones where 10 are expected
        assert!(found.constants[0].bias.abs() < 0.3 && found.correlated < 15.0 && found.hint == 0.0, "{found:?}");
    }
}

/// Huber's loss with outliers: the covariance is the asymptotic one. Its weights as those of the rows made 60 of 60 draws correlated and C20 uncertain by 274 % instead of 4 %.
#[test]
fn the_loss_of_huber_has_its_own_covariance() {
    for (name, outliers) in [("none", (0.0, 1.0)), ("5 % times 1.5", (0.05, 1.5)), ("1.25 % times 3", (0.0125, 3.0))] {
        let noise = Noise { size: 500.0, outliers, ..Noise::default() };
        let case = Case { loss: Loss::Huber, ..Case::new("yeoh", YEOH, one(2.5, 80), noise) };
        let found = case.study(&format!("huber, outliers: {name}"));
        found.hold(2.5);
        assert!(found.correlated < 16.0, "{found:?}");
    }
    // A tenth of the data points three times too large: the bias of C10 is the one of the loss, not of its interval
    let noise = Noise { size: 500.0, outliers: (0.1, 3.0), ..Noise::default() };
    let found = Case { loss: Loss::Huber, ..Case::new("yeoh", YEOH, one(2.5, 80), noise) }.study("huber, 10 % times 3");
    assert!(
        found.correlated < 16.0 && found.constants.iter().all(|c| (1.5..2.5).contains(&c.wide) && c.covered > 80.0),
        "{found:?}"
    );
}

/// Errors in proportion to the stress with equal weights: s²(JᵀJ)⁻¹ covered 79 % (C20) and 83 % (J_m). Errors of one size are called unequal in 5 % of the draws.
#[test]
fn errors_that_grow_with_the_stress_are_seen() {
    let grown = Noise { relative: 0.05, ..Noise::default() };
    let cases = [
        ("neo_hookean", &[3e4][..], 4.0, 40, 0.05),
        ("yeoh", YEOH, 4.0, 40, 0.05),
        ("yeoh", YEOH, 4.0, 60, 0.05),
        ("gent", &[3e4, 30.0], 4.5, 60, 0.03),
    ];
    for (law, values, end, rows, relative) in cases {
        let noise = Noise { relative, ..grown };
        let found = Case::new(law, values, one(end, rows), noise).study(&format!("grown errors, {law}, {rows} rows"));
        found.hold(2.8);
        assert!(found.unequal + found.correlated > 80.0 && found.hint > 65.0, "{found:?}");
    }
    let even = Noise { size: 1e3, ..Noise::default() };
    let found = Case::new("yeoh", YEOH, one(4.0, 40), even).study("errors of one size, yeoh");
    found.hold(2.3);
    // 5 % and two standard deviations of 200 draws
    assert!(found.unequal <= 8.1 && found.hint <= 6.0, "{found:?}");
}

/// Modes whose errors differ in size, with equal weights: s²(JᵀJ)⁻¹ covered 77 % (C01, 20:1), 79 % (5:1) and 87 % (three modes), and called 24 % of the independent errors correlated; of
/// correlated ones 71 %. A mode of 15 data points decides some intervals, which have as few degrees of freedom: their half-widths are above two standard deviations.
#[test]
fn modes_with_errors_of_their_own_size_cover() {
    const MOONEY: &[f64] = &[15e3, 5e3];
    let pair = || vec![(Mode::Uniaxial, 3.0, 60, 0), (Mode::Equibiaxial, 1.4, 15, 0)];
    let three = || vec![(Mode::Uniaxial, 2.5, 25, 0), (Mode::Equibiaxial, 1.8, 25, 0), (Mode::Planar, 2.2, 25, 0)];
    let sized = |size: f64, curves: &'static [f64]| Noise { size, curves, ..Noise::default() };
    let cases = [
        ("20:1", pair(), sized(100.0, &[1.0, 20.0])),
        ("5:1", pair(), sized(400.0, &[1.0, 5.0])),
        ("1:5", pair(), sized(400.0, &[5.0, 1.0])),
        ("2:20:5", three(), sized(100.0, &[2.0, 20.0, 5.0])),
        ("5:1, correlated", pair(), Noise { rho: 0.6, ..sized(400.0, &[1.0, 5.0]) }),
    ];
    for (name, curves, noise) in cases {
        let case = Case::new("mooney_rivlin", MOONEY, curves, noise);
        let found = case.study(&format!("errors of modes, {name}"));
        found.hold(2.5);
        assert!(found.apart >= 80.0 && (noise.rho > 0.0 || found.correlated <= 15.0), "{found:?}");
        let r = case.fit(case.samples(1));
        assert!(r.to_string().contains("--weight noise divides each mode by its noise"), "{r}");
        let weighted =
            Case { weighting: Weighting::Noise, ..case }.study(&format!("errors of modes by their noise, {name}"));
        let covers = noise.rho > 0.0 || weighted.constants.iter().all(|c| is_held(c, 2.4));
        assert!(covers && weighted.apart == 0.0, "{weighted:?}");
    }
    // 5 % and two standard deviations of 200 draws
    let even = Case::new("mooney_rivlin", MOONEY, pair(), sized(1e3, &[])).study("errors of modes, 1:1");
    even.hold(2.4);
    assert!(even.apart <= 8.1, "{even:?}");
}

/// Correlated errors in proportion to the stress, with equal weights: with errors of one size C01 of three modes was covered in 79 %, with a correlation of 0.9 in 75 %, and μ of one mode in 92 %.
/// Errors of one size are seldom called growing: in one of 200 draws, of 60 at most six are accepted.
#[test]
fn correlated_errors_that_grow_with_the_stress_cover() {
    let ends = [(Mode::Uniaxial, 2.5), (Mode::Equibiaxial, 1.8), (Mode::Planar, 2.2)];
    let three = || ends.map(|(mode, end)| (mode, end, 40, 0)).to_vec();
    let grows = |r: &FitResult| matches!(r.errors, ErrorModel::Correlated { grow: true, .. });
    for (name, law, values, curves, rho) in [
        ("three modes, 0.6", "mooney_rivlin", MOONEY, three(), 0.6),
        ("three modes, 0.9", "mooney_rivlin", MOONEY, three(), 0.9),
        ("one mode, 0.6", "neo_hookean", &[3e4][..], one(3.0, 60), 0.6),
    ] {
        let case = Case::new(law, values, curves, Noise { relative: 0.05, rho, ..Noise::default() });
        let found = case.study(&format!("grown and correlated errors, {name}"));
        found.hold(2.8);
        // A pattern is said instead of the hint
        assert!(found.correlated > 90.0 && found.hint + found.pattern > 80.0, "{found:?}");
        assert!(grows(&case.fit(case.samples(1))));
    }
    let even = Case::new("mooney_rivlin", MOONEY, three(), Noise { size: 1e3, rho: 0.6, ..Noise::default() });
    let called = (0..60).into_par_iter().filter(|seed| grows(&even.fit(even.samples(*seed)))).count();
    println!("errors of one size called growing: {called} of 60");
    assert!(called <= 6, "{called} of 60");
}

/// A drift of the load cell under the noise of each reading: as errors of one correlation the intervals of the last two covered 55 and 35 %. The long drift leaves three independent data points, of
/// which the intervals may cover as few as 80 % in 100 draws.
#[test]
fn a_drift_under_the_noise_of_each_reading_is_seen() {
    for (rho, white, least, narrowest) in [(0.9, 0.5, LEAST, NARROWEST), (0.98, 0.3, 80.0, 1.4), (0.98, 1.0, 78.0, 1.2)]
    {
        let case = Case::new("neo_hookean", &[5e4], one(2.0, 300), Noise { size: 1e3, rho, white, ..Noise::default() });
        let found = case.study(&format!("a drift of {rho} and noise of {white}"));
        let constant = &found.constants[0];
        assert!(constant.covered >= least && (narrowest..3.2).contains(&constant.wide), "{rho} {white}: {found:?}");
        assert!(found.correlated >= 95.0, "{found:?}");
    }
}

/// Of the rows of a machine that waits at rest, with the noise of its load cell, the last one counts.
#[test]
fn of_rows_of_a_machine_that_waits_one_is_a_data_point() {
    let case = Case::new("neo_hookean", &[5e4], one(2.0, 60), Noise { size: 500.0, ..Noise::default() });
    let mut random = Random::seed(9);
    let mut read = |waits: u32| {
        let mut text = "stretch,nominal stress (Pa)\n".to_string();
        for k in 0..waits {
            let stress = if k + 1 < waits { 500.0 * random.normal() } else { 100.0 };
            text += &format!("1,{stress}\n");
        }
        case.samples(2).iter().for_each(|s| text += &format!("{},{}\n", s.stretch, s.stress));
        let e = Experiment::parse("a.csv", text.as_bytes(), None, &ColumnChoice::default(), Some(Mode::Uniaxial));
        let e = e.and_then(|e| e.prepare(&Preparation::default())).unwrap_or_else(|e| panic!("{e}"));
        let mut o = FitOptions::new("neo_hookean");
        (o.slack, o.ranges) = (SlackChoice::No, 0);
        fit_experiment(&e, &o).unwrap_or_else(|e| panic!("{e}"))
    };
    let (waited, alone) = (read(300), read(1));
    assert_eq!((&alone.parameters, alone.errors, alone.rows), (&waited.parameters, waited.errors, 61));
}

fn modes(rows: usize, repeats: &[usize; 3]) -> Vec<Curve> {
    let ends = [(Mode::Uniaxial, 2.0), (Mode::Equibiaxial, 1.6), (Mode::Planar, 2.0)];
    let all = ends.into_iter().zip(repeats).flat_map(|((m, end), k)| (0..*k).map(move |_| (m, end)));
    all.enumerate().map(|(file, (m, end))| (m, end, rows, file)).collect()
}

/// Three modes in three files are one specimen, to the last digit, and a warning says that nothing is known of the scatter between specimens.
#[test]
fn a_file_for_each_mode_is_no_repeat() {
    let noise = Noise { size: 500.0, ..Noise::default() };
    let case = Case::new("mooney_rivlin", MOONEY, modes(20, &[1, 1, 1]), noise);
    let rows = case.samples(3);
    let joined = case.fit(rows.iter().map(|s| Sample { specimen: 0, ..*s }).collect());
    let apart = case.fit(rows);
    assert_eq!((&apart.parameters, apart.errors), (&joined.parameters, joined.errors));
    let named = |r: &FitResult| r.warnings.iter().any(|w| matches!(w, FitWarning::NoRepeat { .. }));
    assert!(named(&apart) && !named(&joined) && apart.scatter.is_none(), "{apart}");
    assert!(apart.to_string().contains("not the scatter between specimens"), "{apart}");
    case.study("a file for each mode, noise alone").hold(2.4);
}

/// A file in tension and one in compression are one specimen, to the last digit: no repeat, and no scatter between specimens. Three in tension and one in compression are three of one test, and one of another.
#[test]
fn tension_and_compression_are_two_tests() {
    let noise = Noise { size: 500.0, ..Noise::default() };
    let of = |ends: &[f64]| ends.iter().enumerate().map(|(file, end)| (Mode::Uniaxial, *end, 20, file)).collect();
    let case = Case::new("mooney_rivlin", MOONEY, of(&[2.0, 0.6]), noise);
    // Without the first data point of the compression, at a stretch of 1.02
    let rows: Vec<Sample> = case.samples(3).into_iter().filter(|s| s.specimen == 0 || s.stretch < 1.0).collect();
    let joined = case.fit(rows.iter().map(|s| Sample { specimen: 0, ..*s }).collect());
    let apart = case.fit(rows);
    assert_eq!((&apart.parameters, apart.errors), (&joined.parameters, joined.errors));
    assert!(apart.scatter.is_none() && !matches!(apart.errors, ErrorModel::Specimens { .. }), "{apart}");
    assert!(apart.to_string().contains("each test was made on one specimen"), "{apart}");
    let several = Case::new("mooney_rivlin", MOONEY, of(&[2.0, 2.0, 2.0, 0.6]), noise);
    let r = several.fit(several.samples(3));
    assert!(matches!(r.errors, ErrorModel::Levels { specimens: 4, repeats: 2 }), "{r}");
    let words = "uniaxial in compression was tested on one specimen: its level is taken to scatter as that of the specimens in uniaxial in tension";
    assert!(r.to_string().contains(words), "{r}");
}

/// Two specimens in each mode, with and without scatter: all of them as six specimens with five degrees of freedom covered 87 and 89 % of C01.
#[test]
fn two_specimens_in_each_mode_are_repeats() {
    for level in [0.0, 0.05] {
        let noise = Noise { size: 500.0, level, ..Noise::default() };
        let case = Case::new("mooney_rivlin", MOONEY, modes(20, &[2, 2, 2]), noise);
        // Two degrees of freedom for C01
        case.study(&format!("two files for each mode, level {level}")).hold(5.0);
    }
}

/// Four uniaxial specimens and one in each other mode: the level of those scatters as that of the four.
#[test]
fn the_scatter_of_one_mode_is_taken_for_the_others() {
    for level in [0.0, 0.05] {
        let noise = Noise { size: 500.0, level, ..Noise::default() };
        let case = Case::new("mooney_rivlin", MOONEY, modes(20, &[4, 1, 1]), noise);
        let found = case.study(&format!("4, 1 and 1 files, level {level}"));
        found.hold(4.0);
        let r = case.fit(case.samples(1));
        assert_eq!(r.errors, ErrorModel::Levels { specimens: 6, repeats: 3 });
        assert!(r.to_string().contains("equibiaxial, planar was tested on one specimen"), "{r}");
    }
}

/// Five specimens that end at different stretches, 5 % scatter of their level: C10 was covered in 87 %.
#[test]
fn specimens_with_different_ends_cover() {
    let noise = Noise { size: 500.0, level: 0.05, ..Noise::default() };
    let ends = |all: &[f64]| all.iter().enumerate().map(|(k, end)| (Mode::Uniaxial, *end, 20, k)).collect();
    Case::new("yeoh", &[2e4, -500.0, 50.0], ends(&[1.8, 2.0, 2.4, 2.8, 3.2]), noise).study("five ends, yeoh").hold(4.5);
    // Known to 5 %
    Case::new("yeoh", &[2e4, -500.0, 50.0], ends(&[3.0; 5]), noise).study_of(200, "one end, yeoh").hold(3.2);
}

/// Means of two rows each, as tables with more than 2 000 rows become them, of errors with the correlation 0.98: they are no AR(1) series, and the true law was said to have a pattern
/// in 30 of 30 tests. Accepted are 5 % and two standard deviations.
#[test]
fn means_of_rows_have_no_pattern() {
    let noise = Noise { size: 2e3, rho: 0.98, ..Noise::default() };
    let case = Case::new("neo_hookean", &[1e5], one(2.0, 4000), noise);
    let is_named = |seed: &u64| {
        let rows = case.samples(*seed);
        let mean = |pair: &[Sample]| Sample {
            stretch: 0.5 * (pair[0].stretch + pair[1].stretch),
            stress: 0.5 * (pair[0].stress + pair[1].stress),
            ..pair[0]
        };
        let r = case.fit(rows.chunks(2).map(mean).collect());
        r.warnings.iter().any(|w| matches!(w, FitWarning::Systematic { .. }))
    };
    let named = (0..60).into_par_iter().filter(is_named).count();
    println!("patterns of means: {named} of 60");
    assert!(named <= 6, "{named} of 60");
}

/// Data points that are 1.3 times too large in 5 of 100: named in all draws that have one, 98 % of them; errors that grow with the stress are no outliers.
#[test]
fn moderate_outliers_are_named() {
    let count = |noise: Noise| {
        let case = Case::new("yeoh", YEOH, one(2.5, 80), noise);
        let is_named = |seed: &u64| {
            let r = case.fit(case.samples(*seed));
            r.warnings.iter().any(|w| matches!(w, FitWarning::Outliers { .. }))
        };
        (0..100).into_par_iter().filter(is_named).count()
    };
    let with = count(Noise { size: 500.0, outliers: (0.05, 1.3), ..Noise::default() });
    let [even, grown] =
        [(2e3, 0.0), (0.0, 0.05)].map(|(size, relative)| count(Noise { size, relative, ..Noise::default() }));
    println!("outliers named: {with} of 100; without any {even}, {grown}");
    // 1 % and one standard deviation of 100 draws
    assert!(with >= 90 && even <= 2 && grown <= 2, "{with} {even} {grown}");
}
