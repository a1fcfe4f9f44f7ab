//! Dimensions of a test piece, which convert a force into a nominal stress and a displacement into a strain.
//!
//! P = F/A with A = width × thickness, ¼π diameter², or as given; e = u/L with the gauge length L, where the part CF of the travel u that is taken up
//! by machine and grips of compliance C is subtracted.

use super::accuracy::SharedError;
use super::names;
use crate::calibrate::FitError;
use crate::calibrate::error::Unclear;
use crate::math::units::{self, Dimension};
use crate::wording::misspelt;

/// Undeformed dimensions; `None` if unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dimensions {
    /// \[m\]; in simple shear the thickness that is sheared
    pub gauge_length: Option<f64>,
    /// \[m\]
    pub width: Option<f64>,
    /// \[m\]
    pub thickness: Option<f64>,
    /// \[m\]
    pub diameter: Option<f64>,
    /// Cross-section \[m²\]
    pub area: Option<f64>,
    /// Compliance of machine and grips \[m/N\]
    pub compliance: Option<f64>,
}

/// The dimension that a symbol of ISO 37 or testXpert denotes, as in `L0 [mm]`.
pub(super) fn symbol(name: &str) -> Option<&'static str> {
    match name.split(['[', '(', ' ']).next()? {
        "L0" | "l0" | "L₀" => Some("gauge_length"),
        "a0" | "a₀" => Some("thickness"),
        "b0" | "b₀" => Some("width"),
        "d0" | "D0" | "d₀" => Some("diameter"),
        "S0" | "A0" | "S₀" | "A₀" => Some("area"),
        _ => None,
    }
}

/// The dimension of the stretched part that the name in a line of a header denotes. The whole name must match, because another word changes its
/// meaning: "Jaw face width", "Final width", "Specimen length".
fn named(name: &str) -> Option<&'static str> {
    const NAMES: [(&str, &[&str]); 5] = [
        ("thickness", &["thickness", "gauge thickness", "dicke", "probendicke", "prüfkörperdicke", "anfangsdicke"]),
        ("width", &["width", "gauge width", "breite", "probenbreite", "prüfkörperbreite", "anfangsbreite"]),
        ("diameter", &["diameter", "durchmesser", "probendurchmesser", "prüfkörperdurchmesser", "anfangsdurchmesser"]),
        (
            "gauge_length",
            &[
                "gauge length",
                "gage length",
                "extensometer gauge length",
                "extensometer gage length",
                "messlänge",
                "anfangsmesslänge",
            ],
        ),
        (
            "area",
            &[
                "cross section",
                "cross section area",
                "cross sectional area",
                "querschnitt",
                "querschnittsfläche",
                "probenquerschnitt",
                "anfangsquerschnitt",
            ],
        ),
    ];
    /// Words that do not change the meaning
    const PLAIN: &[&str] = &[
        "specimen",
        "sample",
        "anfangs",
        "test",
        "piece",
        "proben",
        "probe",
        "parallel",
        "narrow",
        "of",
        "the",
        "initial",
        "original",
        "undeformed",
        "nominal",
        "measured",
        "mean",
        "average",
    ];
    const UNITS: &[&str] = &["m", "cm", "mm", "um", "µm", "in", "inch", "inches"];
    const SYMBOLS: &[&str] = &["a", "b", "d", "l", "s"];
    let words = names::words(name);
    let is_plain = |w: &&String| [PLAIN, UNITS, SYMBOLS].iter().any(|list| list.contains(&w.as_str()));
    let left: Vec<&str> = words.iter().filter(|w| !is_plain(w)).map(String::as_str).collect();
    let left = left.join(" ");
    // "Section width" is the width of the stretched part
    let left = left.strip_prefix("section ").unwrap_or(&left);
    NAMES.into_iter().find(|(_, known)| known.contains(&left)).map(|(key, _)| key)
}

/// Relative difference below which two values of one dimension are equal \[–\]
const SAME: f64 = 1e-3;

/// Largest relative difference of cross-sections from different dimensions \[–\]
const AGREE: f64 = 0.01;

