//! The points of the elastic effects of a scene at which fields and forces are evaluated.

use crate::effect::{Constitution, cofactor_by_rows};
use crate::material::volumetric::Volumetric;
use crate::material::{Law, LawCard, Prony, Want};
use crate::math::tensor::{Mat3, det_minus_one, rows};
use crate::reduction::error::ReductionError;
use crate::reduction::points::parted_law::parted;
use crate::reduction::points::rate_points::StoredRates;
use crate::scene::Scene;
use crate::scene::spec::EffectSpec;
use std::collections::BTreeMap;

/// All points of the elastic effects, part by part, block by block.
pub struct BodyPoints<'a> {
    pub parts: Vec<ElasticPoints<'a>>,
}

/// The points of one elastic effect.
pub struct ElasticPoints<'a> {
    pub constitution: Constitution<'a>,
    /// The law without the volumetric part that a pressure field replaces
    law: Box<dyn Law>,
    volumetric: Option<Volumetric>,
    /// The distinct rate-dependent forces of its cells
    pub rates: Vec<StoredRates>,
    /// \[blocks\] index into `rates`
    of_blocks: Vec<usize>,
}

/// A point: its part, its block in the part, and its index in the block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    pub part: usize,
    pub block: usize,
    pub point: usize,
}

/// P row by row \[Pa\], and G(J) if there is a pressure field \[–\].
pub type PointForce = ([f64; 9], f64);

impl<'a> ElasticPoints<'a> {
    fn of(
        constitution: Constitution<'a>,
        rates: Vec<StoredRates>,
        of_blocks: Vec<usize>,
    ) -> Result<Self, ReductionError> {
        let (law, volumetric) = parted(constitution.law.build()?, constitution.pressure.is_some());
        Ok(Self { constitution, law, volumetric, rates, of_blocks })
    }

    /// Returns the bulk modulus of the part of the law that a pressure field replaces \[Pa\].
    pub fn bulk_modulus(&self) -> Option<f64> {
        self.volumetric.map(|volumetric| volumetric.kappa)
    }
}

