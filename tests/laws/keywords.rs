//! Laws as keywords of other programs: read back they are the same laws, and CalculiX computes the same stresses with them.
//!
//! Numbers are written with all their digits, so that a round trip changes an energy by a few units of the last place: 1e-13 of the stresses holds
//! a hundred of them. ccx prints seven digits and its Newton iteration ends at 1e-7 of the mean force: 1e-5 holds both tenfold.

use crate::common::nodes;
use crate::common::tools;
use durometer::calibrate::{library, library_text};
use durometer::material::keywords::{Energy, KeywordError, Program, read, write};
use durometer::material::{Law, LawSpecError, Want, law_from_table};
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

fn law(text: &str) -> Box<dyn Law> {
    law_from_table(&text.parse().expect("valid TOML")).unwrap_or_else(|e: LawSpecError| panic!("{e}\n{text}"))
}

/// Laws with the quadratic volumetric part.
fn quadratic() -> Vec<Box<dyn Law>> {
    let rest = "volumetric = \"quadratic\"\nkappa = \"2 MPa\"\n";
    let with = |text: &str| law(&format!("{text}\n{rest}"));
    vec![
        law("law = \"neo_hookean_split\"\nmu = \"80 kPa\"\nkappa = \"2 MPa\""),
        with("law = \"mooney_rivlin\"\nC10 = \"30 kPa\"\nC01 = \"9 kPa\""),
        with(
            "law = \"mooney_rivlin\"\nC10 = \"30 kPa\"\nC01 = \"9 kPa\"\nC11 = \"2 kPa\"\nC20 = \"3 kPa\"\nC02 = \"1 kPa\"",
        ),
        with("law = \"yeoh\"\nC10 = \"40 kPa\"\nC20 = \"-2 kPa\"\nC30 = \"0.7 kPa\""),
        with("law = \"ogden\"\nmu1 = \"70 kPa\"\nalpha1 = 1.7"),
        with("law = \"ogden\"\nmu1 = \"70 kPa\"\nalpha1 = 1.7\nmu2 = \"-8 kPa\"\nalpha2 = -2.2"),
        with(
            "law = \"ogden\"\nconvention = \"abaqus\"\nmu1 = \"40 kPa\"\nalpha1 = 1.3\nmu2 = \"2 kPa\"\nalpha2 = 5\nmu3 = \"6 kPa\"\nalpha3 = -2",
        ),
        with(
            "law = \"ogden\"\nmu1 = \"60 kPa\"\nalpha1 = 1.3\nmu2 = \"1 kPa\"\nalpha2 = 5\nmu3 = \"-6 kPa\"\nalpha3 = -2\nmu4 = \"3 kPa\"\nalpha4 = 3",
        ),
    ]
}

/// Laws with the part ¼κ(J² − 1 − 2 ln J), and those of other kinds.
fn others() -> Vec<Box<dyn Law>> {
    let simo = "volumetric = \"simo_taylor\"\nkappa = \"2 MPa\"\n";
    let log = "volumetric = \"logarithmic\"\nnu = 0.49\n";
    vec![
        law(&format!("law = \"arruda_boyce\"\nmu = \"60 kPa\"\nlambda_m = 3.1\n{simo}")),
        law(&format!("law = \"gent\"\nmu = \"60 kPa\"\nJ_m = 30\n{simo}")),
        law("law = \"neo_hookean\"\nmu = \"60 kPa\"\nnu = 0.48"),
        law(&format!("law = \"mooney_rivlin\"\nC10 = \"30 kPa\"\nC01 = \"9 kPa\"\n{log}")),
        law(&format!("law = \"ogden\"\nmu1 = \"70 kPa\"\nalpha1 = 1.7\n{log}")),
        law(&format!("law = \"veronda_westmann\"\nC1 = \"90 kPa\"\nbeta = 0.9\n{log}")),
    ]
}

