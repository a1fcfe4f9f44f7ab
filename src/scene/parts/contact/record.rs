//! Record of a contact: the force on its points, the smallest distance, the number of points that press, and their area.

use crate::effect::contact::friction::ContactFriction;
use crate::effect::contact::placement::AffineFrame;
use crate::effect::contact::surfaces::Term;
use crate::effect::contact::surfaces::friction::SurfaceFriction;
use crate::effect::contact::surfaces::pressed::PressedSurfaces;
use crate::effect::contact::{Contact, Counts, NormalForces, SurfacePoint};
use crate::math::tensor::Vec3;
use crate::mesh::TetMesh;
use crate::scene::parts::contact::scales::ContactScales;
use crate::scene::parts::contact::spec::ResponseSpec;
use crate::scene::parts::contact::sunk::PressingFacets;
use crate::scene::record::recorder::{Moment, Recorder};
use crate::system::friction::HISTORY;
use crate::system::{At, BlockValues, Caches, Effect, State, Want};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// A contact of the system, as it is recorded.
pub struct NamedContact {
    pub name: String,
    pub response: ResponseSpec,
    pub scales: ContactScales,
    pub(in crate::scene) of: ContactSides,
    /// Range of its elastic slips in the history of a state; set once the system has been built
    pub(in crate::scene) history: Range<usize>,
}

/// The two sides of a contact.
pub(in crate::scene) enum ContactSides {
    /// Points of the body, an obstacle, and the facets between the points
    Points {
        pressing: Arc<dyn NormalForces>,
        moves: bool,
        friction: Option<Arc<ContactFriction>>,
        facets: PressingFacets,
    },
    /// Deformable surfaces
    Surfaces { pressing: Arc<PressedSurfaces>, friction: Option<Arc<SurfaceFriction>> },
}

/// Force of a point, relative to the largest force of a contact, below which the point does not press \[–\].
const PRESSES: f64 = 1e-9;
/// Cosine of the largest angle between the force on a point and the inward normal of a facet at which the facet faces the other side: 60° \[–\].
const FACING: f64 = 0.5;
/// Relative rounding of the sum of an area \[–\].
const ROUNDING: f64 = 1e-9;
/// Elastic slip of a point, relative to the largest one, from which it has 99 % of its friction \[–\].
const AT_LIMIT: f64 = 0.9;

/// State of a contact at one time, from which every column follows.
struct Sums {
    /// Force on the region \[N\]
    force: Vec3,
    /// Force without friction \[N\]
    normal: Vec3,
    /// Smallest distance, negative for penetration \[m\]: the column `gap_m`
    gap: f64,
    /// Number of points that press
    pressed: usize,
    /// Tributary area at rest of the points that press, on facets that face the other side \[m²\]
    area: f64,
}

/// A recorded value of a contact.
struct Column {
    end: &'static str,
    value: fn(&Sums) -> f64,
    /// Contacts that record the column
    of: Of,
}

/// Contacts that record a column.
#[derive(PartialEq, Eq)]
enum Of {
    All,
    /// Contacts of facets, which have an area
    Facets,
    /// Contacts with friction
    Sliding,
}

const fn column(end: &'static str, of: Of, value: fn(&Sums) -> f64) -> Column {
    Column { end, value, of }
}

/// All columns of a contact, in order.
const COLUMNS: [Column; 9] = [
    column("force_x_N", Of::All, |s| s.force.x),
    column("force_y_N", Of::All, |s| s.force.y),
    column("force_z_N", Of::All, |s| s.force.z),
    column("gap_m", Of::All, |s| s.gap),
    column("points", Of::All, |s| s.pressed as f64),
    column("area_m2", Of::Facets, |s| s.area),
    column("normal_x_N", Of::Sliding, |s| s.normal.x),
    column("normal_y_N", Of::Sliding, |s| s.normal.y),
    column("normal_z_N", Of::Sliding, |s| s.normal.z),
];

impl Recorder for NamedContact {
    fn columns(&self) -> Vec<String> {
        self.own_columns().map(|c| format!("{}_{}", self.name, c.end)).collect()
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        let sums = self.moment(&now.body.mesh, &now.state.x, now.step);
        self.own_columns().map(|c| (c.value)(&sums)).collect()
    }
}

