//! How often f* ± U(f*) of one family of meshes, and of the reference from several, contains the limit, over sequences whose limit is known.

use durometer::math::random::SplitMix;
use durometer::math::statistics::{half_width_of_one, median};
use durometer::study::estimate::family::{Estimate, Level, estimate};
use durometer::study::estimate::method::Method;
use durometer::study::estimate::reference::choose;
use durometer::study::estimate::richardson::{Convergence, Triple};
use durometer::study::store::record::Role;

/// Draws for a line of the published table.
const PUBLISHED: usize = 10_000;
/// Draws for a line in every check, the same each time: a share of 96 % has a standard deviation of 0.3 % there, and of 0.8 % where 15 % are defensible.
const FEWER: usize = 4_000;

/// Draws of the tests.
trait Draws {
    fn random(&mut self) -> &mut SplitMix;

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.random().unit()
    }

    /// Half width of the 95 % interval of one normal draw by this many.
    fn half_width(&mut self, count: usize) -> f64 {
        let draws: Vec<f64> = (0..count).map(|_| self.random().normal()).collect();
        half_width_of_one(&draws)
    }
}

/// Random sequences of one family: f(h) = 1 + a (h/h₁)^p + b (h/h₁)^{p + 1} with noise of the mesher, on meshes that are not similar.
struct Sequences {
    random: SplitMix,
    /// Least and largest number of meshes
    meshes: [usize; 2],
    /// Standard deviation of the noise, as a share of the limit
    noise: f64,
    /// Largest share by which the mean edge grows beyond h on the coarsest mesh
    dissimilarity: f64,
}

impl Draws for Sequences {
    fn random(&mut self) -> &mut SplitMix {
        &mut self.random
    }
}

impl Sequences {
    fn draw(&mut self, seeds: usize) -> Option<Estimate> {
        let formulation = if self.random.unit() < 0.5 { "tet4" } else { "tet10" };
        let formal = if formulation == "tet4" { 2.0 } else { 4.0 };
        let p = self.between(1.0, formal);
        let [least, most] = self.meshes;
        let meshes = least + (((most - least) as f64 + 0.99) * self.random.unit()) as usize;
        let (a, b) = (self.between(0.002, 0.05), self.between(-0.5, 0.5));
        let sign = if self.random.unit() < 0.5 { -1.0 } else { 1.0 };
        let mix = self.random.unit();
        let (mut h, mut levels) = (1.0, Vec::new());
        let grows = self.between(0.0, self.dissimilarity);
        for k in 0..meshes {
            let edge = h * (1.0 + grows * k as f64 / (meshes - 1) as f64);
            // The size that rules the error is neither of the two.
            let size = h + mix * (edge - h);
            let exact = 1.0 + sign * a * (size.powf(p) + b * size.powf(p + 1.0));
            let f = exact + self.noise * self.random.normal();
            levels.push(Level { id: k.to_string(), h, edge: Some(edge), f, ..Level::default() });
            h *= self.between(1.25, 2.0);
        }
        let scatter = (seeds > 1).then(|| self.noise * self.half_width(seeds));
        estimate(("family", Role::Sizes, formulation), levels, scatter, 0.05)
    }

    /// Shares of the limits inside f* ± U(f*), of the defensible estimates and of all, and of the estimates that are defensible.
    fn coverage(&mut self, seeds: usize, draws: usize) -> [f64; 3] {
        let all: Vec<Estimate> = (0..draws).filter_map(|_| self.draw(seeds)).collect();
        let holds = |e: &&Estimate| (e.extrapolated - 1.0).abs() <= e.uncertainty;
        let share = |part: &[&Estimate]| part.iter().filter(|e| holds(e)).count() as f64 / part.len() as f64;
        let defensible: Vec<&Estimate> = all.iter().filter(|e| e.defensible).collect();
        [share(&defensible), share(&all.iter().collect::<Vec<_>>()), defensible.len() as f64 / all.len() as f64]
    }
}

#[test]
#[ignore = "a minute; its numbers are in docs/verification.md"]
fn the_published_shares() {
    limits_are_inside(PUBLISHED);
    references_hold(PUBLISHED);
}