/// Foams of one to three terms, the last one with ν = 0, which FEBio has too.
fn foams() -> Vec<Box<dyn Law>> {
    let term =
        |n: usize, mu: &str, alpha: f64, nu: f64| format!("mu{n} = \"{mu}\"\nalpha{n} = {alpha}\nnu{n} = {nu}\n");
    let of = |terms: &[String]| law(&format!("law = \"hyperfoam\"\n{}", terms.concat()));
    vec![
        of(&[term(1, "40 kPa", -2.0, 0.25)]),
        of(&[term(1, "30 kPa", 7.0, 0.1), term(2, "12 kPa", -2.5, 0.3)]),
        of(&[term(1, "30 kPa", 7.0, 0.05), term(2, "12 kPa", -2.5, 0.3), term(3, "5 kPa", 1.5, 0.2)]),
        of(&[term(1, "30 kPa", 9.0, 0.0), term(2, "12 kPa", -2.5, 0.0)]),
    ]
}

fn gradient() -> Mat3 {
    Mat3::new(1.4, 0.1, 0.0, 0.0, 0.85, 0.05, 0.02, 0.0, 0.86)
}

fn stress(law: &dyn Law, f: &Mat3) -> Mat3 {
    law.eval(f, Want::Residual).unwrap_or_else(|e| panic!("{e}")).p
}

/// Every law in every program that has it, in three units. The volumetric part is the program's: with the law's own the stresses are the same, and
/// at J = 1 their deviatoric parts always are.
#[test]
fn laws_survive_the_way_to_a_program_and_back() {
    let mut pairs = 0;
    for law in quadratic().iter().chain(&others()).chain(&foams()) {
        let energy = Energy::of(&**law);
        for (program, unit) in Program::ALL.into_iter().flat_map(|p| ["Pa", "kPa", "MPa"].map(|u| (p, u))) {
            let text = match write(&energy, program, unit, &["data: test.csv".into()]) {
                Ok(text) => text,
                Err(KeywordError::NoForm { .. }) => continue,
                Err(e) => panic!("{e}"),
            };
            assert!(text.contains(&format!("in {unit},")) && text.contains("volumetric part: "), "{text}");
            let back = read(&text, program, unit).unwrap_or_else(|e| panic!("{e}\n{text}")).energy;
            let built = back.build().expect("a law");
            let shown = format!("{} {program:?} {unit}\n{text}", energy.law);
            assert!((back.kappa / energy.kappa - 1.0).abs() < 1e-13, "{shown}");
            let exact = back.volumetric == energy.volumetric;
            assert!(exact != text.contains("the law of Durometer has"), "{shown}");
            let f = gradient();
            let f = if exact { f } else { f / f.determinant().cbrt() };
            let [own, theirs] = [stress(&**law, &f), stress(&*built, &f)];
            // Cauchy stress without its mean
            let deviator = |p: &Mat3| {
                let s = p * f.transpose();
                s - Mat3::identity() * (s.trace() / 3.0)
            };
            let difference = if exact { own - theirs } else { deviator(&own) - deviator(&theirs) };
            assert!(difference.norm() < 1e-13 * own.norm().max(energy.kappa), "{difference} {shown}");
            pairs += 1;
        }
    }
    println!("{pairs} pairs of laws, programs and units");
    // Every foam in Abaqus, CalculiX and Ansys, and one in FEBio
    assert!(pairs >= 3 * (50 + 13), "{pairs}");
}

