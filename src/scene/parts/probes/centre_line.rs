//! Probe `centre_line`: length, curvature and bending plane of the segments of a line through the body, each as a circular arc.
//!
//! Stations of the line are points that follow the body. Every segment has the arc through its two ends that is nearest to its other stations
//! ([`super::arc`]), with the parameters of the constant-curvature models of continuum robots (Webster & Jones, *Int. J. Robot. Res.* 29 (2010) 1661–1683,
//! §2): arc length, curvature, and the angle of the plane in which it bends, in the frame that is transported without twist along the preceding arcs. The
//! residual measures how far the line is from that model.

use super::arc::Arc;
use super::mean::Mean;
use super::part::Probe;
use crate::math::dual::{Dual, Number};
use crate::math::tensor::Vec3;
use crate::mesh::embed::{EmbedError, embed};
use crate::mesh::error::point;
use crate::scene::body::Body;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::record::recorder::{Headline, Moment, Recorder};
use crate::scene::text::quantity::Length;
use crate::system::{Gradient, State};
use schemars::JsonSchema;
use serde::Deserialize;

/// Smallest number of stations of a segment, including both ends: an arc through three stations has no residual.
const FEWEST: usize = 4;

/// Largest number of stations of a line.
const MOST: usize = 10_000;

/// Bend tan(θ/4) below which a segment counts as straight: its angle is less than 0.0003°.
const STRAIGHT: f64 = 1e-6;

/// Residual relative to the length of a segment below which it is rounding.
const EXACT: f64 = 1e-9;

/// Smallest sine of the angle between the line and the direction of the plane angle 0 (5.7°).
const ACROSS: f64 = 0.1;

/// Curvature and length of a line through the body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CentreLine {
    /// Prefix of the columns
    pub name: String,
    /// Stations inside the body, in order
    #[serde(default)]
    pub points: Vec<[Length; 3]>,
    /// Region at whose centroid a straight line starts, in place of points
    pub from: Option<String>,
    /// Region at whose centroid the line ends
    pub to: Option<String>,
    /// Number of stations from one region to the other
    pub stations: Option<usize>,
    /// Number of arcs of constant curvature to fit
    #[serde(default = "one")]
    pub segments: usize,
    /// Direction in which a bend has the plane angle 0
    pub towards: [f64; 3],
}

fn one() -> usize {
    1
}

impl Probe for CentreLine {
    fn build(&self, place: &str, builder: &Builder) -> Result<Box<dyn Recorder>, SceneError> {
        builder.check_name(place, &self.name)?;
        let stations = self.stations(place, builder)?;
        let (count, segments) = (stations.len(), self.segments);
        let line = Line { stations, each: (count - 1) / segments, frame: [Vec3::x(), Vec3::z()] };
        let rest = vec![0.0; 3 * builder.body.mesh.points.len()];
        let apart = |k: &usize| (line.stations[*k].at(&rest) - line.stations[k - 1].at(&rest)).norm() > 0.0;
        let start = (1..count).all(|k| apart(&k)).then(|| line.arcs(&line.points(&rest))[0].start());
        let Some(start) = start.filter(|t| t.iter().all(|v| v.is_finite())).map(Vec3::from) else {
            return Err(builder.content(place, "two stations are at the same place", "give stations that are apart"));
        };
        let zero = Vec3::from(self.towards);
        let across = zero - start * start.dot(&zero);
        if !zero.norm().is_finite() || across.norm() <= ACROSS * zero.norm() {
            let fact = format!("`towards` {:?} has no length, or is along the line at its first station", self.towards);
            let remedy = "give the direction across the line in which a bend has the plane angle 0";
            return Err(builder.content(place, fact, remedy));
        }
        let line = Line { frame: [start, across.normalize()], ..line };
        Ok(Box::new(Recorded { name: self.name.clone(), line }))
    }

    fn regions(&self) -> Vec<&str> {
        self.from.iter().chain(&self.to).map(String::as_str).collect()
    }

    fn headline(&self) -> Option<Headline> {
        let column = format!("{}_1_curvature_per_m", self.name);
        Some(Headline { column, label: "curvature", symbol: "κ", unit: "1/m" })
    }
}

