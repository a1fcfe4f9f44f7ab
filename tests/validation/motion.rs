//! Measured motion: registration against closed form and draws, readers against files of independent writers, plateaus and ring-downs of known truth
//! and of a measured beam.
//!
//! The tables `tests/motion/*_a.csv`, `*_b.csv` are tip markers of a silicone beam that is held, released and comes to rest, with and without a mass of
//! 52 g (Soft Robotics Lab, ETH Zurich, 2021; MIT, LICENSE.txt next to them).

use durometer::math::random::SplitMix;
use durometer::math::statistics::larger;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::motion::body::{Pose, pose, twist};
use durometer::motion::plateau::{Plateau, PlateauRule, held_and_final, plateaus};
use durometer::motion::registration::rigid;
use durometer::motion::release::{ReleaseRule, Side, release};
use durometer::motion::repeats::pooled;
use durometer::motion::ring_down::{Creep, ring_down};
use durometer::motion::{Curve, MotionError, ReadOptions, Tracks};
use nalgebra::Rotation3;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

fn at(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/motion").join(name)
}

fn noise(random: &mut SplitMix, n: usize, rho: f64) -> Vec<f64> {
    let mut before = random.normal();
    (0..n)
        .map(|_| {
            let now = before;
            before = rho * before + (1.0 - rho * rho).sqrt() * random.normal();
            now
        })
        .collect()
}

/// Markers of the tip where the beam is straight, held and without a mass [m] (README of the data).
const TIP: [[f64; 3]; 3] = [[0.09926, -0.00036, 0.02048], [0.10055, -0.02071, 0.00913], [0.09927, 0.02123, -0.00848]];
/// Centre of the free face [m]
const FACE: [f64; 3] = [0.1, 0.0, 0.0];

fn names() -> Vec<String> {
    ["tip1", "tip2", "tip3"].map(String::from).to_vec()
}