#[test]
fn laws_that_a_program_lacks_and_broken_texts_are_refused() {
    let laws = others();
    for (law, program, fact) in [
        (&laws[1], Program::Abaqus, "abaqus has no law with the energy of `gent`"),
        (&laws[5], Program::Ansys, "ansys has no law with the energy of `veronda_westmann`"),
        (&laws[0], Program::Febio, "whose coefficients differ between its versions"),
        (&quadratic()[5], Program::Sofa, "and several terms"),
        (&quadratic()[7], Program::Calculix, "and more than three terms"),
        (&foams()[0], Program::Febio, "where Poisson's ratio is not zero"),
        (&foams()[0], Program::Sofa, "sofa has no law with the energy of `hyperfoam`"),
    ] {
        let message = write(&Energy::of(&**law), program, "MPa", &[]).expect_err(fact).to_string();
        assert!(message.contains(fact), "{message}");
    }
    let message = write(&Energy::of(&*laws[0]), Program::Abaqus, "mm", &[]).expect_err("no pressure").to_string();
    assert!(message.contains("wrong dimension"), "{message}");
    for (text, program, fact) in [
        ("*ELASTIC\n1, 2\n", Program::Abaqus, "no *HYPERELASTIC"),
        ("*HYPERELASTIC, YEOH\n1, 2, 3\n", Program::Calculix, "3 numbers"),
        ("*HYPERELASTIC, NEO HOOKE\n1, 0\n", Program::Abaqus, "incompressible (D1 = 0)"),
        ("*HYPERELASTIC, YEOH\n1, 2, 3, 4, 5, 6\n", Program::Abaqus, "several terms"),
        ("*HYPERELASTIC, NEO HOOKE\n1, x\n", Program::Abaqus, "\"x\" is not a number"),
        ("*HYPERELASTIC, MARLOW\n1, 2\n", Program::Abaqus, "is no law of Durometer"),
        ("*HYPERELASTIC, OGDEN, N=99999999999\n1, 2, 3\n", Program::Abaqus, "is no law of Durometer"),
        ("*HYPERELASTIC, NEO HOOKE\n-1, 1\n", Program::Abaqus, "mu"),
        ("*HYPERFOAM, N=2\n1, 2, 3, 4, 0.1\n", Program::Calculix, "5 numbers"),
        ("*HYPERFOAM, N=4\n1, 2, 3\n", Program::Abaqus, "4 terms; Durometer has 1 to 3"),
        ("*HYPERFOAM, POISSON=0.1, TEST DATA INPUT\n1, 2, 3\n", Program::Abaqus, "give the constants of the terms"),
        ("*HYPERFOAM\n1, 2, 0.5\n", Program::Abaqus, "nu1 (Poisson's ratio of the term) = 0.5"),
        (
            "*HYPERELASTIC, YEOH\n1, 2, 3, 1e-3, 0, 0, 20\n2, 3, 4, 1e-3, 0, 0, 60\n",
            Program::Abaqus,
            "of one temperature",
        ),
        ("*HYPERELASTIC, NEO HOOKE, DEPENDENCIES=1\n1, 1, 20, 3\n", Program::Abaqus, "depends on fields"),
        ("*HYPERELASTIC, NEO HOOKE\n1, 1, 20, 3\n", Program::Abaqus, "4 numbers"),
        ("*HYPERFOAM\n1, 2, 0.1, 20\n1, 2, 0.1, 60\n", Program::Abaqus, "of one temperature"),
        (
            "TB,HYPER,1,1,3,MOONEY\nTBDATA,1,2,1,1,1e-3\nTB,PRONY,1,,1,SHEAR\nTBDATA,1,.3,1\n",
            Program::Ansys,
            "the material relaxes (\"TB,PRONY,1,,1,SHEAR\")",
        ),
        ("TB,HYPER,1,1,1,FOAM\nTBDATA,1,1,2\n", Program::Ansys, "2 numbers"),
        ("TB,HYPER,1,1,1,BLATZ\n", Program::Ansys, "no number"),
        ("TB,HYPER,1,2,1,NEO\nTBTEMP,20\nTBDATA,1,1,1\nTBTEMP,60\nTBDATA,1,2,1\n", Program::Ansys, "one temperature"),
        ("<material type=\"Ogden unconstrained\"><c1>1</c1><cp>2</cp></material>", Program::Febio, "cp is not zero"),
        ("TB,HYPER,1,1,2,MOONEY\nTBDATA,1e18,1\n", Program::Ansys, "place"),
        ("TB,HYPER,1,1,7,MOONEY\nTBDATA,1,1\n", Program::Ansys, "is no law of Durometer"),
        ("<material type=\"Ogden\"><k>1</k></material>", Program::Febio, "0 terms"),
        ("<material type=\"Gent\"><k>1</k>", Program::Febio, "expected"),
        ("<a materialName=\"Costa\" ParameterSet=\"1 2\"/>", Program::Sofa, "is no law that Durometer reads"),
        ("", Program::Sofa, "no component"),
    ] {
        let message = read(text, program, "MPa").expect_err(text).to_string();
        assert!(message.contains(fact), "\"{fact}\" not in \"{message}\"");
    }
}