impl Dimensions {
    /// Keys of `[specimen]` of a card, which are also flags, with their dimensions
    pub const KEYS: [(&'static str, Dimension); 6] = [
        ("gauge_length", Dimension::LENGTH),
        ("width", Dimension::LENGTH),
        ("thickness", Dimension::LENGTH),
        ("diameter", Dimension::LENGTH),
        ("area", Dimension::AREA),
        ("compliance", Dimension::COMPLIANCE),
    ];

    fn slot(&mut self, key: &str) -> Option<&mut Option<f64>> {
        match key {
            "gauge_length" => Some(&mut self.gauge_length),
            "width" => Some(&mut self.width),
            "thickness" => Some(&mut self.thickness),
            "diameter" => Some(&mut self.diameter),
            "area" => Some(&mut self.area),
            "compliance" => Some(&mut self.compliance),
            _ => None,
        }
    }

    /// Sets `key` from a text such as `33 mm`.
    pub fn set(&mut self, key: &'static str, text: &str) -> Result<(), FitError> {
        let (_, dimension) = Self::KEYS.into_iter().find(|(k, _)| *k == key).expect("a key of the list");
        let refuse = |reason: String| FitError::Dimension { key, text: text.into(), reason };
        let value = units::parse(text, dimension).map_err(|e| refuse(e.to_string()))?;
        if !(value > 0.0 && value.is_finite()) {
            return Err(refuse("must be above zero".into()));
        }
        *self.slot(key).expect("a key of the list") = Some(value);
        Ok(())
    }

    /// The dimensions in `[specimen]` of a card; other keys are free there, unless one is a misspelling of a known key.
    pub fn of_card(specimen: &toml::Table) -> Result<Self, FitError> {
        let absent: Vec<&str> = Self::KEYS.into_iter().map(|k| k.0).filter(|k| !specimen.contains_key(*k)).collect();
        let known = |key: &str| Self::KEYS.iter().any(|k| k.0 == key);
        let unread = specimen.keys().filter(|key| !known(key));
        if let Some((key, meant)) = unread.filter_map(|key| Some((key, misspelt(key, &absent)?))).next() {
            return Err(FitError::Misspelt { key: key.clone(), meant: meant.into() });
        }
        let mut found = Self::default();
        for (key, _) in Self::KEYS {
            match specimen.get(key) {
                None => {}
                Some(toml::Value::String(text)) => found.set(key, text)?,
                Some(other) => found.set(key, &other.to_string())?,
            }
        }
        Ok(found)
    }

    /// The dimensions in the lines above a table, such as `Specimen Thickness (mm);3`; lines that are not understood are ignored. A dimension for
    /// which several lines give different values counts as unknown, and is returned with these lines.
    pub fn of_header(header: &[(String, String)]) -> (Self, Vec<Unclear>) {
        let read = |(name, value): &(String, String)| {
            let key = named(name).or_else(|| symbol(name))?;
            let text = names::unit(name).map_or_else(|| value.clone(), |u| format!("{value} {}", units::spelled(&u)));
            let mut one = Self::default();
            one.set(key, &text).or_else(|_| one.set(key, &text.replace(',', "."))).ok()?;
            Some((key, (*one.slot(key)?)?, format!("\"{name}: {value}\"")))
        };
        let all: Vec<(&'static str, f64, String)> = header.iter().filter_map(read).collect();
        let (mut found, mut unclear) = (Self::default(), vec![]);
        for (key, _) in Self::KEYS {
            let own: Vec<_> = all.iter().filter(|one| one.0 == key).collect();
            let Some((_, first, _)) = own.first() else { continue };
            if own.iter().all(|(_, value, _)| (value / first - 1.0).abs() <= SAME) {
                *found.slot(key).expect("a key of the list") = Some(*first);
            } else {
                unclear.push(Unclear { key, lines: own.iter().map(|one| one.2.clone()).collect() });
            }
        }
        (found, unclear)
    }

    /// Whether a dimension is known.
    pub fn has(mut self, key: &str) -> bool {
        self.slot(key).is_some_and(|value| value.is_some())
    }

    /// Dimensions for which the other side gives values that differ by more than 0.1 %: key, own value and other value as text.
    pub fn contradictions(self, other: Self) -> Vec<(&'static str, String, String)> {
        let (mut own, mut theirs) = (self, other);
        let one = |(key, dimension): (&'static str, Dimension)| {
            let (a, b) = ((*own.slot(key)?)?, (*theirs.slot(key)?)?);
            let text = |x: f64| match dimension {
                Dimension::AREA => format!("{:.6} mm²", 1e6 * x),
                Dimension::COMPLIANCE => format!("{:.6} mm/N", 1e3 * x),
                _ => format!("{:.6} mm", 1e3 * x),
            };
            ((a / b - 1.0).abs() > SAME).then(|| (key, text(a), text(b)))
        };
        Self::KEYS.into_iter().filter_map(one).collect()
    }

    fn has_section(&self) -> bool {
        self.area.or(self.diameter).or(self.width.and(self.thickness)).is_some()
    }

    /// These dimensions, completed by others; a known cross-section is not compared with theirs.
    pub fn or(self, other: Self) -> Self {
        let gauge_length = self.gauge_length.or(other.gauge_length);
        let compliance = self.compliance.or(other.compliance);
        if self.has_section() {
            return Self { gauge_length, compliance, ..self };
        }
        Self {
            gauge_length,
            compliance,
            width: self.width.or(other.width),
            thickness: self.thickness.or(other.thickness),
            diameter: self.diameter.or(other.diameter),
            area: self.area.or(other.area),
        }
    }

    /// Cross-section \[m²\], which a shared error needs.
    pub fn needed_section(&self, error: SharedError) -> Result<f64, FitError> {
        let section = self.section("", "").map(|(area, _)| area);
        section.map_err(|_| FitError::ErrorNeeds { error: error.name(), what: "the cross-section", flag: "area" })
    }

    /// Gauge length \[m\], which a shared error needs.
    pub fn needed_length(&self, error: SharedError) -> Result<f64, FitError> {
        self.gauge_length.ok_or(FitError::ErrorNeeds {
            error: error.name(),
            what: "the gauge length",
            flag: "gauge-length",
        })
    }

    /// Cross-section \[m²\] and how it was determined.
    pub fn section(&self, file: &str, column: &str) -> Result<(f64, String), FitError> {
        let mm = |v: f64| format!("{:.6}", 1e3 * v).trim_end_matches('0').trim_end_matches('.').to_string();
        let sides = self.width.zip(self.thickness);
        let sections = [
            self.area.map(|a| (a, "as given".to_string())),
            sides.map(|(w, t)| (w * t, format!("{} mm × {} mm", mm(w), mm(t)))),
            self.diameter
                .map(|d| (0.25 * std::f64::consts::PI * d * d, format!("of a circle with diameter {} mm", mm(d)))),
        ];
        let sections: Vec<_> = sections.into_iter().flatten().collect();
        let Some((area, how)) = sections.first().cloned() else {
            return Err(FitError::NoSection { file: file.into(), column: column.into() });
        };
        match sections.iter().find(|(other, _)| (other / area - 1.0).abs() > AGREE) {
            Some((other, _)) => Err(FitError::Sections { file: file.into(), first: 1e6 * area, second: 1e6 * other }),
            None => Ok((area, format!("{:.6} mm² ({how})", 1e6 * area))),
        }
    }
}