impl<'a> BodyPoints<'a> {
    /// Collects the points of a scene; an error if the forces of an elastic effect depend on more than single points.
    pub fn of(scene: &'a Scene) -> Result<Self, ReductionError> {
        let law = |effect: &'a EffectSpec| match effect {
            EffectSpec::Elastic(solid) => Some(solid.law.as_str()),
            _ => None,
        };
        let mut left = RatesOfCells::of(scene);
        let part = |(stressed, law): (&'a std::sync::Arc<dyn crate::effect::Stressed>, &str)| {
            let constitution = stressed.constitution().ok_or_else(|| ReductionError::Unsupported {
                what: "an elastic effect".into(),
                why: "its forces depend on means over cells".into(),
                remedy: "take formulation = \"mixed\" or \"displacement\"".into(),
            })?;
            let (rates, of_blocks) = left.take(law, &constitution.points.cells);
            ElasticPoints::of(constitution, rates, of_blocks)
        };
        let laws = scene.spec.effects.iter().filter_map(law);
        Ok(Self { parts: scene.stressed.iter().zip(laws).map(part).collect::<Result<_, ReductionError>>()? })
    }

    /// Returns the indices of all points.
    pub fn places(&self) -> impl Iterator<Item = Place> + '_ {
        self.parts.iter().enumerate().flat_map(|(part, of)| {
            let points = of.constitution.points.points();
            let blocks = of.constitution.points.cells.len();
            (0..blocks).flat_map(move |block| (0..points).map(move |point| Place { part, block, point }))
        })
    }

    /// Returns the part of a point, and the index of its rate-dependent forces.
    pub fn kind(&self, at: &Place) -> (usize, usize) {
        (at.part, self.parts[at.part].of_blocks[at.block])
    }

    /// Returns all pairs of a part and an index of its rate-dependent forces.
    pub fn kinds(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.parts.iter().enumerate().flat_map(|(k, part)| (0..part.rates.len()).map(move |kind| (k, kind)))
    }

    /// Returns w det ∂X/∂ξ of each point \[m³\].
    pub fn weights(&self) -> Vec<f64> {
        self.places().map(|at| self.parts[at.part].constitution.points.weight(at.block, at.point)).collect()
    }

    /// Returns ∂u/∂X row by row at each point, for a field \[unknowns\].
    pub fn gradients(&self, field: &[f64]) -> Vec<[f64; 9]> {
        let at = |at: Place| {
            let f = self.parts[at.part].constitution.points.deformation_gradient(field, at.block, at.point);
            rows(&(f - Mat3::identity()))
        };
        self.places().map(at).collect()
    }

    /// Returns p \[Pa\] at each point, for a field \[unknowns\]; zero without a pressure field.
    pub fn pressures(&self, field: &[f64]) -> Vec<f64> {
        let at = |at: Place| {
            let constitution = &self.parts[at.part].constitution;
            constitution.pressure.map_or(0.0, |pressure| {
                let scalars = constitution.blocks.scalars(at.block).iter();
                let sum: f64 = scalars.zip(&pressure.shape[at.point]).map(|(&k, n)| n * field[k as usize]).sum();
                pressure.scale * sum
            })
        };
        self.places().map(at).collect()
    }

    /// Whether any part has a pressure field.
    pub fn has_pressure(&self) -> bool {
        self.parts.iter().any(|part| part.volumetric.is_some())
    }

    /// Returns aᵀ C b of two pressure fields \[unknowns\], with the compliance C of all parts.
    pub fn compliance(&self, a: &[f64], b: &[f64]) -> f64 {
        (0..self.parts.len()).map(|part| self.compliance_of(part, a, b)).sum()
    }

    /// Returns aᵀ C b of two pressure fields \[unknowns\], with the compliance C of one part.
    pub fn compliance_of(&self, part: usize, a: &[f64], b: &[f64]) -> f64 {
        let of_part = |part: &ElasticPoints| {
            let Constitution { blocks, pressure, .. } = &part.constitution;
            let Some(pressure) = pressure else { return 0.0 };
            let of_block = |(block, c): (usize, &[[f64; 4]; 4])| {
                let scalars = blocks.scalars(block);
                let at = |field: &[f64], k: usize| field[scalars[k] as usize];
                let row = |k: usize| (0..4).map(|l| c[k][l] * at(b, l)).sum::<f64>();
                (0..4).map(|k| at(a, k) * row(k)).sum::<f64>()
            };
            pressure.compliance.iter().enumerate().map(of_block).sum::<f64>()
        };
        of_part(&self.parts[part])
    }

    /// Returns these points with other laws, each given with the index of its part.
    pub fn with_laws(&self, cards: &[(usize, LawCard)]) -> Result<Self, ReductionError> {
        let part = |(k, of): (usize, &ElasticPoints<'a>)| {
            let law = cards.iter().find(|(part, _)| *part == k).map_or(&of.constitution.law, |(_, card)| card);
            ElasticPoints::of(
                Constitution { law: law.clone(), ..of.constitution },
                of.rates.clone(),
                of.of_blocks.clone(),
            )
        };
        Ok(Self { parts: self.parts.iter().enumerate().map(part).collect::<Result<_, ReductionError>>()? })
    }

    /// Converts a field of `other`, the points of the same body with other laws, to the unit of pressure of these points.
    pub fn rescaled(&self, other: &BodyPoints, field: &[f64]) -> Vec<f64> {
        let mut out = field.to_vec();
        for (own, other) in self.parts.iter().zip(&other.parts) {
            let (Some(to), Some(from)) = (own.constitution.pressure, other.constitution.pressure) else { continue };
            for block in 0..own.constitution.points.cells.len() {
                for &k in own.constitution.blocks.scalars(block) {
                    out[k as usize] = field[k as usize] * (from.scale / to.scale);
                }
            }
        }
        out
    }

    /// Returns P and G(J) at a point from ∂u/∂X and the pressure there.
    pub fn force(&self, part: usize, gradient: &[f64; 9], pressure: f64) -> Result<PointForce, ReductionError> {
        let ElasticPoints { law, volumetric, .. } = &self.parts[part];
        let undefined = |e: crate::material::LawError| ReductionError::Law(e.to_string());
        let h = Mat3::from_row_slice(gradient);
        let f = h + Mat3::identity();
        let response = law.eval(&f, Want::Residual).map_err(undefined)?;
        let mut p = rows(&response.p);
        let Some(volumetric) = volumetric else { return Ok((p, 0.0)) };
        let (g, dg, _) = volumetric.gap(det_minus_one(&h)).map_err(undefined)?;
        p.iter_mut().zip(cofactor_by_rows(&rows(&f))).for_each(|(p, cof): (&mut f64, f64)| *p += pressure * dg * cof);
        Ok((p, g))
    }
}

/// Rate-dependent forces of the cells that are not yet assigned to a part: where the laws of several parts add up, they act once.
struct RatesOfCells<'a> {
    /// η \[Pa s\]
    viscous: BTreeMap<u32, f64>,
    /// Name of the law that relaxes, and its Prony series
    relaxing: BTreeMap<u32, (&'a str, &'a Prony)>,
}

impl<'a> RatesOfCells<'a> {
    fn of(scene: &'a Scene) -> Self {
        let mut all = Self { viscous: BTreeMap::new(), relaxing: BTreeMap::new() };
        for effect in &scene.viscous {
            effect.cells().iter().for_each(|&c| *all.viscous.entry(c).or_default() += effect.eta());
        }
        let laws = scene.spec.effects.iter().filter_map(|effect| match effect {
            EffectSpec::Viscoelastic(relaxing) => Some(relaxing.law.as_str()),
            _ => None,
        });
        for (effect, law) in scene.relaxing.iter().zip(laws) {
            all.relaxing.extend(effect.cells().iter().map(|&c| (c, (law, effect.prony()))));
        }
        all
    }

    /// Takes the rate-dependent forces of a part with the law of this name, on these cells: returns the distinct ones, in the order of the cells, and
    /// the index of those of each cell.
    fn take(&mut self, law: &str, cells: &[u32]) -> (Vec<StoredRates>, Vec<usize>) {
        let mut all = vec![];
        let of_blocks = cells.iter().map(|c| {
            let relaxes = self.relaxing.get(c).is_some_and(|(other, _)| *other == law);
            let series = if relaxes { self.relaxing.remove(c) } else { None };
            let own = StoredRates {
                viscosity: self.viscous.remove(c).unwrap_or_default(),
                relaxation: series.map(|(_, prony)| prony.clone()),
            };
            all.iter().position(|other| *other == own).unwrap_or_else(|| {
                all.push(own);
                all.len() - 1
            })
        });
        let of_blocks = of_blocks.collect();
        (all, of_blocks)
    }
}