/// Spellings that this program does not write: two terms of a polynomial, a keyword on two lines, and one temperature.
#[test]
fn other_spellings_of_a_law_are_read() {
    for (text, program, law, constants, kappa) in [
        ("*HYPERELASTIC, REDUCED POLYNOMIAL, N=1\n2, 0.5\n", Program::Abaqus, "neo_hookean_split", &[4.0][..], 4.0),
        ("*HYPERELASTIC, REDUCED POLYNOMIAL, N=2\n2, 3, 0.5, 0\n", Program::Abaqus, "yeoh", &[2.0, 3.0, 0.0], 4.0),
        ("*HYPERELASTIC,\n YEOH\n2, 3, 4, 0.5\n", Program::Calculix, "yeoh", &[2.0, 3.0, 4.0], 4.0),
        ("TB,HYPER,1,1,1,NEO\nTBTEMP,20\nTBDATA,1,2,0.5\n", Program::Ansys, "neo_hookean_split", &[2.0], 4.0),
    ] {
        let energy = read(text, program, "Pa").expect(text).energy;
        assert_eq!((energy.law.as_str(), &energy.constants[..], energy.kappa), (law, constants, kappa), "{text}");
        energy.build().expect(text);
    }
}

/// A part of a material that the law does not have is named in every format, and the density and parts of other materials are not.
#[test]
fn parts_of_a_material_that_are_left_out_are_named() {
    let abaqus = "*MATERIAL, NAME=A\n*DENSITY\n1e-9\n*HYPERELASTIC, NEO HOOKE\n1, 1\n";
    let ansys = "MP,DENS,1,1100\nTB,HYPER,1,1,,NEO\nTBDATA,1,1,1\n";
    let febio = |kind: &str, rest: &str| format!("<material type=\"{kind}\"><density>1</density>{rest}</material>");
    let gent = "<G>1</G><Jm>30</Jm><k>9</k>";
    let foam = "<c1>1</c1><m1>2</m1>";
    let none: &[&str] = &[];
    for (text, program, expected) in [
        (abaqus.to_string(), Program::Abaqus, none),
        (format!("{abaqus}*MATERIAL, NAME=B\n*PLASTIC\n1, 0\n"), Program::Abaqus, &[]),
        (
            format!("{abaqus}*Damage Initiation\n1\n*DAMAGE EVOLUTION\n1\n"),
            Program::Abaqus,
            &["*DAMAGE INITIATION", "*DAMAGE EVOLUTION"],
        ),
        (format!("{abaqus}*ELASTIC\n1, 0.3\n*CREEP\n1, 1, 1\n"), Program::Calculix, &["*ELASTIC", "*CREEP"]),
        (ansys.to_string(), Program::Ansys, &[]),
        (format!("{ansys}TB,CDM,2,1,3,PSE2\nTBDATA,1,1.5,1,0.2\n"), Program::Ansys, &[]),
        (format!("{ansys}TB,CDM,1,1,3,PSE2\nTBDATA,1,1.5,1,0.2\n"), Program::Ansys, &["TB,CDM"]),
        (
            format!("tb,biso\nMP,ALPX,1,1e-4\n{ansys}tb,visc,1 ! creep\n"),
            Program::Ansys,
            &["MP,ALPX", "TB,BISO", "TB,VISC"],
        ),
        ("TB,BISO,1\nTB,HYPER,1,1,1,BLATZ\nTBDATA,1,1\n".to_string(), Program::Ansys, &["TB,BISO"]),
        (febio("Gent", gent), Program::Febio, &[]),
        (febio("Gent", &format!("{gent}<mat_axis/>")), Program::Febio, &["<mat_axis>"]),
        (febio("Gent", &gent.replace("<G>", "<G lc=\"1\">")), Program::Febio, &["the load curve of <G>"]),
        (febio("neo-Hookean", "<E>1</E><v>0.3</v><k>2</k>"), Program::Febio, &["<k>"]),
        (febio("Mooney-Rivlin", "<c1>1</c1><c2>1</c2><c3>1</c3><k>9</k>"), Program::Febio, &["<c3>"]),
        (febio("Ogden unconstrained", foam), Program::Febio, &[]),
        (febio("Ogden unconstrained", &format!("{foam}<k>2</k>")), Program::Febio, &["<k>"]),
    ] {
        let found = read(&text, program, "MPa").unwrap_or_else(|e| panic!("{e}\n{text}"));
        assert_eq!(found.passed_over, expected, "{text}");
    }
    // Terms behind a gap, and numbers behind another command, are parts of the law
    let ogden = febio("Ogden", "<c1>0.16</c1><m1>2</m1><c3>0.04</c3><m3>-2</m3><k>1000</k>");
    let ogden = read(&ogden, Program::Febio, "Pa").expect("two terms");
    assert_eq!((ogden.energy.constants[1], ogden.energy.constants[3]), (2.0, -2.0));
    assert_eq!((ogden.energy.constants.len(), ogden.passed_over.len()), (4, 0));
    let apart = ansys.replace("TBDATA,1,1,1", "TBDATA,1,1\n/COM\nTBDATA,2,1");
    let [apart, together] = [apart.as_str(), ansys].map(|text| read(text, Program::Ansys, "MPa").expect("a law"));
    assert_eq!(apart, together);
    let foam = read("TB,HYPER,1,1,1,FOAM\nTBDATA,1,1,2,0.1,3\n", Program::Ansys, "Pa").expect_err("a number too many");
    assert!(foam.to_string().contains("4 numbers"), "{foam}");
}