fn beam(trial: &str) -> Vec<Pose> {
    let tracks = Tracks::read(&at(&format!("{trial}.csv")), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(tracks.markers.len(), 3);
    pose(&tracks, &names(), &TIP.map(Vec3::from)).unwrap_or_else(|e| panic!("{e}"))
}

fn curve(poses: &[Pose], name: &str, value: impl Fn(&Pose) -> f64) -> Curve {
    let column = |f: &dyn Fn(&Pose) -> f64| poses.iter().map(f).collect::<Vec<f64>>();
    Curve::weighted(name, column(&|p| p.time_s), column(&value), column(&|p| p.samples)).expect("a sound curve")
}

fn drop_of(poses: &[Pose]) -> Curve {
    curve(poses, "tip_z_m", |p| p.displacement(FACE.into()).z)
}

/// The held and the final state of a curve that has both.
fn both(curve: &Curve, rule: &PlateauRule) -> [Plateau; 2] {
    let found = held_and_final(curve, rule).unwrap_or_else(|e| panic!("{}: {e}", curve.name));
    found.map(|state| state.unwrap_or_else(|| panic!("{}: two states", curve.name)))
}

/// Motion of the face from held to final against `static_by_trial.csv` of the data, which takes the last second. Its numbers are rounded to 0.01 mm
/// and 0.01°; its held window is another one of the plateau, its rotation a difference of two angles, and its positions are rounded to 0.01 mm: 0.03 mm and
/// 0.1°. The window that is found here is longer: creep of 0.07 mm (gravity) and 0.3 mm (52 g) from 2 s on bounds the difference.
#[test]
fn plateaus_of_a_measured_beam_are_those_of_its_tables() {
    for (trial, dz, rotation, creep) in [
        ("gravity_a", -6.45, 5.04, 0.07),
        ("gravity_b", -6.53, 5.12, 0.07),
        ("load52_a", -16.92, 13.64, 0.26),
        ("load52_b", -17.02, 14.41, 0.32),
    ] {
        let poses = beam(trial);
        let z = drop_of(&poses);
        let turned = curve(&poses, "rotation_y_rad", |p| p.rotation_about(Vec3::y()));
        let [held, end] = both(&z, &PlateauRule::default());
        println!("{trial}: held {held:?}\n final {end:?} {:?}", end.doubt());
        let found = 1e3 * (end.mean.value - held.mean.value);
        assert!((found - dz).abs() < 0.5 * creep + 0.01, "{trial}: {found} mm, {dz}");
        // The windows of the tables give the tables
        let last = z.time_s[z.time_s.len() - 1];
        let stated = |c: &Curve| {
            let [a, b] = [[-0.2, -0.005], [last - 1.0, last]].map(|w| Plateau::over(c, w).expect("rows").mean.value);
            b - a
        };
        println!("{trial}: {found:.3} mm; {:.3} mm, {:.3} deg", 1e3 * stated(&z), stated(&turned).to_degrees());
        assert!((1e3 * stated(&z) - dz).abs() < 0.03, "{trial}: {} mm", 1e3 * stated(&z));
        assert!((stated(&turned).to_degrees() - rotation).abs() < 0.1, "{trial}: {} deg", stated(&turned).to_degrees());
        // Time zero of the data is the last sample before the mean height of the tip has fallen by 0.1 mm
        let tracks = Tracks::read(&at(&format!("{trial}.csv")), &ReadOptions::default()).expect("read before");
        let mean = |k: usize| tracks.markers.iter().map(|m| m.points[k].expect("seen")[2]).sum::<f64>() / 3.0;
        let height: Vec<f64> = (0..tracks.time_s.len()).map(mean).collect();
        let height = Curve::new("height_m", tracks.time_s.clone(), height).expect("sound");
        let [held, _] = both(&height, &PlateauRule::default());
        let rule = ReleaseRule { factor: 0.0, threshold: 1e-4, side: Side::Below };
        assert_eq!(release(&height, &held, &rule).expect("released").time_s, 0.0, "{trial}");
        assert!(end.doubt().is_some() || trial.starts_with("gravity"), "silicone under 52 g creeps");
    }
}

/// Against `dynamics_by_trial.csv` of the data, whose creep term is not documented: 0.2 % of the frequency and 6 % of the decay.
#[test]
fn ring_downs_of_a_measured_beam_are_those_of_its_tables() {
    for (trial, f, d) in [
        ("gravity_a", [7.724, 7.737], [2.62, 2.37]),
        ("gravity_b", [7.730, 7.732], [2.71, 2.44]),
        ("load52_a", [4.327, 4.357], [1.51, 1.65]),
        ("load52_b", [4.293, 4.319], [1.38, 1.45]),
    ] {
        let z = drop_of(&beam(trial));
        for (k, window) in [[0.05, 0.8], [0.3, 1.6]].into_iter().enumerate() {
            let found = ring_down(&z, window, 0.0, Creep::Logarithmic).unwrap_or_else(|e| panic!("{trial}: {e}"));
            let [df, dd] = [found.frequency_hz.value / f[k] - 1.0, found.decay_per_s.value / d[k] - 1.0];
            println!(
                "{trial} {window:?}: {} Hz ({:+.2} %), {} 1/s ({:+.1} %), rms {:.3e} rho {:.2} free {}",
                found.frequency_hz.words("Hz"),
                100.0 * df,
                found.decay_per_s.words("1/s"),
                100.0 * dd,
                found.rms,
                found.correlation,
                found.free
            );
            assert!(df.abs() < 0.002 && dd.abs() < 0.06, "{trial} {window:?}: {df} {dd}");
        }
    }
}

fn synthetic(random: &mut SplitMix, sigma: f64, rho: f64) -> Curve {
    let time: Vec<f64> = (0..150).map(|k| 0.05 + 0.01 * f64::from(k)).collect();
    let e = noise(random, time.len(), rho);
    let y =
        |(t, e): (&f64, &f64)| 2e-3 * (-1.8 * t).exp() * (TAU * 5.3 * t + 0.7).cos() - 8e-3 - 2e-4 * t.ln() + sigma * e;
    Curve::new("z_m", time.clone(), time.iter().zip(&e).map(y).collect()).expect("sound")
}

/// Fraction of the draws in which each interval contains the truth.
fn coverage(sigma: f64, rho: f64, draws: usize) -> [f64; 4] {
    let mut random = SplitMix(7);
    let mut inside = [0; 4];
    for _ in 0..draws {
        let r = ring_down(&synthetic(&mut random, sigma, rho), [0.05, 1.55], 0.0, Creep::Logarithmic).expect("seen");
        let truth = [(r.frequency_hz, 5.3), (r.decay_per_s, 1.8), (r.amplitude, 2e-3), (r.offset, -8e-3)];
        for (k, (b, x)) in truth.iter().enumerate() {
            inside[k] += usize::from((b.interval[0]..=b.interval[1]).contains(x));
        }
    }
    inside.map(|n| n as f64 / draws as f64)
}

/// 200 draws leave a standard error of 1.5 % about 95 %; [`DUROMETER_DRAWS`] draws more.
#[test]
fn intervals_of_a_ring_down_hold_as_often_as_they_say() {
    let draws = std::env::var("DUROMETER_DRAWS").ok().and_then(|n| n.parse().ok()).unwrap_or(200);
    for (sigma, rho) in [(1e-4, 0.0), (1e-4, 0.6), (2e-5, 0.8)] {
        let found = coverage(sigma, rho, draws);
        println!("sigma {sigma} rho {rho}: {found:?}");
        assert!(found.iter().all(|c| (0.92..=0.98).contains(c)), "{sigma} {rho}: {found:?}");
    }
}

#[test]
fn a_clean_ring_down_is_found_to_rounding() {
    let r = ring_down(&synthetic(&mut SplitMix(1), 0.0, 0.0), [0.05, 1.55], 0.0, Creep::Logarithmic).expect("seen");
    for (found, truth) in [
        (r.frequency_hz.value, 5.3),
        (r.decay_per_s.value, 1.8),
        (r.amplitude.value, 2e-3),
        (r.phase.value, 0.7),
        (r.offset.value, -8e-3),
        (r.creep.value, -2e-4),
    ] {
        assert!((found / truth - 1.0).abs() < 1e-8, "{found} {truth}");
    }
    assert!((r.at(0.5) - synthetic(&mut SplitMix(1), 0.0, 0.0).value[45]).abs() < 1e-12);
}

/// Rotation vectors of any size, scales of frequency and decay: the start values lead to the truth from one to forty periods.
#[test]
fn ring_downs_from_one_to_forty_periods_are_found() {
    for periods in [1.5, 4.0, 12.0, 40.0] {
        for decay in [0.2, 1.0, 5.0] {
            let time: Vec<f64> = (0..600).map(|k| 1e-3 + f64::from(k) / 600.0).collect();
            let y = |t: &f64| (-decay * t).exp() * (TAU * periods * t - 1.0).cos() + 3.0 + 0.3 * t;
            let c = Curve::new("z", time.clone(), time.iter().map(y).collect()).expect("sound");
            let r = ring_down(&c, [0.0, 1.0], 0.0, Creep::Linear).unwrap_or_else(|e| panic!("{periods} {decay}: {e}"));
            assert!(
                (r.frequency_hz.value - periods).abs() < 1e-7 && (r.decay_per_s.value - decay).abs() < 1e-6,
                "{r:?}"
            );
        }
    }
}

/// A vibration of a twentieth of the creep on which it rides is found at its frequency; noise of a twentieth of it leaves four standard errors of 0.02 Hz.
#[test]
fn a_small_vibration_on_much_creep_is_found() {
    let mut random = SplitMix(3);
    for (frequency, amplitude, noise) in [(15.0, 1e-4, 5e-6), (30.0, 3e-4, 5e-6)] {
        let time: Vec<f64> = (0..195).map(|k| 0.05 + 0.01 * f64::from(k)).collect();
        let y = |t: &f64| {
            amplitude * (-2.0 * t).exp() * (TAU * frequency * t).cos() + 2e-3 * t.ln() + noise * random.normal()
        };
        let c = Curve::new("z_m", time.clone(), time.iter().map(y).collect()).expect("sound");
        let r = ring_down(&c, [0.05, 2.0], 0.0, Creep::Logarithmic).unwrap_or_else(|e| panic!("{frequency} Hz: {e}"));
        assert!((r.frequency_hz.value - frequency).abs() < 0.1, "{frequency} Hz: {:?}", r.frequency_hz);
    }
}

fn body() -> Vec<Vec3> {
    [[0.1, 0.02, 0.0], [0.0, 0.12, 0.03], [-0.08, 0.0, 0.05], [0.03, -0.07, -0.06], [0.0, 0.05, 0.11]]
        .map(Vec3::from)
        .to_vec()
}

#[test]
fn a_rigid_motion_is_recovered_to_rounding() {
    let points = body();
    for angle in [0.0, 1e-7, 0.3, 3.1] {
        let rotation: Mat3 =
            Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(Vec3::new(1.0, -2.0, 0.5)), angle).into_inner();
        let shift = Vec3::new(0.4, -1.2, 7.0);
        let moved: Vec<Vec3> = points.iter().map(|p| rotation * p + shift).collect();
        for weights in [None, Some([1.0, 4.0, 0.5, 2.0, 1.0])] {
            let found = rigid(&points, &moved, weights.as_ref().map(|w| &w[..])).expect("five points in space");
            // Coordinates of 7 m have a rounding of 1e-15 m, over an arm of 0.1 m
            assert!((found.rotation - rotation).amax() < 1e-13 && (found.translation - shift).amax() < 1e-13);
            assert!((twist(&found.rotation, Vec3::new(1.0, -2.0, 0.5)) - angle).abs() < 1e-13);
            assert!(found.rms < 1e-14 && found.worst_and_rms_left_out().expect("four others")[0] < 1e-13);
        }
    }
    // A mirror image is not reached by a reflection
    let mirrored: Vec<Vec3> = points.iter().map(|p| Vec3::new(-p.x, p.y, p.z)).collect();
    let found = rigid(&points, &mirrored, None).expect("a rotation");
    assert!((found.rotation.determinant() - 1.0).abs() < 1e-12 && found.rms > 0.01);
}