impl NamedContact {
    fn own_columns(&self) -> impl Iterator<Item = &'static Column> {
        COLUMNS.iter().filter(|c| match c.of {
            Of::All => true,
            Of::Facets => !self.is_of_rigid_body(),
            Of::Sliding => self.slides(),
        })
    }

    /// Whether the points are those of a rigid body.
    fn is_of_rigid_body(&self) -> bool {
        matches!(&self.of, ContactSides::Points { facets, .. } if facets.is_none())
    }

    /// The points of the region.
    fn own_points(&self) -> &[SurfacePoint] {
        match &self.of {
            ContactSides::Points { pressing, .. } => &pressing.contact().points,
            ContactSides::Surfaces { pressing, .. } => &pressing.surfaces.first().points,
        }
    }

    /// The four nodes of an obstacle with a motion.
    pub(in crate::scene) fn moving(&self) -> Option<&AffineFrame> {
        match &self.of {
            ContactSides::Points { pressing, moves: true, .. } => pressing.contact().obstacle.body.as_ref(),
            _ => None,
        }
    }

    /// Whether the contact has friction.
    pub fn slides(&self) -> bool {
        match &self.of {
            ContactSides::Points { friction, .. } => friction.is_some(),
            ContactSides::Surfaces { friction, .. } => friction.is_some(),
        }
    }

    /// The number of points that press on an obstacle, if friction is at its limit at all of them.
    pub(in crate::scene) fn at_limit_of_friction(&self, state: &State) -> Option<usize> {
        let ContactSides::Points { pressing, friction: Some(_), .. } = &self.of else { return None };
        let slips = &state.history[self.history.clone()];
        let slip = |b: usize, number: usize| {
            Vec3::from_column_slice(&slips[HISTORY * (pressing.slips() * b + number)..][..HISTORY]).norm()
        };
        let of_point = |b: usize| pressing.normal_forces(&state.x, b).into_iter().map(move |press| (b, press));
        let presses: Vec<_> = (0..pressing.contact().points.len()).flat_map(of_point).collect();
        let least = PRESSES * presses.iter().map(|(_, press)| press.force).fold(0.0, f64::max);
        let pressed = presses.iter().filter(|(_, press)| press.force > least);
        let slips: Vec<f64> = pressed.map(|(b, press)| slip(*b, press.slip)).collect();
        (!slips.is_empty() && slips.iter().all(|slip| *slip > AT_LIMIT)).then_some(slips.len())
    }

    /// Whether a part of the region presses at displacement x and another part does not. Corners of tet10 have no area: whether they press can be due to
    /// rounding. The points of a rigid body are the same on every mesh.
    pub(in crate::scene) fn ends_within_region(&self, x: &[f64]) -> bool {
        if self.is_of_rigid_body() {
            return false;
        }
        let (forces, points) = (self.forces(x, None), self.own_points());
        let area: f64 = pressed(&forces).map(|f| points[f.0].area).sum();
        pressed(&forces).next().is_some() && area < (1.0 - ROUNDING) * points.iter().map(|p| p.area).sum::<f64>()
    }

    /// The points in contact with an obstacle; `None` for deformable surfaces.
    pub fn points(&self) -> Option<&Contact> {
        match &self.of {
            ContactSides::Points { pressing, .. } => Some(pressing.contact()),
            ContactSides::Surfaces { .. } => None,
        }
    }

    /// The position of the deepest point of the facets inside an obstacle at displacement x, and its depth \[m\]; `None` unless it is too much deeper than the
    /// contact points.
    pub(in crate::scene) fn sunken(&self, mesh: &TetMesh, x: &[f64]) -> Option<(Vec3, f64)> {
        match &self.of {
            ContactSides::Points { pressing, facets, .. } => facets.deepest(mesh, pressing.contact(), x),
            ContactSides::Surfaces { .. } => None,
        }
    }

    /// Whether the contact keeps the nodes apart, because all of them belong to its surfaces.
    pub(in crate::scene) fn keeps_apart(&self, mut nodes: impl Iterator<Item = u32>) -> bool {
        match &self.of {
            ContactSides::Points { .. } => false,
            ContactSides::Surfaces { pressing, .. } => nodes.all(|node| pressing.surfaces.have(node)),
        }
    }

    /// Number of contact points.
    pub fn point_count(&self) -> usize {
        match &self.of {
            ContactSides::Points { pressing, .. } => pressing.contact().points.len(),
            ContactSides::Surfaces { pressing, .. } => pressing.surfaces.point_count(),
        }
    }

    /// Counts of the run to which these caches belong.
    pub fn counts(&self, caches: &Caches) -> Counts {
        match &self.of {
            ContactSides::Points { pressing, .. } => pressing.contact().counts(caches),
            ContactSides::Surfaces { pressing, .. } => pressing.surfaces.counts(caches),
        }
    }

    /// The inputs of the friction, selected from those of the system.
    fn inputs<'a>(&self, at: &At<'a>) -> At<'a> {
        At { history: &at.history[self.history.clone()], ..*at }
    }

    /// Sums over the points of the region, with friction if a step led to the state. The forces of a surface on itself sum to 0.
    fn moment(&self, mesh: &TetMesh, x: &[f64], step: Option<&At>) -> Sums {
        let (forces, force) = self.sums(x, step);
        let gap = match &self.of {
            ContactSides::Points { pressing, .. } => pressing.contact().deepest(x).map_or(pressing.reach(), |d| d.1),
            ContactSides::Surfaces { pressing, .. } => pressing.surfaces.gap_between(x),
        };
        let (normals, normal) = if self.slides() { self.sums(x, None) } else { (forces.clone(), force) };
        let points = self.own_points();
        let faces = |f: u32, force: &Vec3| {
            let place = |k: u32| mesh.points[k as usize] + Vec3::from_column_slice(&x[3 * k as usize..][..3]);
            let [a, b, c] = [0, 1, 2].map(|k| place(mesh.facet(f as usize)[k]));
            let outward = (b - a).cross(&(c - a));
            -outward.dot(force) > FACING * outward.norm() * force.norm()
        };
        let area_of = |(b, force): &(usize, Vec3)| {
            points[*b].sides.iter().filter(|side| faces(side.0, force)).map(|side| side.1).sum::<f64>()
        };
        // An empty sum is −0.
        let area = pressed(&normals).map(area_of).sum::<f64>() + 0.0;
        Sums { force, normal, gap, pressed: pressed(&forces).count(), area }
    }

    /// The forces on the points of the region that are in contact, as (point, force \[N\]).
    pub fn forces(&self, x: &[f64], step: Option<&At>) -> Vec<(usize, Vec3)> {
        self.sums(x, step).0
    }

    /// The forces on the points of the region, and the resultant force on the region.
    fn sums(&self, x: &[f64], step: Option<&At>) -> (Vec<(usize, Vec3)>, Vec3) {
        let own = step.map(|at| self.inputs(at));
        let step = own.as_ref();
        match &self.of {
            ContactSides::Points { pressing, friction, .. } => {
                let forces = forces(&**pressing, friction.as_deref(), x, step);
                let sum = forces.iter().map(|f| f.1).sum();
                (forces, sum)
            }
            ContactSides::Surfaces { pressing, friction } => on_surface(pressing, friction.as_deref(), x, step),
        }
    }

    /// Adds the forces at the nodes \[N\] to `nodes` \[3 × nodes\].
    pub fn nodal(&self, x: &[f64], step: Option<&At>, nodes: &mut [f64]) {
        let own = step.map(|at| self.inputs(at));
        let step = own.as_ref();
        match &self.of {
            ContactSides::Points { pressing, friction, .. } => {
                for (b, force) in forces(&**pressing, friction.as_deref(), x, step) {
                    let p = &pressing.contact().points[b];
                    for (&node, w) in p.nodes.iter().zip(&p.weights) {
                        // Nodes of a rigid body are not in the mesh.
                        let of_mesh = nodes.get_mut(3 * node as usize..3 * node as usize + 3).into_iter().flatten();
                        of_mesh.zip(force.iter()).for_each(|(sum, f)| *sum += w * f);
                    }
                }
            }
            ContactSides::Surfaces { pressing, friction } => {
                each_term(pressing, friction.as_deref(), x, step, |term, r| {
                    for (&node, r) in term.distance.nodes.iter().zip(r.chunks_exact(3)) {
                        let to = &mut nodes[3 * node as usize..3 * node as usize + 3];
                        to.iter_mut().zip(r).for_each(|(sum, r)| *sum -= r);
                    }
                })
            }
        }
    }
}

