//! Starting values for a damped vibration: the best point of a grid of frequencies and decay rates.

/// Departure from the trend, relative to the rms about it, that a curve must reach before another crossing counts \[–\]
const HYSTERESIS: f64 = 0.25;
/// Range of frequencies to try, relative to the frequency of the crossings \[–\]
const AROUND: [f64; 2] = [0.4, 2.5];
/// Number of grid points per frequency interval 1/T of the window \[–\]
const FINE: f64 = 4.0;
/// Decay rates to try, times the duration of the window \[–\]
const DECAYS: [f64; 5] = [0.1, 0.5, 1.5, 4.0, 10.0];
/// Largest number of frequencies in the grid
const MOST: f64 = 400.0;

/// Returns the lowest and highest frequency to try \[Hz\], from the times at which a curve without its trend crosses zero.
pub fn frequencies(s: &[f64], left: &[f64]) -> [f64; 2] {
    let span = s[s.len() - 1] - s[0];
    let limit = HYSTERESIS * (left.iter().map(|v| v * v).sum::<f64>() / left.len() as f64).sqrt();
    let mut side = 0.0;
    let mut crossings = vec![];
    for (s, v) in s.iter().zip(left) {
        if v.abs() > limit {
            if side * v < 0.0 {
                crossings.push(*s);
            }
            side = v.signum();
        }
    }
    let nyquist = 0.5 * (s.len() - 1) as f64 / span;
    let guess = match crossings[..] {
        [first, .., last] if last > first => (crossings.len() - 1) as f64 / (2.0 * (last - first)),
        _ => 1.0 / span,
    };
    let low = (AROUND[0] * guess).max(0.5 / span);
    [low.min(nyquist), (AROUND[1] * guess).max(3.0 / span).min(nyquist)]
}

/// Returns the frequency \[Hz\] and decay rate \[1/s\] with the smallest misfit on the grid; `None` if no misfit is finite.
pub fn best(s: &[f64], [low, high]: [f64; 2], misfit: impl Fn([f64; 2]) -> f64) -> Option<[f64; 2]> {
    let span = s[s.len() - 1] - s[0];
    let count = (FINE * span * (high - low)).ceil().clamp(8.0, MOST);
    let points = (0..=count as usize).flat_map(|k| DECAYS.map(|d| [low + (high - low) * k as f64 / count, d / span]));
    let tried = points.map(|x| (misfit(x), x)).filter(|(m, _)| m.is_finite());
    tried.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, x)| x)
}