/// Covariance of 2 000 draws with errors of 1 mm against the stated one: the variance of each has a standard error of √(2/2000) = 3 %, of which four are
/// allowed; the intervals of a transformed point hold in 95 ± 1.5 %.
#[test]
fn the_covariance_of_a_registration_is_that_of_draws() {
    let (points, sigma, draws) = (body(), 1e-3, 2000);
    let rotation: Mat3 = Rotation3::from_euler_angles(0.2, -0.9, 2.0).into_inner();
    let shift = Vec3::new(0.1, 0.2, -0.3);
    let (tip, mut random) = (Vec3::new(0.3, 0.0, 0.1), SplitMix(11));
    let (mut sum, mut stated, mut inside) = (Mat3::zeros(), Mat3::zeros(), 0);
    for _ in 0..draws {
        let mut error = || sigma * Vec3::new(random.normal(), random.normal(), random.normal());
        let moved: Vec<Vec3> = points.iter().map(|p| rotation * p + shift + error()).collect();
        let found = rigid(&points, &moved, None).expect("five points");
        let off = found.apply(tip) - rotation * tip - shift;
        sum += off * off.transpose() / f64::from(draws);
        stated += found.covariance_at(tip) / f64::from(draws);
        inside += u32::from(off.x.abs() <= found.half_widths_at(tip).x);
    }
    for k in 0..3 {
        assert!((sum[(k, k)] / stated[(k, k)] - 1.0).abs() < 0.13, "{sum} {stated}");
    }
    let part = f64::from(inside) / f64::from(draws);
    assert!((part - 0.95).abs() < 0.015, "{part}");
}