#[test]
fn ninety_five_of_a_hundred_limits_are_inside() {
    limits_are_inside(FEWER);
}

#[test]
fn ninety_five_of_a_hundred_references_hold() {
    references_hold(FEWER);
}

/// The statement of the reports: 95 % of the limits are inside, also where few seeds tell the noise of the mesher.
fn limits_are_inside(draws: usize) {
    let cases = [
        ("clean", 0.0, 0.0, 3),
        ("dissimilar meshes", 0.0, 0.6, 3),
        ("noise of 0.1 %", 1e-3, 0.0, 3),
        ("both", 1e-3, 0.6, 3),
        ("noise of 0.1 %", 1e-3, 0.0, 2),
        ("noise of 0.5 %", 5e-3, 0.0, 2),
        ("noise of 0.5 %", 5e-3, 0.0, 3),
        ("noise of 0.5 %", 5e-3, 0.0, 5),
    ];
    for (k, (name, noise, dissimilarity, seeds)) in cases.into_iter().enumerate() {
        let mut sequences = Sequences { random: SplitMix(7 + k as u64), meshes: [3, 5], noise, dissimilarity };
        let [defensible, all, share] = sequences.coverage(seeds, draws).map(|share| 100.0 * share);
        println!(
            "{name}, {seeds} seeds: {defensible:.1} % of the defensible, which are {share:.0} %, {all:.1} % of all"
        );
        assert!(defensible >= 95.0 && all >= 95.0, "{name}, {seeds} seeds: {defensible} {all}");
    }
}

/// Two meshes contain the limit as often as more of them do, and no pair is defensible: of those with an uncertainty within the tolerance fewer do.
#[test]
fn ninety_five_of_a_hundred_limits_of_two_meshes_are_inside() {
    for (noise, seeds) in [(0.0, 0), (1e-3, 3)] {
        let mut pairs = Sequences { random: SplitMix(5), meshes: [2, 2], noise, dissimilarity: 0.0 };
        let all: Vec<Estimate> = (0..PUBLISHED).filter_map(|_| pairs.draw(seeds)).collect();
        let share = |part: &[&Estimate]| {
            let holds = part.iter().filter(|e| (e.extrapolated - 1.0).abs() <= e.uncertainty);
            holds.count() as f64 / part.len() as f64
        };
        let precise: Vec<&Estimate> = all.iter().filter(|e| e.uncertainty <= 0.05 * e.extrapolated).collect();
        let [of_all, of_precise] = [share(&all.iter().collect::<Vec<_>>()), share(&precise)];
        println!(
            "two meshes, noise {noise}: {of_all:.3} of all, {of_precise:.3} of {} within the tolerance",
            precise.len()
        );
        assert!(of_all >= 0.95 && of_precise < 0.95, "noise {noise}: {of_all} {of_precise}");
        assert!(all.iter().all(|e| !e.defensible && !e.refused));
    }
}

/// Four families of meshes of one body, each f(h) = 1 + a (h/h₁)^p + b (h/h₁)^{p + 1} with an order and amplitudes of its own. One of them
/// may be pre-asymptotic: a part d of the solution is resolved by meshes far finer than its own, 1 + d/(1 + (h_c/h)²) with h_c of a tenth to a
/// half of its finest h, so that it converges to a wrong limit.
struct Bodies {
    random: SplitMix,
    /// Standard deviation of the noise of meshes that are not nested, as a share of the limit
    noise: f64,
    /// Share of the bodies with a pre-asymptotic family
    wrong: f64,
}

impl Draws for Bodies {
    fn random(&mut self) -> &mut SplitMix {
        &mut self.random
    }
}

/// One family of [`Bodies`].
struct Members {
    name: &'static str,
    role: Role,
    formulation: &'static str,
    meshes: usize,
    /// Least and largest error of the coarsest mesh
    amplitude: [f64; 2],
    /// The part d that it does not resolve
    unresolved: f64,
}

