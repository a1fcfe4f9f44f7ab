//! Scenes at random: whatever the effects, laws, meshes, loads and steps, a scene is refused or run to a stated end; every number
//! that was recorded is finite, and nothing panics or hangs.
//!
//! A few hundred scenes are drawn here; `PROPTEST_CASES=10000 cargo test --release --test solver random_scenes::` draws more.

use durometer::scene::{Body, Scene, read_scene};
use durometer::solve::Status;
use proptest::prelude::*;
use std::fmt::Write;
use std::time::Duration;

/// What is drawn; the text of the scene follows from it.
#[derive(Clone, Debug)]
struct Drawn {
    divisions: [usize; 3],
    quadratic: bool,
    disturbed: f64,
    law: usize,
    nu: f64,
    formulation: usize,
    integrator: usize,
    load: usize,
    size: f64,
    dt: f64,
    held: usize,
    start: usize,
    damped: bool,
    numerics: usize,
}

fn drawn() -> impl Strategy<Value = Drawn> {
    let mesh = ([1usize..3, 1usize..3, 1usize..3], any::<bool>(), 0.0..0.3);
    // Most of the combinations that are always refused are drawn seldom
    let formulation = prop_oneof![6 => Just(0usize), 1 => Just(1usize), 1 => Just(2usize)];
    let start = prop_oneof![8 => Just(0usize), 2 => Just(1usize), 1 => Just(2usize), 1 => Just(3usize)];
    let law =
        (0usize..7, prop_oneof![8 => 0.0..0.499, 2 => Just(0.4999), 1 => Just(0.5), 1 => Just(-0.5)], formulation);
    let run = (0usize..6, 0usize..7, -3.0..3.0, -4.0..0.5);
    let rest = (0usize..4, start, any::<bool>(), 0usize..4);
    (mesh, law, run, rest).prop_map(|((divisions, quadratic, disturbed), (law, nu, formulation), run, rest)| {
        let ((integrator, load, size, dt), (held, start, damped, numerics)) = (run, rest);
        let size = 10f64.powf(size);
        let dt = 10f64.powf(dt);
        Drawn {
            divisions,
            quadratic,
            disturbed,
            law,
            nu,
            formulation,
            integrator,
            load,
            size,
            dt,
            held,
            start,
            damped,
            numerics,
        }
    })
}

impl Drawn {
    /// The table of the load.
    fn load(&self) -> String {
        let ramp = |top: f64, unit: &str| {
            format!("{{ kind = \"ramp\", from = \"0 {unit}\", to = \"{} {unit}\", end = \"1 s\" }}", top * self.size)
        };
        match self.load {
            0 => format!(
                "[[effect]]\nkind = \"gravity\"\nregion = \"body\"\ndensity = \"1000 kg/m^3\"\ndirection = [1, 0, -1]\nacceleration = {}",
                ramp(9.81, "m/s^2")
            ),
            1 => format!(
                "[[effect]]\nkind = \"traction\"\nregion = \"xmax\"\ndirection = [-1, 0, 0.1]\ntraction = {}",
                ramp(5.0, "kPa")
            ),
            2 => format!(
                "[[constraint]]\nkind = \"prescribed\"\nregion = \"xmax\"\ncomponents = \"xz\"\ndisplacement = {}",
                ramp(-5.0, "mm")
            ),
            3 | 4 => format!(
                "[[constraint]]\nkind = \"cable\"\npull_point = [\"-10 mm\", \"10 mm\", \"5 mm\"]\nguides = [[\"15 mm\", \"10 mm\", \"5 mm\"], \
                 [\"35 mm\", \"10 mm\", \"5 mm\"]]\nguide_radius = \"6 mm\"\nfriction = {}\ndrive = {{ kind = \"{}\", signal = {} }}",
                0.1 * (self.held % 2) as f64,
                if self.load == 3 { "length" } else { "tension" },
                if self.load == 3 { ramp(5.0, "mm") } else { ramp(0.5, "N") }
            ),
            5 => format!(
                "[[constraint]]\nkind = \"cavity\"\nregion = \"zmax\"\nopen = true\ndrive = {{ kind = \"pressure\", signal = {} }}",
                ramp(2.0, "kPa")
            ),
            _ => format!(
                "[[effect]]\nkind = \"point_force\"\npoint = [\"39 mm\", \"10 mm\", \"10 mm\"]\nradius = \"6 mm\"\ndirection = [0, 0, 1]\nforce = {}",
                ramp(0.2, "N")
            ),
        }
    }