/// `*VISCOELASTIC` becomes a series in the order of times, and instantaneous constants those of the long term; what the effect does not have is refused, and
/// so is what would change the stiffness without a word. Other keywords that change the response are named.
#[test]
fn relaxation_of_a_material_is_read_or_refused() {
    let text = |moduli: &str, series: &str| {
        format!(
            "*MATERIAL, NAME=OTHER\n*VISCOELASTIC, TIME=PRONY\n0.9, 0, 1\n*MATERIAL, NAME=RUBBER\n*DENSITY\n1e-9\n*Hyperelastic, Ogden, N=2{moduli}\n\
             3, 2, -1, -2, 1e-3, 0, 20\n{series}*MATERIAL, NAME=LAST\n*VISCOELASTIC, TIME=PRONY\n0.8, 0, 1\n"
        )
    };
    let prony = "*Viscoelastic, time=PRONY\n0.1, , 5\n0.2, 0, 0.3\n";
    let read = |text: &str| read(text, Program::Abaqus, "kPa");
    let alone = read(&text("", "")).expect("no relaxation");
    assert!(alone.series.is_empty());
    // 2 μ_n, and κ = 2/D1
    assert_eq!((alone.energy.constants.clone(), alone.energy.kappa), (vec![6e3, 2.0, -2e3, -2.0], 2e6));
    for moduli in ["", ", MODULI=LONG TERM"] {
        let found = read(&text(moduli, prony)).expect("a series");
        assert_eq!((&found.energy, &found.series), (&alone.energy, &vec![(0.2, 0.3), (0.1, 5.0)]));
    }
    let fast = read(&text(", MODULI=INSTANTANEOUS", prony)).expect("a series");
    let expected = alone.energy.build().expect("a law").small_strain();
    let found = fast.energy.build().expect("a law").small_strain();
    assert!((found.mu / expected.mu - 0.7).abs() < 1e-12 && (found.kappa / expected.kappa - 1.0).abs() < 1e-12);
    assert_eq!((fast.energy.constants[1], fast.energy.constants[3]), (2.0, -2.0));
    for (moduli, series, fact) in [
        (", MODULI=INSTANTANEOUS", "", "the material has no *VISCOELASTIC"),
        (", MODULI=FAST", prony, "MODULI=FAST is neither"),
        ("", "*VISCOELASTIC, TIME=PRONY\n0.3, 0.3, 1\n", "the bulk modulus relaxes (k = 0.3"),
        ("", "*VISCOELASTIC, TIME=RELAXATION TEST DATA\n0.3, 0, 1\n", "is no Prony series"),
        ("", "*VISCOELASTIC, TIME=PRONY\n", "no numbers below"),
        ("", "*VISCOELASTIC, TIME=PRONY\n0.3, 0\n", "g, k and tau are needed"),
        ("", "*VISCOELASTIC, TIME=PRONY\n0.3, 0, -1\n", "a time above 0"),
        ("", "*VISCOELASTIC, TIME=PRONY\n0.6, 0, 1\n0.6, 0, 2\n", "nothing is left in the long run"),
    ] {
        let message = read(&text(moduli, series)).expect_err(fact).to_string();
        assert!(message.contains(fact), "\"{fact}\" not in \"{message}\"");
    }
    let softens = text("", "*TRS\n20, 10, 50\n*Mullins Effect\n1.5, 2, 0.1\n") + "*PLASTIC\n1, 0\n";
    let (softens, expected) = (read(&softens).expect("the law"), ["*MULLINS EFFECT", "*TRS"].map(String::from));
    assert_eq!((&softens.energy, &softens.passed_over[..]), (&alone.energy, &expected[..]));
    assert!(alone.passed_over.is_empty());
    let foam = read("*HYPERFOAM\n1, 2, 0.1\n*VISCOELASTIC, TIME=PRONY\n0.3, 0, 1\n").expect_err("a foam").to_string();
    assert!(foam.contains("the effect viscoelastic has no foams"), "{foam}");
}

