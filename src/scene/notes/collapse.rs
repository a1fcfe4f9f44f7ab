//! Cavities whose walls pass through each other during a run.

/// A cavity whose walls have passed through each other.
#[derive(Clone, Debug, PartialEq)]
pub struct CollapsedCavity {
    pub name: String,
    /// First recorded time with a volume that is not positive \[s\]
    pub t: f64,
    /// Volume at that time \[m³\]
    pub volume: f64,
}

/// The named cavities that have collapsed in the recorded rows; the first column is the time.
pub(in crate::scene) fn collapsed<'a>(
    names: impl Iterator<Item = &'a str>,
    columns: &[String],
    rows: &[Vec<f64>],
) -> Vec<CollapsedCavity> {
    let first = |name: &str| {
        let column = format!("{name}_volume_m3");
        let k = columns.iter().position(|c| *c == column)?;
        let row = rows.iter().find(|row| row[k] <= 0.0)?;
        Some(CollapsedCavity { name: name.into(), t: row[0], volume: row[k] })
    };
    names.filter_map(first).collect()
}