/// The points that press, from (point, force \[N\]).
fn pressed(forces: &[(usize, Vec3)]) -> impl Iterator<Item = &(usize, Vec3)> {
    let least = PRESSES * forces.iter().map(|f| f.1.norm()).fold(0.0, f64::max);
    forces.iter().filter(move |f| f.1.norm() > least)
}

/// The forces on the points on which the obstacle acts, as (point, force \[N\]).
fn forces(
    pressing: &dyn NormalForces,
    friction: Option<&ContactFriction>,
    x: &[f64],
    step: Option<&At>,
) -> Vec<(usize, Vec3)> {
    let contact = pressing.contact();
    let mut local = BlockValues::new(contact.blocks().largest());
    let mut force = |b: usize| {
        let presses = pressing.normal_forces(x, b);
        let mut sum: Vec3 = presses.iter().map(|p| p.normal * p.force).sum();
        if let (Some(friction), Some(at)) = (friction, step) {
            local.r.fill(0.0);
            friction.eval(at, b, Want::Residual, &mut local).expect("friction is defined wherever contact is");
            sum -= local.r[..3 * contact.own()].chunks_exact(3).map(Vec3::from_column_slice).sum::<Vec3>();
        }
        (b, sum)
    };
    let near: Vec<u32> = match pressing.reach() {
        f64::INFINITY => (0..contact.points.len() as u32).collect(),
        reach => contact.near(x, reach, &mut Caches::default()),
    };
    near.into_iter().map(|b| force(b as usize)).filter(|(_, f)| *f != Vec3::zeros()).collect()
}

