//! Facts about a scene and its run that limit the conclusions from its numbers.

pub(super) mod beyond_data;
pub(super) mod collapse;
pub(super) mod cut_regions;
pub(super) mod feedback;
pub(super) mod first_layer;
pub(super) mod friction;
pub(super) mod implausible;
pub(super) mod jump;
pub(super) mod mesh_limits;
pub(super) mod stable;
pub(super) mod sunk;
pub(super) mod unheld;
pub(super) mod volumes;
pub(super) mod wrinkles;
