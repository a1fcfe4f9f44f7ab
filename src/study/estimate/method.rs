//! Methods of finding the limit of a family, with their wording in files and reports.

use crate::study::estimate::richardson::PAIR_FACTOR;
use serde::{Serialize, Serializer};
use std::fmt;

/// Method of finding a limit.
#[derive(Clone, Debug, PartialEq)]
pub enum Method {
    /// The value that all meshes share
    Independent,
    /// The value of the finest mesh, with the differences of the meshes as its uncertainty
    Spread,
    /// Richardson extrapolation over three meshes
    Richardson,
    /// Richardson extrapolation over two meshes with an assumed order p
    TwoMeshes { p: f64 },
    /// A model fitted by least squares to four or more meshes
    LeastSquares { model: String, weighted: bool },
}

impl Method {
    /// Whether the limit is extrapolated with an order of convergence.
    pub fn is_extrapolation(&self) -> bool {
        !matches!(self, Self::Independent | Self::Spread)
    }

    /// Describes how the limit is found, with its source as `[@key]`.
    pub fn cited(&self) -> &'static str {
        match self {
            Self::Independent => "the value that all meshes share",
            Self::Spread => "the value of the finest mesh",
            Self::Richardson => "Richardson extrapolation over three meshes [@celik2008]",
            Self::TwoMeshes { .. } => "Richardson extrapolation over two meshes with an assumed order [@roache1994]",
            Self::LeastSquares { .. } => "least squares over four and more meshes [@eca2014]",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Independent => f.write_str("independent of the mesh"),
            Self::Spread => f.write_str("spread (3·ΔM)"),
            Self::Richardson => f.write_str("Richardson and GCI"),
            Self::TwoMeshes { p } => {
                write!(f, "two meshes, p = {p:.0} assumed, GCI of first order with Fs = {PAIR_FACTOR:.0}")
            }
            Self::LeastSquares { model, weighted } => {
                write!(f, "least squares {model}{}", if *weighted { ", weighted" } else { "" })
            }
        }
    }
}

impl Serialize for Method {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
