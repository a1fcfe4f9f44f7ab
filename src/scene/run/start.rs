//! Initial states other than rest: states that test robustness, and crumpled bodies.
//!
//! Nodes that are held or prescribed remain where their signals put them at t = 0. Nothing moves at the start except by `moving`, by the velocities of rigid
//! bodies, and, before a dynamic stage, by the signals.

use crate::math::random::SplitMix;
use crate::math::signal::Clock;
use crate::math::tensor::Vec3;
use crate::mesh::{Region, TetMesh};
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::text::quantity::{Angle, Length, Speed};
use crate::system::{EnergyRole, State, System};
use nalgebra::{Rotation3, Unit};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// `[start]`: `random`, `collapsed`, `twisted` or `moving`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(tag = "kind", transform = crate::schema::kind_alone)]
pub enum StartSpec {
    /// Every node at a random position in the cube of this half-width around the centre of the body
    Random {
        /// Half-width of the cube
        size: Length,
        /// Seed of the random numbers
        #[serde(default)]
        seed: u64,
    },
    /// Every node at the centre of the body, except for the components that it keeps, and off it by up to `perturbation` in each direction: exactly collapsed
    /// cells have no direction in which to unfold
    Collapsed {
        /// Components that keep their coordinate, such as `"xy"`
        #[serde(default)]
        keep: String,
        /// Largest distance from the centre in each direction
        perturbation: Length,
        /// Seed of the random numbers
        #[serde(default)]
        seed: u64,
    },
    /// The body twisted about an axis through its centre, from 0 at the lower end to `angle` at the upper end
    Twisted {
        /// Direction of the axis, whose length does not matter; if absent, the one of x, y and z in which the body is longest
        axis: Option<[f64; 3]>,
        /// Angle at the upper end
        angle: Angle,
    },
    /// The body in its place, with this velocity; only a region of the mesh, if one is given
    Moving {
        /// Region that moves; the whole body if absent
        region: Option<String>,
        /// Velocity at the start
        velocity: [Speed; 3],
    },
}

/// Refuses a start from which no run can proceed.
pub(in crate::scene) fn check_start(builder: &Builder, start: Option<&StartSpec>) -> Result<(), SceneError> {
    let place = "start";
    match start {
        Some(StartSpec::Random { size, .. }) if size.0 <= 0.0 => {
            let fact = format!("size = {} mm", size.0 * 1e3);
            return Err(builder.content(place, fact, "give a positive length, for example that of the body"));
        }
        Some(StartSpec::Collapsed { keep, perturbation, .. }) => {
            if !keep.chars().all(|c| "xyz".contains(c)) || keep.len() > 2 {
                let fact = format!("keep = \"{keep}\"");
                return Err(builder.content(
                    place,
                    fact,
                    "write \"\" for a point, \"x\" for a line, \"xy\" for a plane",
                ));
            }
            if perturbation.0 <= 0.0 {
                let fact = format!("perturbation = {} mm", perturbation.0 * 1e3);
                let remedy = "give a positive length: exactly collapsed cells have no direction to come back in";
                return Err(builder.content(place, fact, remedy));
            }
        }
        Some(StartSpec::Twisted { axis: Some(axis), .. }) if Vec3::from(*axis).norm() == 0.0 => {
            return Err(builder.content(place, "the axis has no length", "write for example [1, 0, 0]"));
        }
        Some(StartSpec::Moving { region, .. }) => {
            if let Some(name) = region {
                builder.region(place, name)?;
            }
            check_motion(builder)?;
        }
        _ => {}
    }
    let inverts = matches!(start, Some(StartSpec::Random { .. } | StartSpec::Collapsed { .. }));
    let mut laws = builder.gathered.laws.iter().map(|l| &l.law);
    if let Some(law) = laws.find(|law| inverts && !law.info().survives_inversion) {
        let fact = format!("the start inverts cells, where the law {} is not defined", law.info().name);
        return Err(builder.content(place, fact, "take stable_neo_hookean"));
    }
    Ok(())
}