#[test]
fn points_that_determine_no_motion_are_refused() {
    let points = body();
    let line: Vec<Vec3> = (0..4).map(|k| Vec3::new(f64::from(k), 2.0 * f64::from(k), 1.0)).collect();
    let mm: Vec<Vec3> = points.iter().map(|p| 1000.0 * p).collect();
    let inch: Vec<Vec3> = points.iter().map(|p| p / 25.4).collect();
    let nan: Vec<Vec3> = points.iter().map(|p| f64::NAN * p).collect();
    let refused = |a: &[Vec3], b: &[Vec3]| rigid(a, b, None).expect_err("refused").to_string();
    assert!(refused(&points[..2], &points[..2]).contains("three points or more"));
    assert!(refused(&line, &line).contains("one line"));
    assert!(refused(&points, &mm).contains("metres and millimetres"), "{}", refused(&points, &mm));
    assert!(refused(&points, &inch).contains("inches and millimetres"), "{}", refused(&points, &inch));
    assert!(refused(&points, &nan).contains("finite"));
    assert!(refused(&points, &points[..3]).contains("different lengths"));
    assert!(matches!(rigid(&points, &points, Some(&[1.0, 1.0, 0.0, 1.0, 1.0])), Err(MotionError::NotFinite { .. })));
    // Three points leave no one out, and have three degrees of freedom
    let three = rigid(&points[..3], &points[..3], None).expect("three points");
    assert!(three.worst_and_rms_left_out().is_none() && three.free == 3);
}