impl CentreLine {
    /// Refuses a number of stations that the segments cannot share equally.
    fn check_count(&self, place: &str, builder: &Builder, count: usize) -> Result<(), SceneError> {
        let segments = self.segments;
        if count > MOST {
            let fact = format!("{count} stations are more than {MOST}");
            return Err(builder.content(place, fact, "a station for each cell along the line is enough"));
        }
        let least = segments.max(1).saturating_mul(FEWEST - 1).saturating_add(1);
        if segments == 0 || count < least || !(count - 1).is_multiple_of(segments) {
            let fact = format!("{count} stations are not shared by {segments} segments");
            let remedy = format!(
                "give 1 + {segments} n stations with n of {} or more, at least {least}: segments share their ends, and each has {FEWEST} or more",
                FEWEST - 1
            );
            return Err(builder.content(place, fact, remedy));
        }
        Ok(())
    }

    fn stations(&self, place: &str, builder: &Builder) -> Result<Vec<Mean>, SceneError> {
        let mesh = &builder.body.mesh;
        let by_ends = match (&self.from, &self.to, self.stations, self.points.is_empty()) {
            (Some(from), Some(to), Some(_), true) => Some((from, to)),
            (None, None, None, false) => None,
            _ => {
                let fact = "a line is given by `points`, or by `from`, `to` and `stations`";
                let remedy = "give all keys of one of the two ways, and none of the other";
                return Err(builder.content(place, fact, remedy));
            }
        };
        let count = self.stations.unwrap_or(self.points.len());
        self.check_count(place, builder, count)?;
        let end = |name: &String| Ok::<Mean, SceneError>(Mean::new(mesh, builder.region_with_nodes(place, name)?));
        let ends = by_ends.map(|(from, to)| Ok::<_, SceneError>((end(from)?, end(to)?))).transpose()?;
        let points: Vec<Vec3> = match &ends {
            Some((from, to)) => {
                let at = |k: usize| from.origin + (to.origin - from.origin) * (k as f64 / (count - 1) as f64);
                (1..count - 1).map(at).collect()
            }
            None => self.points.iter().map(|p| Vec3::new(p[0].0, p[1].0, p[2].0)).collect(),
        };
        let found: Vec<_> = points.iter().map(|at| embed(mesh, *at)).collect();
        let outside: Vec<String> = found
            .iter()
            .filter_map(|f| match f {
                Err(EmbedError::Outside { at, distance } | EmbedError::EmptyBall { at, distance, .. }) => {
                    Some(format!("{} by {:.4} mm", point(at), distance * 1e3))
                }
                Err(other) => Some(other.to_string()),
                Ok(_) => None,
            })
            .collect();
        if !outside.is_empty() {
            let fact = format!(
                "{} of {} stations are outside of the body: {}",
                outside.len(),
                points.len(),
                outside.join(", ")
            );
            return Err(builder.content(place, fact, "lead the line by `points` through the material, around hollows"));
        }
        let inner = points.iter().zip(found.into_iter().flatten()).map(|(at, e)| Mean::of_point(*at, e.weights));
        Ok(match ends {
            None => inner.collect(),
            Some((from, to)) => std::iter::once(from).chain(inner).chain([to]).collect(),
        })
    }
}

/// The line, and the frame in which its plane angles are measured.
struct Line {
    stations: Vec<Mean>,
    /// Number of intervals between stations in each segment
    each: usize,
    /// Tangent at the first station at rest, and the direction of the plane angle 0
    frame: [Vec3; 2],
}

/// Parameters of a segment.
struct Segment<T> {
    length: T,
    curvature: T,
    /// Plane angle \[rad\]
    plane: T,
    /// Mean square distance from the arc \[m²\]
    mean_square: T,
    /// Bend tan(θ/4)
    bend: f64,
}

/// Parameters of a segment with their rates.
type Moving = Segment<Dual<f64>>;

impl Segment<f64> {
    fn is_straight(&self) -> bool {
        self.bend < STRAIGHT
    }

    fn is_exact(&self) -> bool {
        self.mean_square.sqrt() < EXACT * self.length
    }
}

impl Line {
    fn points(&self, x: &[f64]) -> Vec<[f64; 3]> {
        self.stations.iter().map(|s| s.at(x).into()).collect()
    }