/// Refuses a velocity that is not kept: static stages and bodies without mass have none.
fn check_motion(builder: &Builder) -> Result<(), SceneError> {
    if builder.spans.first().is_some_and(|first| first.integrator.is_static()) {
        let fact = "a velocity at the start of stage 1 (static), which begins without one";
        return Err(builder.content("start", fact, "let the first stage be dynamic, or remove [start]"));
    }
    if builder.effects.iter().all(|effect| effect.role() != EnergyRole::Kinetic) {
        let fact = "a velocity where nothing has mass, which no step keeps";
        return Err(builder.content("start", fact, "add an [[effect]] of kind \"inertia\", or remove [start]"));
    }
    Ok(())
}

/// Moves a system on a mesh with these regions from rest to its initial state.
pub(super) fn set_start(
    start: &StartSpec,
    (mesh, regions): (&TetMesh, &BTreeMap<String, Region>),
    system: &System,
    state: &mut State,
) {
    let points = &mesh.points;
    let (low, high) = mesh.bounding_box();
    let middle = 0.5 * (low + high);
    let moving = match start {
        StartSpec::Moving { region: Some(name), .. } => regions.get(name),
        _ => None,
    };
    let moving = moving.map(|region| mesh.nodes_of(region));
    let seed = match start {
        StartSpec::Random { seed, .. } | StartSpec::Collapsed { seed, .. } => *seed,
        StartSpec::Twisted { .. } | StartSpec::Moving { .. } => 0,
    };
    let mut random = SplitMix(seed);
    let mut around = |size: f64| Vec3::from_fn(|_, _| size * (2.0 * random.unit() - 1.0));
    for (k, p) in points.iter().enumerate() {
        if let StartSpec::Moving { velocity, .. } = start
            && moving.as_ref().is_none_or(|list| list.binary_search(&(k as u32)).is_ok())
        {
            (0..3).for_each(|i| state.v[3 * k + i] = velocity[i].0);
        }
        let place = match start {
            StartSpec::Moving { .. } => *p,
            StartSpec::Random { size, .. } => middle + around(size.0),
            StartSpec::Collapsed { keep, perturbation, .. } => {
                let kept = |i: usize| keep.contains(["x", "y", "z"][i]);
                Vec3::from_fn(|i, _| if kept(i) { p[i] } else { middle[i] }) + around(perturbation.0)
            }
            StartSpec::Twisted { axis, angle } => {
                let axis = axis.map_or_else(|| Vec3::ith((high - low).imax(), 1.0), Vec3::from);
                let axis = Unit::new_normalize(axis);
                let heights = points.iter().map(|p| p.dot(&axis));
                let (least, most) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), h| (l.min(h), m.max(h)));
                let share = (p.dot(&axis) - least) / (most - least);
                middle + Rotation3::from_axis_angle(&axis, angle.0 * share) * (p - middle)
            }
        };
        state.x[3 * k..3 * k + 3].copy_from_slice((place - p).as_slice());
    }
    place(system, state);
}

/// Puts nodes that are held or prescribed at the positions given by their signals, at rest.
fn place(system: &System, state: &mut State) {
    for p in &system.prescribed {
        state.x[p.dof as usize] = p.signal.at(Clock { t: state.t, inputs: &state.inputs });
        state.v[p.dof as usize] = 0.0;
    }
    system.ties.complete(&mut state.x);
}

/// Puts held and prescribed nodes at the positions given by their signals and, if anything has mass, gives them the velocities of their signals. Without mass
/// no step keeps a velocity, and a velocity of the prescribed nodes alone would only mislead the prediction of the next step.
pub(super) fn place_in_motion(system: &System, state: &mut State) {
    place(system, state);
    if !system.has_mass() {
        return;
    }
    for p in &system.prescribed {
        state.v[p.dof as usize] = p.signal.rate(Clock { t: state.t, inputs: &state.inputs });
    }
    system.ties.complete(&mut state.v);
}