impl Bodies {
    fn family(&mut self, m: &Members) -> Option<Estimate> {
        let formal = if m.formulation == "tet4" { 2.0 } else { 4.0 };
        let (p, a, b) =
            (self.between(1.0, formal), self.between(m.amplitude[0], m.amplitude[1]), self.between(-0.5, 0.5));
        let sign = if self.random.unit() < 0.5 { -1.0 } else { 1.0 };
        let nested = m.role == Role::Nested;
        let noise = if nested { 0.0 } else { self.noise };
        let mut sizes = vec![1.0];
        for _ in 1..m.meshes {
            let ratio = if nested { 2.0 } else { self.between(1.25, 1.6) };
            sizes.push(sizes[sizes.len() - 1] / ratio);
        }
        let hidden = sizes[m.meshes - 1] * self.between(0.1, 0.5);
        let mut level = |h: &f64| {
            let unresolved = m.unresolved / (1.0 + (hidden / h).powi(2));
            let f = 1.0 + unresolved + sign * a * (h.powf(p) + b * h.powf(p + 1.0)) + noise * self.random.normal();
            Level { id: h.to_string(), h: *h, f, ..Level::default() }
        };
        let levels = sizes.iter().map(&mut level).collect();
        let scatter = (!nested).then(|| noise * self.half_width(3));
        estimate((m.name, m.role, m.formulation), levels, scatter, 0.05)
    }

    fn draw(&mut self) -> Vec<Estimate> {
        let wrong = (self.random.unit() < self.wrong).then(|| (4.0 * self.random.unit()) as usize);
        let sign = if self.random.unit() < 0.5 { -1.0 } else { 1.0 };
        let part = sign * self.between(0.005, 0.08);
        let three_or_four = |random: &mut SplitMix| 3 + (1.99 * random.unit()) as usize;
        let meshes = [4, 3, three_or_four(&mut self.random), three_or_four(&mut self.random)];
        let all = [
            ("sizes", Role::Sizes, "tet4", [0.02, 0.3]),
            ("nested", Role::Nested, "tet4", [0.02, 0.3]),
            ("tet10", Role::Element, "tet10", [0.005, 0.1]),
            ("tet10_up", Role::Element, "tet10_up", [0.002, 0.05]),
        ];
        let members = all.iter().zip(meshes).enumerate().map(|(k, ((name, role, formulation, amplitude), meshes))| {
            let unresolved = if wrong == Some(k) { part } else { 0.0 };
            Members { name, role: *role, formulation, meshes, amplitude: *amplitude, unresolved }
        });
        members.collect::<Vec<_>>().iter().filter_map(|m| self.family(m)).collect()
    }
}

/// The reference holds as often as a family is said to, also where one of four families converges to a wrong limit, and three of four
/// are within the tolerance still. The smallest claimed uncertainty alone is printed for comparison.
fn references_hold(draws: usize) {
    for (noise, wrong) in [(0.0, 0.0), (0.0, 0.5), (1e-3, 0.0), (1e-3, 0.5), (1e-3, 1.0)] {
        let mut bodies = Bodies { random: SplitMix(11), noise, wrong };
        let (mut held, mut claimed, mut count, mut useful) = (0, 0, 0, 0);
        let mut widths = vec![];
        for _ in 0..draws {
            let estimates = bodies.draw();
            let reference = choose(&estimates, 0.05).expect("four families");
            if reference.envelope.is_empty() {
                continue;
            }
            count += 1;
            let error = (reference.value - 1.0).abs();
            held += usize::from(error <= reference.uncertainty);
            useful += usize::from(reference.is_within(0.05.into()));
            widths.push((reference.uncertainty, reference.uncertainty / error));
            let defensible = estimates.iter().filter(|e| e.defensible);
            let boldest = defensible.min_by(|a, b| a.uncertainty.total_cmp(&b.uncertainty)).expect("one is");
            claimed += usize::from((boldest.extrapolated - 1.0).abs() <= boldest.uncertainty);
        }
        let share = |n: usize| n as f64 / count as f64;
        let mut median = |of: fn(&(f64, f64)) -> f64| {
            widths.sort_by(|a, b| of(a).total_cmp(&of(b)));
            of(&widths[count / 2])
        };
        println!(
            "noise {noise}, {:.0} % with a wrong family: {:.1} % of {count} references hold (smallest claim {:.1} %), median U {:.2} %, \
             U/error {:.1}, within the tolerance {:.1} %",
            100.0 * wrong,
            100.0 * share(held),
            100.0 * share(claimed),
            100.0 * median(|w| w.0),
            median(|w| w.1),
            100.0 * share(useful)
        );
        assert!(share(held) >= 0.95, "noise {noise}, wrong {wrong}: {}", share(held));
        assert!(share(useful) >= 0.75, "noise {noise}, wrong {wrong}: {}", share(useful));
    }
}

