//! A marker of a rigid group that moves relative to the others between two rows: knocked out of place, slipped, or confused with another marker.
//!
//! Its step is far larger than the usual ones of the group and not small relative to the size of the group; before and after it, and for the other
//! markers, the steps are small. In a group of three, the deformation does not reveal a marker that leaves their plane: it looks like a different
//! rotation.

use super::track::Track;
use crate::math::statistics::median;
use crate::math::tensor::Vec3;
use std::fmt;

/// Smallest step of a knock relative to the median step of the group \[–\]
const FAR: f64 = 8.0;
/// Smallest step of a knock relative to the size of the group \[–\]
const LARGE: f64 = 0.01;
/// Share of a knock below which all other steps must be \[–\]
const PART: f64 = 0.2;

/// A step of one marker relative to the others.
#[derive(Clone, Debug, PartialEq)]
pub struct Knock {
    pub name: String,
    /// Time of the first row at the new position \[s\]
    pub time_s: f64,
    /// \[m\]
    pub step: f64,
}

impl fmt::Display for Knock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, time_s, step } = self;
        write!(
            f,
            "marker {name} jumps by {:.4} mm at {time_s} s and the others of its group do not: it was knocked or confused, and the motion of the body is wrong from there on; leave it out of the body, or cut the record",
            1e3 * step
        )
    }
}

/// All knocks of a group, in the order of its markers.
pub fn knocks(time_s: &[f64], group: &[&Track]) -> Vec<Knock> {
    let at = |track: &Track, k: usize| track.points[k].map(Vec3::from);
    let step = |track: &Track, [before, now]: [usize; 2]| Some((at(track, now)? - at(track, before)?).norm());
    let rows = |track: &Track| -> Vec<[usize; 2]> {
        let seen: Vec<usize> = (0..time_s.len()).filter(|k| track.points[*k].is_some()).collect();
        seen.windows(2).map(|w| [w[0], w[1]]).collect()
    };
    let usual = median(&group.iter().flat_map(|m| rows(m).into_iter().filter_map(|w| step(m, w))).collect::<Vec<_>>());
    let size = (0..time_s.len())
        .find_map(|k| group.iter().map(|m| at(m, k)).collect::<Option<Vec<Vec3>>>())
        .map_or(0.0, |all| all.iter().flat_map(|a| all.iter().map(move |b| (a - b).norm())).fold(0.0, f64::max));
    let of = |track: &&Track| {
        let rows = rows(track);
        let is_knock = |w: &&[[usize; 2]]| {
            let [before, now, after] = [0, 1, 2].map(|i| step(track, w[i]).unwrap_or(f64::INFINITY));
            let mut others = group.iter().filter(|m| m.name != track.name).filter_map(|m| step(m, w[1]));
            now > (FAR * usual).max(LARGE * size)
                && before.max(after) < PART * now
                && others.all(|step| step < PART * now)
        };
        let one = |w: &[[usize; 2]]| {
            let step = step(track, w[1])?;
            Some(Knock { name: track.name.clone(), time_s: time_s[w[1][1]], step })
        };
        rows.windows(3).filter(is_knock).filter_map(one).collect::<Vec<_>>()
    };
    group.iter().flat_map(of).collect()
}