/// Input of ccx: a block with an affine displacement of its boundary, 1-based nodes.
fn input(mesh: &TetMesh, boundary: &[u32], f: &Mat3, keywords: &str) -> String {
    let mut text = String::from("*NODE, NSET=ALL\n");
    for (k, p) in mesh.points.iter().enumerate() {
        writeln!(text, "{}, {:.11e}, {:.11e}, {:.11e}", k + 1, p.x, p.y, p.z).expect("a string");
    }
    text += "*ELEMENT, TYPE=C3D4, ELSET=BODY\n";
    for c in 0..mesh.cell_count() {
        let nodes: Vec<String> = mesh.cell(c).iter().map(|n| (n + 1).to_string()).collect();
        writeln!(text, "{}, {}", c + 1, nodes.join(", ")).expect("a string");
    }
    write!(text, "*MATERIAL, NAME=RUBBER\n{keywords}*SOLID SECTION, ELSET=BODY, MATERIAL=RUBBER\n").expect("a string");
    text += "*STEP, NLGEOM, INC=100\n*STATIC, DIRECT\n0.1, 1.0\n*CONTROLS, PARAMETERS=FIELD\n1e-7, 1e-7, , , 1e-7, 1e-7\n*BOUNDARY\n";
    for k in boundary {
        let u = (f - Mat3::identity()) * mesh.points[*k as usize];
        (0..3).for_each(|i| writeln!(text, "{}, {}, {}, {:.11e}", k + 1, i + 1, i + 1, u[i]).expect("a string"));
    }
    text + "*NODE PRINT, NSET=ALL, FREQUENCY=100\nRF\n*END STEP\n"
}

/// Forces of the nodes in the results of ccx.
fn forces(file: &Path, count: usize) -> Vec<Vec3> {
    let text = std::fs::read_to_string(file).expect("ccx writes its results");
    let mut out = vec![Vec3::zeros(); count];
    for line in text.lines() {
        let numbers: Vec<f64> = line.split_whitespace().map_while(|w| w.parse().ok()).collect();
        if let &[node, x, y, z] = &numbers[..] {
            out[node as usize - 1] = Vec3::new(x, y, z);
        }
    }
    out
}