/// Plateaus of white and of correlated noise: the mean holds in 95 ± 3 %, and a level that does not drift is doubted in 5 ± 3 %.
#[test]
fn intervals_of_a_plateau_hold_as_often_as_they_say() {
    for rho in [0.0, 0.5, 0.8] {
        let (mut random, draws) = (SplitMix(3), 400);
        let (mut inside, mut doubted) = (0, 0);
        for _ in 0..draws {
            let value = noise(&mut random, 120, rho);
            let c = Curve::new("z", (0..120).map(f64::from).collect(), value).expect("sound");
            let p = Plateau::over(&c, [0.0, 119.0]).expect("rows");
            inside += usize::from((p.mean.interval[0]..=p.mean.interval[1]).contains(&0.0));
            doubted += usize::from(p.doubt().is_some());
        }
        let part = |n: usize| n as f64 / draws as f64;
        println!("rho {rho}: {} inside, {} doubted", part(inside), part(doubted));
        assert!((part(inside) - 0.95).abs() < 0.03 && (part(doubted) - 0.05).abs() < 0.03, "{rho}");
    }
}

/// Rows that are means of ten samples scatter by σ/√10, which is their deviation; that of a sample is σ. Single samples that follow them within 5σ are no
/// release. Standard errors of 1/√(2·400) = 3.5 %, of which four are allowed.
#[test]
fn rows_of_means_have_the_deviation_of_their_values() {
    let (mut random, sigma) = (SplitMix(9), 2e-5);
    let e = noise(&mut random, 800, 0.0);
    let value: Vec<f64> = (0..800).map(|k| if k < 400 { sigma * e[k] / 10_f64.sqrt() } else { sigma * e[k] }).collect();
    let samples = (0..800).map(|k| if k < 400 { 10.0 } else { 1.0 }).collect();
    let time: Vec<f64> = (0..800).map(|k| 0.01 * f64::from(k)).collect();
    let still = Curve::weighted("z_m", time.clone(), value.clone(), samples).expect("sound");
    let means = Plateau::over(&still, [0.0, 3.99]).expect("rows");
    assert!((means.deviation * 10_f64.sqrt() / sigma - 1.0).abs() < 0.14, "{means:?}");
    assert!((means.sample_deviation / sigma - 1.0).abs() < 0.14, "{means:?}");
    let never = release(&still, &means, &ReleaseRule::default());
    assert!(matches!(never, Err(MotionError::NoRelease { .. })), "{never:?}");
    // As single samples the same rows are a plateau with one deviation
    let single = Plateau::over(&Curve::new("z_m", time, value).expect("sound"), [0.0, 3.99]).expect("rows");
    assert!((single.deviation / means.deviation - 1.0).abs() < 1e-12 && single.deviation == single.sample_deviation);
    // The beam: no value is farther from the mean than its deviation three times, and the values are those of a plateau
    let z = drop_of(&beam("gravity_a"));
    let [_, end] = both(&z, &PlateauRule::default());
    let rows = z.window(end.window_s);
    let farthest = rows.value.iter().map(|v| (v - end.mean.value).abs()).fold(0.0, larger);
    println!("deviation {:.3e}, farthest {farthest:.3e}", end.deviation);
    assert!(end.deviation < farthest && end.deviation < PlateauRule::default().tolerance_of(&z), "{end:?}");
}