/// Calls `take` with every term and its residual r, with friction if a step led to this state.
fn each_term(
    pressing: &PressedSurfaces,
    friction: Option<&SurfaceFriction>,
    x: &[f64],
    step: Option<&At>,
    mut take: impl FnMut(&Term, &[f64]),
) {
    for term in pressing.surfaces.terms(x, &mut Caches::default()).iter() {
        let mut local = BlockValues::new(3 * term.distance.nodes.len());
        pressing.add(x, term, Want::Residual, &mut local).expect("no accepted state has surfaces that cross");
        if let (Some(friction), Some(at)) = (friction, step) {
            friction.add(at, term, Want::Residual, &mut local);
        }
        take(term, &local.r);
    }
}

/// The forces on the points of the first surface, as (point, force \[N\]), and the resultant force on it.
fn on_surface(
    pressing: &PressedSurfaces,
    friction: Option<&SurfaceFriction>,
    x: &[f64],
    step: Option<&At>,
) -> (Vec<(usize, Vec3)>, Vec3) {
    let surfaces = &pressing.surfaces;
    let own = surfaces.first().points.first().map_or(0, |p| p.nodes.len());
    let (mut forces, mut all) = (BTreeMap::<usize, Vec3>::new(), Vec3::zeros());
    each_term(pressing, friction, x, step, |term, r| {
        let sum = |r: &[f64]| -r.chunks_exact(3).map(Vec3::from_column_slice).sum::<Vec3>();
        match term.point {
            _ if surfaces.is_self_contact() => all += sum(r),
            None => all += sum(&r[..6]),
            Some((0, _)) => all += sum(&r[..3 * own]),
            // The force on a point of the other surface acts on the first with the opposite sign.
            Some(_) => all -= sum(&r[..3 * own]),
        }
        if let Some((0, point)) = term.point {
            *forces.entry(point as usize).or_default() += sum(&r[..3 * own]);
        }
    });
    (forces.into_iter().filter(|f| f.1 != Vec3::zeros()).collect(), all)
}

#[cfg(test)]
mod tests {
    use crate::scene::parse_scene;

    /// A contact ends within its region if only some nodes of the face press, and not if all of them do; nor do the lower corners of a rigid brick end it,
    /// which are the same on every mesh.
    #[test]
    fn a_contact_ends_within_facets_of_the_mesh() {
        let floor = "obstacle = { kind = \"floor\", point = [\"0 mm\", \"0 mm\", \"-1 mm\"], normal = [0, 0, 1] }\nresponse = \"penalty\"\nfriction = 0\n";
        let text = format!(
            "[mesh]\nelement = \"tet4\"\ngrid = {{ kind = \"box\", size = [\"20 mm\", \"10 mm\", \"10 mm\"], divisions = [2, 1, 1] }}\n\
             [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.3\n[[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
             formulation = \"displacement\"\n[[effect]]\nkind = \"inertia\"\nregion = \"body\"\ndensity = \"1000 kg/m^3\"\nmass = \"lumped\"\n\
             [[rigid]]\nname = \"brick\"\nshape = {{ kind = \"box\", min = [\"40 mm\", \"0 mm\", \"0 mm\"], max = [\"50 mm\", \"10 mm\", \"10 mm\"] }}\n\
             density = \"1000 kg/m^3\"\n[[contact]]\nname = \"face\"\nregion = \"zmin\"\n{floor}[[contact]]\nname = \"corners\"\nregion = \"brick\"\n{floor}\
             [[stage]]\nintegrator = \"bdf2\"\nduration = \"1 s\"\ndt = \"0.1 s\"\n"
        );
        let scene = parse_scene(&text).unwrap_or_else(|e| panic!("{e}"));
        let ends = |reach: f64| {
            let mut x = scene.start().x;
            let lower = scene.points.iter().enumerate().filter(|(_, p)| p.x < reach || p.x > 0.025);
            lower.for_each(|(k, _)| x[3 * k + 2] -= 2e-3);
            assert!(scene.contacts[1].moment(&scene.body.mesh, &x, None).pressed > 0, "the brick is on the floor");
            scene.contacts.iter().map(|contact| contact.ends_within_region(&x)).collect::<Vec<_>>()
        };
        assert_eq!((ends(0.0), ends(0.005), ends(0.021)), (vec![false; 2], vec![true, false], vec![false; 2]));
    }
}