/// The mean stress of a block is Σ f ⊗ X/V over its nodes.
#[test]
fn calculix_computes_the_same_stresses() {
    if tools::is_missing(Command::new("ccx").arg("-v").output().is_ok(), "ccx (Debian: calculix-ccx)") {
        return;
    }
    let mesh = block(2, 2, 2, 0.02, 0.02, 0.02, Order::Linear);
    let faces = ["xmin", "xmax", "ymin", "ymax", "zmin", "zmax"];
    let mut boundary: Vec<u32> = faces.iter().flat_map(|f| nodes(&mesh, f)).collect();
    boundary.sort_unstable();
    boundary.dedup();
    assert!(boundary.len() < mesh.points.len(), "a node inside is free");
    let f = gradient();
    let arruda = others().swap_remove(0);
    for law in quadratic()[..7].iter().chain([&arruda]).chain(&foams()) {
        let energy = Energy::of(&**law);
        let keywords = write(&energy, Program::Calculix, "Pa", &[]).expect("CalculiX has it");
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("block.inp"), input(&mesh, &boundary, &f, &keywords)).expect("writable");
        let run = Command::new("ccx").arg("block").current_dir(folder.path()).env("OMP_NUM_THREADS", "1").output();
        let log = String::from_utf8_lossy(&run.expect("ccx runs").stdout).into_owned();
        assert!(log.contains("Job finished"), "{log}\n{keywords}");
        let forces = forces(&folder.path().join("block.dat"), mesh.points.len());
        let sum: Mat3 = forces.iter().zip(&mesh.points).map(|(f, x)| f * x.transpose()).sum();
        let (theirs, own) = (sum / 0.02_f64.powi(3), stress(&**law, &f));
        let difference = (theirs - own).norm() / own.norm();
        println!("{} with {} constants: {difference:.1e}", energy.law, energy.constants.len());
        assert!(difference < 1e-5, "{keywords}\n{theirs} {own}");
    }
}

/// The committed laws of Treloar's rubber: constants with their intervals, and the stress at λ = 2 against the law itself.
#[test]
fn law_files_are_listed_and_compared() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
    let found = library(&folder).expect("the project has law files");
    let of = |name: &str| found.laws.iter().find(|l| l.file.ends_with(name)).unwrap_or_else(|| panic!("{name}"));
    let neo = of("treloar-1944/neo-hookean.toml");
    let mu = neo.constants[0].value;
    // P = μ(λ − λ⁻²)
    assert!(
        (neo.stress_at_2 / (mu * 1.75) - 1.0).abs() < 1e-12 && (neo.shear_modulus / mu - 1.0).abs() < 1e-5,
        "{neo:?}"
    );
    assert!(neo.constants[0].interval.is_some_and(|[a, b]| a < mu && mu < b) && !neo.measured_at_2, "{neo:?}");
    assert!(of("treloar-1944/yeoh.toml").constants.len() == 3 && of("treloar-1944/ogden.toml").law == "ogden");
    // Of a whole specimen: the stretches reach from rest to the largest one, and the warnings are those of this silicone
    let ecoflex = of("silicones/ecoflex-00-30.toml");
    assert!(ecoflex.measured_at_2 && ecoflex.fitted_stretch.is_some_and(|[a, b]| a == 1.0 && b > 3.0), "{ecoflex:?}");
    let file = std::fs::read_to_string(folder.join("silicones/ecoflex-00-30.toml")).expect("committed");
    assert!(file.contains("warnings") && !file.contains("dragon-skin") && !file.contains("Dragon Skin"), "{file}");
    let text = library_text(&found, &folder);
    assert!(text.contains("treloar-1944/gent.toml") && text.contains("the data do not reach λ = 2"), "{text}");
    let empty = tempfile::tempdir().expect("a temporary folder");
    let message = library(empty.path()).expect_err("no law").to_string();
    assert!(message.contains("holds no law file"), "{message}");
}