#[test]
fn a_step_has_two_plateaus_and_a_release() {
    let mut random = SplitMix(5);
    let e = noise(&mut random, 300, 0.0);
    let level = |k: usize| if k < 100 { 0.0 } else { -1.0 + (-((k - 100) as f64) / 8.0).exp() };
    let mut value: Vec<f64> = (0..300).map(|k| level(k) + 1e-3 * e[k]).collect();
    value[40] = 5.0; // one outlier
    let c = Curve::new("z", (0..300).map(|k| 0.01 * f64::from(k)).collect(), value).expect("sound");
    let [held, end] = both(&c, &PlateauRule { tolerance: Some(5e-3), ..PlateauRule::default() });
    assert!(held.window_s[1] >= 0.98 && held.window_s[1] < 1.02 && end.window_s[0] < 1.6, "{held:?} {end:?}");
    assert!((end.mean.value + 1.0).abs() < 2e-3);
    let clean = Plateau::over(&c, [0.5, 0.99]).expect("rows");
    let found = release(&c, &clean, &ReleaseRule::default()).expect("released");
    assert!((found.time_s - 1.0).abs() < 0.011, "{found:?}");
    let flat = Curve::new("z", (0..300).map(f64::from).collect(), e).expect("sound");
    assert!(matches!(held_and_final(&flat, &PlateauRule::default()), Ok([None, Some(_)])));
    assert!(plateaus(&flat, &PlateauRule::default()).expect("one").len() == 1);
    let ramp = Curve::new("z", (0..300).map(f64::from).collect(), (0..300).map(f64::from).collect()).expect("sound");
    assert!(matches!(held_and_final(&ramp, &PlateauRule::default()), Err(MotionError::NoPlateau { .. })));
    // Of two periods without rest the turning points last long enough, and are no held states
    let swing: Vec<f64> = (0..=400).map(|k| (TAU * 0.005 * f64::from(k)).sin()).collect();
    let swing = Curve::new("z", (0..=400).map(f64::from).collect(), swing).expect("sound");
    assert_eq!(plateaus(&swing, &PlateauRule::default()).expect("turning points").len(), 4);
    assert!(matches!(held_and_final(&swing, &PlateauRule::default()), Err(MotionError::NoPlateau { .. })));
}

/// A body that is held for half a second and then swings by 6 mm in two modes until the record ends, with 2.1 to 20 rows a period: the noise is that of the markers, the
/// held state ends at the release, and there is no final state while the body swings by more than the tolerance.
#[test]
fn a_vibration_of_few_rows_a_period_is_neither_noise_nor_a_final_state() {
    let (mut random, sigma) = (SplitMix(12), 2e-5);
    for (rate, f) in
        [(60.0, 3.0), (60.0, 9.7), (60.0, 12.0), (50.0, 9.7), (30.0, 10.0), (30.0, 9.7), (25.0, 6.25), (25.0, 12.0)]
    {
        for (last, d) in [(5.0, 0.05), (10.0, 0.05), (20.0, 0.1), (5.0, 0.6)] {
            let count = (rate * (last + 0.5)) as usize;
            let time: Vec<f64> = (0..count).map(|k| k as f64 / rate - 0.5).collect();
            let e = noise(&mut random, count, 0.0);
            let swing = |t: f64| {
                if t <= 0.0 {
                    0.0
                } else {
                    -6e-3 + (-d * t).exp() * (5e-3 * (TAU * f * t).cos() + 1e-3 * (TAU * 1.7 * f * t).cos())
                }
            };
            let value = time.iter().zip(&e).map(|(t, e)| swing(*t) + sigma * e).collect();
            let c = Curve::new("z_m", time, value).expect("sound");
            let case = format!("{rate} Hz, {f} Hz, {d} 1/s, {last} s");
            assert!((0.4..1.6).contains(&(c.noise() / sigma)), "{case}: noise {}", c.noise());
            let [held, end] = held_and_final(&c, &PlateauRule::default()).unwrap_or_else(|e| panic!("{case}: {e}"));
            let held = held.unwrap_or_else(|| panic!("{case}: a held state"));
            assert!(held.window_s[0] == -0.5 && held.window_s[1].abs() < 1.5 / rate, "{case}: {held:?}");
            assert!(end.is_none(), "{case}: {end:?}");
        }
    }
}

/// Student's t of one degree of freedom: two repeats of 1 and 2 have 1.5 ± 12.706·0.5.
#[test]
fn repeats_are_pooled_with_student_s_t() {
    let two = pooled(&[1.0, 2.0]).expect("two");
    assert!((two.mean.half_width() - 12.706_204_736 * 0.5).abs() < 1e-6 && two.half_range == 0.5, "{two:?}");
    assert!(pooled(&[1.0]).expect("one").mean.half_width().is_infinite());
    assert!(pooled(&[]).is_err());
}
