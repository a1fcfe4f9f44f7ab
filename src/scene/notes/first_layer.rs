//! Strains with which a run begins in the cells next to prescribed nodes only, and that its materials remember.

use crate::math::signal::Signal;
use crate::scene::build::builder::Builder;

/// Adds a note if the first stage is not static, prescribed displacements are not zero at its start while other nodes are at rest, and an effect remembers
/// strains.
pub(in crate::scene) fn note_first_layer(builder: &mut Builder, has_start: bool) {
    let (gathered, spans) = (&builder.gathered, &builder.spans);
    let remembering = [("viscoelastic", gathered.relaxing.is_empty()), ("mullins", gathered.softening.is_empty())];
    let remembering: Vec<&str> = remembering.iter().filter(|(_, none)| !none).map(|(name, _)| *name).collect();
    let begins_static = spans.first().is_none_or(|first| first.integrator.is_static());
    let moves_all = builder.held_dofs().count() >= 3 * builder.body.mesh.points.len();
    if remembering.is_empty() || begins_static || has_start || moves_all {
        return;
    }
    let is_moved = |signal: &Signal| !signal.has_inputs() && signal.at(0.0) != 0.0;
    if builder.held_dofs().any(|dof| builder.motion(dof as u32).is_some_and(is_moved)) {
        let note = format!(
            "stage 1 begins with prescribed displacements that are not zero, which deform only the cells next to them in the first state, and {} remembers that \
             strain: begin with a static stage, or with a ramp from zero",
            remembering.join(" or ")
        );
        builder.notes.push(note);
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::parse_scene;

    /// A displacement that is there at the start is noted where a law remembers its strain and the first stage moves the body, not otherwise.
    #[test]
    fn strains_of_the_first_state_are_told() {
        let noted = |law: &str, displacement: &str, integrator: &str| {
            let text = format!(
                "[mesh]\nelement = \"tet4\"\ngrid = {{ kind = \"box\", size = [\"4 mm\", \"1 mm\", \"1 mm\"], divisions = [4, 1, 1] }}\n\
                 [laws.rubber]\nlaw = \"neo_hookean_split\"\nE = \"100 kPa\"\nnu = 0.45\n\
                 [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n{law}\
                 [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n\
                 [[constraint]]\nkind = \"prescribed\"\nregion = \"xmax\"\ncomponents = \"x\"\ndisplacement = {displacement}\n\
                 [[stage]]\nintegrator = \"{integrator}\"\nduration = \"1 s\"\ndt = \"0.5 s\"\n"
            );
            let scene = parse_scene(&text).unwrap_or_else(|e| panic!("{e}"));
            scene.notes.iter().any(|note| note.starts_with("stage 1 begins with prescribed displacements"))
        };
        let relaxing = "[[effect]]\nkind = \"viscoelastic\"\nregion = \"body\"\nlaw = \"rubber\"\nmoduli = \"instantaneous\"\nprony = [{ g = 0.3, tau = \"1 s\" }]\n";
        let ramp = "{ kind = \"ramp\", from = \"0 mm\", to = \"1 mm\", end = \"1 s\" }";
        assert!(noted(relaxing, "\"1 mm\"", "implicit_euler"));
        assert!(!noted(relaxing, ramp, "implicit_euler") && !noted(relaxing, "\"1 mm\"", "static"));
        assert!(!noted("", "\"1 mm\"", "implicit_euler"));
    }
}