    fn text(&self) -> String {
        let mut t = String::new();
        let [a, b, c] = self.divisions;
        let element = if self.quadratic { "tet10" } else { "tet4" };
        writeln!(
            t,
            "[mesh]\ngrid = {{ kind = \"box\", size = [\"40 mm\", \"20 mm\", \"20 mm\"], divisions = [{}, {b}, {c}] }}\n\
             element = \"{element}\"\ndisturb = {{ nodes = {}, seed = 3 }}",
            2 * a,
            self.disturbed
        )
        .expect("a string");
        let (nu, own) = (self.nu, format!("volumetric = \"quadratic\"\nnu = {}", self.nu));
        let law = match self.law {
            0 => format!("law = \"neo_hookean\"\nE = \"100 kPa\"\nnu = {nu}"),
            1 => format!("law = \"stable_neo_hookean\"\nE = \"100 kPa\"\nnu = {nu}"),
            2 => format!("law = \"st_venant_kirchhoff\"\nE = \"100 kPa\"\nnu = {nu}"),
            3 => format!("law = \"corotational\"\nE = \"100 kPa\"\nnu = {nu}"),
            4 => format!("law = \"mooney_rivlin\"\nC10 = \"15 kPa\"\nC01 = \"2 kPa\"\n{own}"),
            5 => format!("law = \"gent\"\nmu = \"34 kPa\"\nJ_m = 20\n{own}"),
            _ => format!("law = \"ogden\"\nmu1 = \"50 kPa\"\nalpha1 = 1.3\n{own}"),
        };
        let formulation = ["displacement", "mixed", "mean_dilatation"][self.formulation];
        writeln!(
            t,
            "[laws.rubber]\n{law}\n[[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\nformulation = \"{formulation}\""
        )
        .expect("a string");
        let integrator = [
            "\"static\"",
            "\"implicit_euler\"",
            "\"bdf2\"",
            "{ kind = \"generalised_alpha\", rho = 0.5 }",
            "\"implicit_euler_linearised\"",
            "\"static\"\ncontinuation = \"arc_length\"\nmax_steps = 8",
        ][self.integrator];
        let dynamic = !integrator.contains("static");
        if dynamic {
            t += "[[effect]]\nkind = \"inertia\"\nregion = \"body\"\ndensity = \"1000 kg/m^3\"\nmass = \"lumped\"\n";
            if self.damped {
                t += "[[effect]]\nkind = \"viscous_damping\"\nregion = \"body\"\neta = \"100 Pa s\"\n";
            }
        }
        t += match self.held {
            0 | 1 => "[[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n",
            2 => "[[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\ncomponents = \"x\"\n",
            _ => "",
        };
        writeln!(t, "{}", self.load()).expect("a string");
        t += match self.start {
            1 => "[start]\nkind = \"twisted\"\naxis = [1, 0, 0]\nangle = \"200 deg\"\n",
            2 => "[start]\nkind = \"random\"\nsize = \"20 mm\"\nseed = 5\n",
            3 => "[start]\nkind = \"collapsed\"\nkeep = \"x\"\nperturbation = \"1 mm\"\n",
            _ => "",
        };
        writeln!(
            t,
            "[[stage]]\nintegrator = {integrator}\nduration = \"{} s\"\ndt = \"{} s\"\n[[probe]]\nkind = \"position\"\nregion = \"xmax\"\n\
             [[probe]]\nkind = \"stretch\"\n[[probe]]\nkind = \"energy\"",
            (10.0 * self.dt).min(1.0),
            self.dt.min(1.0)
        )
        .expect("a string");
        t += match self.numerics {
            1 => "[numerics]\nprojection = true\ncuts = 3\n",
            2 => "[numerics]\nline_search = false\ncuts = 2\n",
            3 => "[numerics]\nreuse_factor = false\nextrapolate = false\ncuts = 3\n",
            _ => "[numerics]\ncuts = 3\n",
        };
        t
    }
}

/// The stated end of a scene, and how long it took; `None` where it was refused. What breaks the promise is the error.
fn outcome(text: &str) -> Result<Option<Status>, String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, text).expect("a temporary file");
    let (spec, text) = read_scene(&file, &[]).map_err(|e| format!("it cannot be read: {e}"))?;
    let Ok(body) = Body::load(&file, &spec.mesh, &mut |_| {}) else { return Ok(None) };
    let linearised = text.contains("linearised");
    let Ok(scene) = Scene::build(&file, spec, text, body.into()) else { return Ok(None) };
    let run = scene.run();
    let steps = run.rows.len();
    let finite = run.rows.iter().flatten().all(|x| x.is_finite());
    // One linearised step does not look at what it leaves behind
    if !finite && !linearised {
        return Err(format!("{} rows, one of them not finite; {}", steps, run.status));
    }
    match run.status {
        Status::Interrupted { .. } | Status::TimeBudget { .. } => Err(format!("ended as {}", run.status)),
        status if status.name() != "Converged" && (status.fact().is_empty() || status.remedy().is_empty()) => {
            Err(format!("{} says too little", status.name()))
        }
        status => Ok(Some(status)),
    }
}

/// How many scenes are drawn without PROPTEST_CASES.
const FEW: u32 = 300;

#[test]
fn a_scene_is_refused_or_comes_to_a_stated_end() {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(FEW);
    // The same scenes every time: a failure here is one for everybody
    let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
    let source = proptest::test_runner::TestRng::deterministic_rng(config.rng_algorithm);
    let mut runner = proptest::test_runner::TestRunner::new_with_rng(config, source);
    let (mut ends, mut slowest) = (std::collections::BTreeMap::new(), (Duration::ZERO, String::new()));
    let result = {
        let ends = std::cell::RefCell::new(&mut ends);
        let slowest = std::cell::RefCell::new(&mut slowest);
        runner.run(&drawn(), |d| {
            let (text, start) = (d.text(), std::time::Instant::now());
            let end = outcome(&text).map_err(|e| TestCaseError::fail(format!("{e}\n{text}")))?;
            let name = end.map_or("refused".to_string(), |s| s.name().to_string());
            *ends.borrow_mut().entry(name).or_insert(0) += 1;
            if start.elapsed() > slowest.borrow().0 {
                **slowest.borrow_mut() = (start.elapsed(), text);
            }
            Ok(())
        })
    };
    println!("{ends:?}; the slowest took {:.1?}:\n{}", slowest.0, slowest.1);
    if let Err(e) = result {
        panic!("{e}");
    }
    // Neither all refused nor all easy
    let count = |name: &str| ends.get(name).copied().unwrap_or(0);
    assert!(count("Converged") * 4 >= cases && count("refused") * 2 <= cases, "{ends:?}");
}