/// A family of this many meshes whose values oscillate by noise, or by two powers of h of opposite sign that make an extremum near the finest ones.
struct Oscillations {
    random: SplitMix,
    meshes: usize,
    by_noise: bool,
    tolerance: f64,
}

impl Draws for Oscillations {
    fn random(&mut self) -> &mut SplitMix {
        &mut self.random
    }
}

impl Oscillations {
    /// An estimate where the three finest meshes oscillate.
    fn draw(&mut self) -> Option<Estimate> {
        let formulation = if self.random.unit() < 0.5 { "tet4" } else { "tet10" };
        let formal = if formulation == "tet4" { 2.0 } else { 4.0 };
        let (p, a) = (self.between(1.0, formal), self.between(0.002, 0.05));
        let (more, b) = (self.between(0.5, 2.0), -a * 10f64.powf(self.between(-1.5, 0.2)));
        let noise = if self.by_noise { 10f64.powf(self.between(-3.3, -1.5)) } else { 0.0 };
        let (mut h, mut levels) = (1.0_f64, Vec::new());
        for k in 0..self.meshes {
            let exact = if self.by_noise { 0.1 * a * h.powf(p) } else { a * h.powf(p) + b * h.powf(p + more) };
            levels.push(Level {
                id: k.to_string(),
                h,
                f: 1.0 + exact + noise * self.random.normal(),
                ..Level::default()
            });
            h *= self.between(1.2, 2.0);
        }
        let finest = |of: fn(&Level) -> f64| [0, 1, 2].map(|k| of(&levels[k]));
        if Triple::new(finest(|l| l.h), finest(|l| l.f)).class != Convergence::Oscillatory {
            return None;
        }
        estimate(("family", Role::Sizes, formulation), levels, None, self.tolerance)
    }
}

/// Also with the difference of coarse meshes counted by their size, as many limits of oscillating families are inside as the reports say. Where noise makes them oscillate U is 7 to 14 times
/// the error in the median; near an extremum the spread of the values is far above the error.
#[test]
fn ninety_five_of_a_hundred_limits_of_oscillating_families_are_inside() {
    for by_noise in [true, false] {
        for (meshes, tolerance) in [(3, 0.02), (3, 0.05), (4, 0.05), (5, 0.05), (6, 0.05)] {
            let mut families = Oscillations { random: SplitMix(3 + meshes as u64), meshes, by_noise, tolerance };
            let oscillating: Vec<Estimate> = (0..20_000).filter_map(|_| families.draw()).collect();
            let share = |of: &dyn Fn(&Estimate) -> bool| {
                let part: Vec<&Estimate> = oscillating.iter().filter(|e| e.method == Method::Spread && of(e)).collect();
                let held = part.iter().filter(|e| (e.extrapolated - 1.0).abs() <= e.uncertainty).count();
                (held as f64 / part.len().max(1) as f64, part.len())
            };
            let (all, defensible) = (share(&|_| true), share(&|e| e.defensible));
            let spread = oscillating.iter().filter(|e| e.method == Method::Spread);
            let wide = median(&spread.map(|e| e.uncertainty / (e.extrapolated - 1.0).abs()).collect::<Vec<f64>>());
            println!(
                "by noise {by_noise}, {meshes} meshes: {all:?} of all, {defensible:?} of the defensible, U/error {wide:.1}"
            );
            assert!(all.0 >= 0.95 && (defensible.0 >= 0.95 || defensible.1 < 100), "{meshes}: {all:?} {defensible:?}");
            assert!(!by_noise || defensible.1 > 100 && wide < 16.0, "{meshes}: {defensible:?}, U/error {wide}");
        }
    }
}
