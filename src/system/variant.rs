//! Variants of a system, with the same equations and other values, for residuals at other parameters. A variant shares numbering, pattern and slots
//! with the system, but lacks the effects that do not vary, so that its tangent has no meaning.

use super::{
    At, BlockValues, Blocks, Constraint, ConstraintKind, Effect, EnergyRole, EvalError, Prescribed, System,
    SystemError, Ties, Want,
};

/// Effects, constraints and prescribed motions of a system, before they are numbered.
pub struct SystemParts {
    pub nodes: usize,
    /// Host node of each scalar, as in [`System::with_scalars`]
    pub hosts: Vec<u32>,
    pub effects: Vec<Box<dyn Effect>>,
    pub constraints: Vec<Box<dyn Constraint>>,
    pub prescribed: Vec<Prescribed>,
    pub ties: Ties,
}

impl SystemParts {
    /// Builds the system.
    pub fn system(self) -> Result<System, SystemError> {
        let Self { nodes, hosts, effects, constraints, prescribed, ties } = self;
        System::tied(nodes, &hosts, effects, constraints, prescribed, ties)
    }

    /// Builds a system with the equations of `of`; effects for whose index `vary` is false are left out. The error names what differs between the two
    /// systems apart from values.
    pub fn variant(self, of: &System, vary: impl Fn(usize) -> bool) -> Result<System, SystemError> {
        let Self { nodes, hosts, effects, constraints, prescribed, ties } = self;
        let differ = |what: &str| Err(SystemError::Structure { what: what.into() });
        if 3 * nodes + hosts.len() != of.dofs.equation.len() {
            return differ("the numbers of unknowns");
        }
        if effects.len() != of.effects.len() || constraints.len() != of.constraints.len() {
            return differ("the numbers of effects or constraints");
        }
        if !prescribed.iter().map(|p| p.dof).eq(of.prescribed.iter().map(|p| p.dof)) {
            return differ("the prescribed degrees of freedom");
        }
        if !ties.nodes().eq(of.ties.nodes()) {
            return differ("the nodes of rigid parts");
        }
        let tied = effects.into_iter().map(|effect| ties.effect(effect));
        let mut kept: Vec<Box<dyn Effect>> = Vec::new();
        for (e, (effect, known)) in tied.zip(&of.effects).enumerate() {
            let size = |effect: &dyn Effect| effect.capabilities().history_size();
            let same = effect.name() == known.name() && size(&*effect) == size(&**known);
            if !same || effect.blocks() != known.blocks() {
                return differ(&format!("the blocks of the effect {}", known.name()));
            }
            kept.push(if vary(e) {
                effect
            } else {
                Box::new(Unvaried { role: effect.role(), blocks: Blocks::default() })
            });
        }
        let constraints: Vec<Box<dyn Constraint>> = constraints.into_iter().map(|c| ties.constraint(c)).collect();
        let of_one_kind = |a: ConstraintKind, b| std::mem::discriminant(&a) == std::mem::discriminant(&b);
        let all = constraints.iter().zip(&of.constraints);
        if let Some((_, known)) =
            all.into_iter().find(|(a, b)| !of_one_kind(a.kind(), b.kind()) || a.blocks() != b.blocks())
        {
            return differ(&format!("the segments of {}", known.name()));
        }
        Ok(System {
            slots: of.slots.clone(),
            effects: kept,
            constraints,
            prescribed,
            ties,
            dofs: of.dofs.clone(),
            pattern: of.pattern.clone(),
            largest: of.largest,
            histories: of.histories.clone(),
        })
    }
}

/// A placeholder for an effect that does not vary.
struct Unvaried {
    /// Role of that effect
    role: EnergyRole,
    blocks: Blocks,
}

impl Effect for Unvaried {
    fn name(&self) -> &str {
        "unvaried"
    }
    fn role(&self) -> EnergyRole {
        self.role
    }
    fn blocks(&self) -> &Blocks {
        &self.blocks
    }
    fn eval(&self, _: &At, _: usize, _: Want, _: &mut BlockValues) -> Result<(), EvalError> {
        Ok(())
    }
}
