//! A law whose derivative by its constants has no closed form: it is differentiated by differences of scenes, whose steps stay where the law is
//! defined, and whose errors are told.

use crate::to_keys::check_by;
use durometer::material::{
    Chosen, Law, LawEntry, LawError, LawInfo, Moduli, Parameter, Response, Values, Want, find, moduli, register,
    register_anew,
};
use durometer::math::tensor::Mat3;
use durometer::scene::{ParameterKey, Scene, SceneBuilder, SensitivityRecorder, parse_scene};
use std::sync::Once;
use toml::Table;

const INFO: LawInfo = LawInfo {
    name: "inexact",
    title: "Inexact",
    formula: "that of neo_hookean",
    source: "that of neo_hookean",
    limits: "J > 0",
    parameters: moduli::PAIR,
    optional: 0,
    choices: &[],
    survives_inversion: false,
    objective: true,
    isochoric: false,
};

/// The Neo-Hookean law, whose derivative is wrong: no run may take it.
#[derive(Debug)]
struct Inexact(Box<dyn Law>);

impl Inexact {
    fn boxed(moduli: Moduli) -> Box<dyn Law> {
        let hooke = find("neo_hookean").expect("a law of the library").build_with(&[moduli.e, moduli.nu], &[]);
        Box::new(Self(hooke.expect("two moduli")))
    }
}

impl Law for Inexact {
    fn info(&self) -> &'static LawInfo {
        &INFO
    }
    fn values(&self) -> Vec<f64> {
        self.0.values()
    }
    fn small_strain(&self) -> Moduli {
        self.0.small_strain()
    }
    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        self.0.eval(f, want)
    }
    fn along(&self, _: &[f64]) -> Box<dyn Law> {
        Self::boxed(self.small_strain())
    }
    fn is_differentiated_exactly(&self) -> bool {
        false
    }
}

/// A beam under its weight, of this law, with two constants.
fn beam(law: &str, [first, second]: [(&str, &str); 2]) -> Table {
    static REGISTERED: Once = Once::new();
    REGISTERED.call_once(|| {
        let keys: &[Parameter] = moduli::KEYS;
        let entry = LawEntry::made_by(
            &INFO,
            keys,
            &[100e3, 0.4],
            |values, _| Ok(Inexact::boxed(Moduli::from_map(values)?)),
            |law, given, key| law.small_strain().rates(given, key),
        );
        register(entry).expect("a name of its own");
    });
    let text = format!(
        r#"
[mesh.grid]
kind = "box"
size = ["60 mm", "10 mm", "10 mm"]
divisions = [3, 1, 1]
[laws.silicone]
law = "{law}"
{} = {}
{} = {}
[[effect]]
kind = "elastic"
region = "body"
law = "silicone"
[[effect]]
kind = "gravity"
region = "body"
density = "1070 kg/m^3"
direction = [0, 0, -1]
acceleration = "9.81 m/s^2"
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
[[probe]]
kind = "position"
region = "xmax"
[numerics]
tolerance = 1e-12
reuse_factor = false
"#,
        first.0, first.1, second.0, second.1
    );
    text.parse().unwrap_or_else(|e| panic!("{e}"))
}

/// Up to 1e-3 and 1e-4 from incompressibility, where ν has this room only. The differences of runs have steps of 1e-5 of ν, a tenth of it at most.
#[test]
fn constants_next_to_incompressibility() {
    for nu in ["0.3", "0.495", "0.4975", "0.499", "0.4999"] {
        let table = beam("inexact", [("E", "\"100 kPa\""), ("nu", nu)]);
        check_by(nu, &table, &["laws.silicone.nu", "laws.silicone.E"], 1e-5);
    }
    for kappa in ["\"100 kPa\"", "\"3.3 MPa\"", "\"33 MPa\""] {
        let table = beam("inexact", [("mu", "\"34 kPa\""), ("kappa", kappa)]);
        check_by(kappa, &table, &["laws.silicone.mu"], 1e-3);
    }
}

