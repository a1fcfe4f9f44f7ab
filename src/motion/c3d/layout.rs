//! Location and format of the data of a C3D file, from its header and parameters.

use super::bytes::{BLOCK, Order};
use super::parameters::Parameters;

/// Label of a point that has none
const UNNAMED: &str = "point";
/// Number of values of a word of the header
const WORD: usize = 65_536;
/// Last frames at which a header is full: the largest words, without and with a sign
const FULL: [usize; 2] = [WORD - 1, WORD / 2 - 1];

/// Location of the points, and how they are written.
pub struct Layout {
    order: Order,
    parameters: Parameters,
    pub points: usize,
    /// Number of analog measurements per frame
    analog: usize,
    pub first_frame: usize,
    /// Number of frames; `None` if the header cannot state it: then all complete frames are read
    pub frames: Option<usize>,
    /// Offset of the first byte of the data
    pub start: usize,
    /// Factor of integers; if negative, the data are floats
    scale: f64,
    pub rate: f64,
    pub unit: Option<String>,
}

impl Layout {
    /// Reads header and parameters.
    ///
    /// # Errors
    /// A sentence that says what is damaged.
    pub fn read(file: &[u8]) -> Result<Self, String> {
        let at = (usize::from(file[0]).max(1) - 1) * BLOCK;
        let code = file.get(at + 3).copied().unwrap_or(0);
        let order = Order::of(code).ok_or_else(|| format!("processor {code} is none of 84, 85, 86"))?;
        let parameters = Parameters::read(file, at, order);
        // Words of the header are counted from 1
        let word = |k: usize| usize::from(order.u16(file, 2 * (k - 1)));
        let number = |group: &str, name: &str| parameters.numbers(group, name).first().copied();
        let unsigned = |x: f64| if x < 0.0 { x + 65_536.0 } else { x };
        let points = word(2);
        if let Some(used) = number("POINT", "USED").map(unsigned).filter(|used| *used != points as f64) {
            return Err(format!("the header announces {points} points, POINT:USED is {used}"));
        }
        let (first, last) = (word(4), word(5));
        let frames = frames(&parameters, first, last)?;
        let stated = f64::from(order.f32(file, 12));
        let scale = number("POINT", "SCALE").filter(|s| *s != 0.0).unwrap_or(stated);
        if scale == 0.0 || !scale.is_finite() {
            return Err(format!("the scale of the coordinates is {scale}"));
        }
        let start = number("POINT", "DATA_START").map_or(0, |s| unsigned(s) as usize);
        let start = if word(9) > 0 { word(9) } else { start };
        if start < 2 {
            return Err(format!("the data start in block {start}, which is the header"));
        }
        let rate = number("POINT", "RATE").filter(|r| *r > 0.0).unwrap_or(f64::from(order.f32(file, 20)));
        let unit = parameters.texts("POINT", "UNITS").first().filter(|u| !u.is_empty()).cloned();
        let start = (start - 1) * BLOCK;
        Ok(Self {
            order,
            points,
            analog: word(3),
            first_frame: first.max(1),
            frames,
            start,
            scale,
            rate,
            unit,
            parameters,
        })
    }

    /// Number of bytes of a number: four for floats, two for integers.
    fn size(&self) -> usize {
        if self.scale < 0.0 { 4 } else { 2 }
    }

    /// Number of bytes of a frame: four numbers for each point, then the analog measurements.
    pub fn frame_bytes(&self) -> usize {
        (4 * self.points + self.analog) * self.size()
    }

    /// Labels of all points; points without a label are numbered.
    pub fn labels(&self) -> Vec<String> {
        let stated: Vec<&String> = ["LABELS", "LABELS2", "LABELS3", "LABELS4"]
            .iter()
            .flat_map(|name| self.parameters.texts("POINT", name))
            .collect();
        let one = |k: usize| match stated.get(k) {
            Some(name) if !name.is_empty() => name.to_string(),
            _ => format!("{UNNAMED} {}", k + 1),
        };
        (0..self.points).map(one).collect()
    }

    /// Returns the position of a point in a frame, in the unit of the file; `None` if the fourth number says that it was not visible.
    pub fn point(&self, frame: &[u8], k: usize) -> Option<[f64; 3]> {
        let at = 4 * k * self.size();
        if self.scale < 0.0 {
            let read = |i: usize| f64::from(self.order.f32(frame, at + 4 * i));
            let point = [read(0), read(1), read(2)];
            return (read(3) >= 0.0 && point.iter().all(|x| x.is_finite())).then_some(point);
        }
        let read = |i: usize| self.order.i16(frame, at + 2 * i);
        (read(3) >= 0).then(|| [0, 1, 2].map(|i| self.scale * f64::from(read(i))))
    }

    /// A line on the number format.
    pub fn words(&self) -> String {
        let kind = if self.scale < 0.0 { "floats".into() } else { format!("integers times {}", self.scale) };
        format!("{kind} of {} processors; the first frame is number {}", self.order.name(), self.first_frame)
    }
}

/// Returns the number of frames. The words of the header are limited to 65 535; longer recordings state the frames in parameters, which have to agree
/// with the header as far as its words go.
fn frames(parameters: &Parameters, first: usize, last: usize) -> Result<Option<usize>, String> {
    let long = |name: &str| match parameters.numbers("TRIAL", name) {
        // Two unsigned words, the lower one first
        [low, high, ..] => {
            Some([low, high].map(|w| if *w < 0.0 { *w + 65_536.0 } else { *w })).map(|[l, h]| l + 65_536.0 * h)
        }
        _ => None,
    };
    let of_trial = long("ACTUAL_START_FIELD").zip(long("ACTUAL_END_FIELD")).map(|(from, to)| to - from + 1.0);
    let of_points = parameters.numbers("POINT", "LONG_FRAMES").first().copied();
    let stated = [of_trial, of_points].into_iter().flatten().find(|n| *n >= 1.0 && *n <= 1e9).map(|n| n as usize);
    if let Some(stated) = stated {
        let agrees = (last + 1 + WORD - first) % WORD == stated % WORD;
        return if agrees || FULL.contains(&last) {
            Ok(Some(stated))
        } else {
            Err(format!("the header announces the frames {first} to {last}, the parameters announce {stated} frames"))
        };
    }
    if last < first.max(1) {
        return Err(format!("the last frame {last} is before the first one {}", first.max(1)));
    }
    Ok((last != FULL[0]).then_some(last + 1 - first))
}
