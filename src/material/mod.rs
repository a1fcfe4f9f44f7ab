//! Constitutive laws: ψ(F) \[J/m³\], P = ∂ψ/∂F \[Pa\], A = ∂P/∂F \[Pa\].
//!
//! A law is one file that declares its description, its constants, an example and the form in which it is fitted, and one line of [`registry::LAWS`].
//! A law that is defined outside the library is added by [`register`] and checked by [`check::check_law`].

pub mod arruda_boyce;
mod assemble;
pub mod card;
pub mod check;
pub mod corotational;
pub mod draws;
pub mod entry;
pub mod fibre_family;
pub mod fit_form;
pub mod gent;
pub mod hyperfoam;
pub mod isochoric;
pub mod keywords;
pub mod kinematics;
pub mod law;
pub mod linear;
pub mod load_case;
pub mod material_stability;
pub mod moduli;
pub mod mooney_rivlin;
pub mod neo_hookean;
pub mod neo_hookean_split;
pub mod ogden;
pub mod parameter;
pub mod polar;
pub mod principal;
pub mod prony;
pub mod registry;
pub mod response;
mod schema;
pub mod sensitivity;
pub mod softening;
pub mod spectral;
pub mod split;
pub mod st_venant_kirchhoff;
pub mod stable_neo_hookean;
pub mod veronda_westmann;
pub mod volumetric;
pub mod yeoh;

pub use card::LawCard;
pub use check::{LawProperty, LawViolation, check_law};
pub use entry::LawEntry;
pub use fit_form::{FitForm, FitTerms, ShapedTerm};
pub use law::{Law, LawInfo};
pub use load_case::{Homogeneous, LoadCase, LoadCaseError};
pub use material_stability::{Instability, MaterialStability, StabilityLimit, material_stability};
pub use moduli::Moduli;
pub use parameter::{Choice, Chosen, LawSpecError, Parameter, Values};
pub use principal::PrincipalDerivatives;
pub use prony::{Arm, Constants, Prony, PronyError};
pub use registry::{KnownLaws, LAWS, find, law_from_table, laws, register, register_anew, title};
pub use response::{LaneResponse, LawError, Response, Want};
pub use schema::LawTable;
pub use sensitivity::derivative;
pub use softening::{Softened, Softening, SofteningError};
pub use volumetric::{Volumetric, VolumetricKind};