/// By the bulk modulus of a body that is nearly incompressible hardly anything changes, so that the exact derivatives of the same law tell what the
/// differences are worth: their errors are at most ten times what is told, but for 1e-9 of the derivative.
#[test]
fn the_error_is_told() {
    let constants = [("mu", "\"34 kPa\""), ("kappa", "\"33 MPa\"")];
    let keys: Vec<ParameterKey> = ["laws.silicone.kappa", "laws.silicone.mu"].map(|k| k.parse().expect("a key")).into();
    let [exact, found] = ["neo_hookean", "inexact"].map(|law| {
        let text = toml::to_string(&beam(law, constants)).expect("a table");
        let scene = parse_scene(&text).unwrap_or_else(|e| panic!("{e}"));
        let sensitivities = Some(SensitivityRecorder::new(&scene, &keys).unwrap_or_else(|e| panic!("{e}")));
        let options = durometer::scene::RunOptions { sensitivities, ..Default::default() };
        scene.run_with(options).sensitivities.expect("the options ask for them")
    });
    assert!(found.doubtful().is_empty() && found.key_sizes.iter().all(|size| *size > 0.0), "{:?}", found.doubtful());
    assert_eq!(exact.key_sizes, [0.0, 0.0]);
    for c in 0..exact.columns.len() {
        for (k, key) in keys.iter().enumerate() {
            let (known, value) = (exact.rows[1][c][k], found.rows[1][c][k]);
            let (error, told) = ((value - known).abs(), found.errors[c][k]);
            println!("{} by {key}: {known:e}, error {error:.1e}, told {told:.1e}", exact.columns[c]);
            assert!(
                told > 0.0 && error <= 10.0 * told + 1e-9 * known.abs(),
                "{key}: {value:e} and {known:e}, {told:.1e}"
            );
        }
    }
}

/// A law whose modulus is a multiple of the one that is given.
fn multiple(factor: f64) -> LawEntry {
    const NAMED: LawInfo = LawInfo { name: "multiple", ..INFO };
    let make = move |values: &Values, _: &Chosen| {
        let given = Moduli::from_map(values)?;
        find("neo_hookean")?.build_with(&[factor * given.e, given.nu], &[])
    };
    let rates = |law: &dyn Law, given: &Values, key: &str| law.small_strain().rates(given, key);
    LawEntry::made_by(&NAMED, moduli::KEYS, &[100e3, 0.4], make, rates)
}

/// A law that takes the place of another one is that of scenes which are read from then on: others have the old one in their differences too.
#[test]
fn scenes_keep_the_laws_that_they_were_read_with() {
    register_anew(multiple(1.0)).expect("a name of its own");
    let text = toml::to_string(&beam("multiple", [("E", "\"100 kPa\""), ("nu", "0.3")])).expect("a table");
    let read = || parse_scene(&text).unwrap_or_else(|e| panic!("{e}"));
    let keys: Vec<ParameterKey> =
        ["laws.silicone.E", "effect.gravity.density"].map(|k| k.parse().expect("a key")).into();
    let derivatives = |scene: &Scene| {
        let recorders = [SensitivityRecorder::new(scene, &keys), SensitivityRecorder::by_differences(scene, &keys)];
        recorders.map(|recorder| {
            let sensitivities = Some(recorder.unwrap_or_else(|e| panic!("{e}")));
            let options = durometer::scene::RunOptions { sensitivities, ..Default::default() };
            scene.run_with(options).sensitivities.expect("the options ask for them").rows
        })
    };
    let (scene, builder) = (read(), SceneBuilder::parse(&text).expect("a scene"));
    let before = derivatives(&scene);
    register_anew(multiple(2.0)).expect("in the place of the other");
    assert_eq!(derivatives(&scene), before);
    let changed = builder.set("laws.silicone.nu", 0.3).and_then(SceneBuilder::build).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(derivatives(&changed), before);
    assert_ne!(derivatives(&read()), before);
}