    fn arcs<T: Number>(&self, points: &[[T; 3]]) -> Vec<Arc<T>> {
        (0..points.len() - 1).step_by(self.each).map(|k| Arc::fit(&points[k..=k + self.each])).collect()
    }

    fn segments<T: Number>(&self, points: &[[T; 3]]) -> Vec<Segment<T>> {
        let mut frame = self.frame.map(|v| <[f64; 3]>::from(v).map(T::constant));
        let arcs = self.arcs(points).into_iter();
        let next = |arc: Arc<T>| {
            let [tangent, zero] = frame;
            let (plane, carried) = arc.carry(tangent, zero);
            frame = [carried.0, carried.1];
            let (length, curvature, mean_square) = (arc.length(), arc.curvature(), arc.mean_square);
            Segment { length, curvature, plane, mean_square, bend: arc.bend() }
        };
        arcs.map(next).collect()
    }

    /// Rates of the segments for every station and direction.
    fn rates(&self, x: &[f64]) -> Vec<[Vec<Moving>; 3]> {
        let points = self.points(x);
        let by = |station: usize, direction: usize| {
            let mut points: Vec<[Dual<f64>; 3]> = points.iter().map(|p| p.map(Dual::fixed)).collect();
            points[station][direction].rate = 1.0;
            self.segments(&points)
        };
        (0..points.len()).map(|station| [0, 1, 2].map(|direction| by(station, direction))).collect()
    }
}

struct Recorded {
    name: String,
    line: Line,
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        let name = &self.name;
        let segments = 1..=(self.line.stations.len() - 1) / self.line.each;
        let own = ["length_m", "curvature_per_m", "plane_deg", "residual_m"];
        let of_segment = |k: usize| own.map(|column| format!("{name}_{k}_{column}"));
        std::iter::once(format!("{name}_length_m")).chain(segments.flat_map(of_segment)).collect()
    }

    /// The plane angle of each segment \[deg\].
    fn memory(&self) -> Vec<f64> {
        vec![0.0; (self.line.stations.len() - 1) / self.line.each]
    }

    fn remember(&self, _: &Body, state: &State, memory: &mut [f64]) {
        for (own, segment) in memory.iter_mut().zip(self.line.segments(&self.line.points(&state.x))) {
            if !segment.is_straight() {
                let angle = segment.plane.to_degrees();
                *own = angle + 360.0 * ((*own - angle) / 360.0).round();
            }
        }
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        let segments = self.line.segments(&self.line.points(&now.state.x));
        let whole = segments.iter().map(|s| s.length).sum();
        let own = |(s, plane): (&Segment<f64>, &f64)| [s.length, s.curvature, *plane, s.mean_square.sqrt()];
        std::iter::once(whole).chain(segments.iter().zip(now.memory).flat_map(own)).collect()
    }

    /// The gradients. Curvature and plane angle have none where a segment is straight, and the residual has none where it is zero.
    fn gradients(&self, _: &Body, state: &State, _: &[f64]) -> Vec<Option<Gradient>> {
        let now = self.line.segments(&self.line.points(&state.x));
        let rates = self.line.rates(&state.x);
        let gradient = |of: &dyn Fn(&[Moving]) -> f64| {
            let along = |(station, rates): (&Mean, &[Vec<Moving>; 3])| {
                station.along(Vec3::from(std::array::from_fn(|i| of(&rates[i]))))
            };
            Gradient::of_displacements(self.line.stations.iter().zip(&rates).flat_map(along).collect())
        };
        let mut out = vec![Some(gradient(&|s| s.iter().map(|s| s.length.rate).sum()))];
        for (k, s) in now.iter().enumerate() {
            let (bent, off) = (!s.is_straight(), !s.is_exact());
            out.push(Some(gradient(&|s| s[k].length.rate)));
            out.push(bent.then(|| gradient(&|s| s[k].curvature.rate)));
            out.push(bent.then(|| gradient(&|s| s[k].plane.rate.to_degrees())));
            out.push(off.then(|| gradient(&|s| s[k].mean_square.sqrt().rate)));
        }
        out
    }

    fn is_differentiable(&self) -> bool {
        true
    }
}
