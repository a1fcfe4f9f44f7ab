//! Materials of FEBio and SOFA, both in XML.
//!
//! FEBio: `neo-Hookean` is the coupled law in E and ν; the others are uncoupled with `k` = κ and `pressure_model` 0 for ½κ(ln J)², 1 for ¼κ(J² − 1 −
//! 2 ln J), 2 for ½κ(J − 1)². Ogden's energy is Σ (c_n/m_n²)(Σλ̄^m_n − 3). The coefficients of its Arruda–Boyce law differ between versions, so that
//! this law is not written.
//!
//! SOFA: `NeoHookean` with μ and λ is the coupled law; `MooneyRivlin` C10, C01, κ and `Ogden` μ, α, κ of (μ/α²)(Σλ̄^α − 3) have ½κ(ln J)².

use super::energy::{COUPLED, Energy, OGDEN, SPLIT};
use super::error::KeywordError;
use super::foam;
use super::numbers::{number, numbers};
use super::program::Program;
use super::series::Imported;
use crate::material::{LawSpecError, Moduli, Values, VolumetricKind};
use roxmltree::{Document, Node};

const PRESSURE: [VolumetricKind; 3] =
    [VolumetricKind::Logarithmic, VolumetricKind::SimoTaylor, VolumetricKind::Quadratic];

/// The element of FEBio, and its volumetric part.
pub fn write_febio(energy: &Energy, scale: f64) -> Result<(String, Option<VolumetricKind>), KeywordError> {
    let c = &energy.constants;
    let p = |k: usize| number(c[k] * scale);
    let own: Vec<(String, String)> = match energy.law.as_str() {
        COUPLED => {
            let hooke = energy.moduli()?;
            vec![("E".into(), number(hooke.e * scale)), ("v".into(), number(hooke.nu))]
        }
        SPLIT => vec![("c1".into(), number(0.5 * c[0] * scale)), ("c2".into(), "0".into())],
        "mooney_rivlin" if c.len() == 2 => vec![("c1".into(), p(0)), ("c2".into(), p(1))],
        "veronda_westmann" => vec![("c1".into(), p(0)), ("c2".into(), number(c[1]))],
        "gent" => vec![("G".into(), p(0)), ("Jm".into(), number(c[1]))],
        OGDEN => {
            let term = |(n, v): (usize, &[f64])| {
                [(format!("c{}", n + 1), number(v[0] * scale)), (format!("m{}", n + 1), number(v[1]))]
            };
            c.chunks_exact(2).enumerate().flat_map(term).collect()
        }
        "arruda_boyce" => return Err(energy.refuse(Program::Febio, ", whose coefficients differ between its versions")),
        _ => return Err(energy.refuse(Program::Febio, "")),
    };
    let kind = if energy.law == COUPLED {
        "neo-Hookean"
    } else if energy.law == OGDEN {
        "Ogden"
    } else if energy.law == "gent" {
        "Gent"
    } else if energy.law == "veronda_westmann" {
        "Veronda-Westmann"
    } else {
        "Mooney-Rivlin"
    };
    let mut text = format!("<material id=\"1\" name=\"rubber\" type=\"{kind}\">\n");
    own.iter().for_each(|(key, value)| text += &format!("  <{key}>{value}</{key}>\n"));
    if let Some(u) = energy.volumetric {
        let model = PRESSURE.iter().position(|k| *k == u).expect("every volumetric part is one of FEBio");
        text += &format!("  <k>{}</k>\n  <pressure_model>{model}</pressure_model>\n", number(energy.kappa * scale));
    }
    Ok((text + "</material>\n", energy.volumetric))
}

/// The component of SOFA, and its volumetric part.
pub fn write_sofa(energy: &Energy, scale: f64) -> Result<(String, Option<VolumetricKind>), KeywordError> {
    let c = &energy.constants;
    let kappa = energy.kappa * scale;
    let (name, values) = match energy.law.as_str() {
        COUPLED => ("NeoHookean", vec![c[0] * scale, energy.moduli()?.lambda * scale]),
        SPLIT => ("MooneyRivlin", vec![0.5 * c[0] * scale, 0.0, kappa]),
        "mooney_rivlin" if c.len() == 2 => ("MooneyRivlin", vec![c[0] * scale, c[1] * scale, kappa]),
        OGDEN if c.len() == 2 => ("Ogden", vec![c[0] * scale, c[1], kappa]),
        OGDEN => return Err(energy.refuse(Program::Sofa, " and several terms")),
        _ => return Err(energy.refuse(Program::Sofa, "")),
    };
    let values: Vec<String> = values.into_iter().map(number).collect();
    let text = format!(
        "<TetrahedronHyperelasticityFEMForceField name=\"rubber\" materialName=\"{name}\" ParameterSet=\"{}\"/>\n",
        values.join(" ")
    );
    Ok((text, (energy.law != COUPLED).then_some(VolumetricKind::Logarithmic)))
}

/// Parses text that need not have a single root.
fn with_document<T>(
    program: Program,
    text: &str,
    read: impl FnOnce(&Document) -> Result<T, KeywordError>,
) -> Result<T, KeywordError> {
    let refuse = |e: roxmltree::Error| KeywordError::Unreadable { program, what: e.to_string() };
    // A whole file begins with a declaration; a fragment is wrapped in a root
    let text = text.trim_start();
    let piece = format!("<all>{text}</all>");
    let document = Document::parse(if text.starts_with("<?xml") { text } else { &piece }).map_err(refuse)?;
    read(&document)
}

/// Reads the first `material` of FEBio.
pub fn read_febio(text: &str, scale: f64) -> Result<Imported, KeywordError> {
    let program = Program::Febio;
    let refuse = |what: String| KeywordError::Unreadable { program, what };
    with_document(program, text, |document| {
        let material = document
            .descendants()
            .find(|n| n.has_tag_name("material"))
            .ok_or_else(|| refuse("no <material>".into()))?;
        let child = |key: &str| material.children().find(|n: &Node| n.has_tag_name(key)).and_then(|n| n.text());
        let value = |key: &str| -> Result<f64, KeywordError> {
            let text = child(key).ok_or_else(|| refuse(format!("no <{key}> in the material")))?;
            numbers(program, &[text])?.first().copied().ok_or_else(|| refuse(format!("<{key}> is empty")))
        };
        let kind = material.attribute("type").unwrap_or("");
        let (law, constants) = match kind {
            "neo-Hookean" => {
                let given: Values =
                    [("E".to_string(), value("E")? * scale), ("nu".to_string(), value("v")?)].into_iter().collect();
                let hooke = Moduli::from_map(&given)?;
                let (constants, kappa) = (vec![hooke.mu], hooke.kappa);
                let energy = Energy { law: COUPLED.into(), constants, kappa, volumetric: None };
                return Ok(with_rest(energy, material, &["E", "v"]));
            }
            "Mooney-Rivlin" => ("mooney_rivlin", vec![value("c1")? * scale, value("c2")? * scale]),
            "Veronda-Westmann" => ("veronda_westmann", vec![value("c1")? * scale, value("c2")?]),
            "Gent" => ("gent", vec![value("G")? * scale, value("Jm")?]),
            "Ogden" => {
                let mut constants = vec![];
                for n in (1..=6).filter(|n| child(&format!("c{n}")).is_some()) {
                    constants.extend([value(&format!("c{n}"))? * scale, value(&format!("m{n}"))?]);
                }
                let count = constants.len() / 2;
                if !(1..=4).contains(&count) {
                    return Err(refuse(format!("{count} terms of Ogden's law; Durometer has 1 to 4")));
                }
                (OGDEN, constants)
            }
            "Ogden unconstrained" => {
                let used: Vec<&str> = TERMS.into_iter().chain(["cp"]).collect();
                return Ok(with_rest(foam::read_febio(material, scale)?, material, &used));
            }
            other => return Err(refuse(format!("type \"{other}\" is no law that Durometer reads"))),
        };
        // FEBio uses its first volumetric part if none is given
        let model = child("pressure_model").map_or("0", str::trim);
        let volumetric = match model {
            "0" | "default" => PRESSURE[0],
            "1" | "NIKE3D" => PRESSURE[1],
            "2" | "Abaqus" => PRESSURE[2],
            other => return Err(refuse(format!("pressure_model \"{other}\" is not known"))),
        };
        let energy = Energy { law: law.into(), constants, kappa: value("k")? * scale, volumetric: Some(volumetric) };
        let own: &[&str] = match kind {
            "Ogden" => &TERMS,
            "Gent" => &["G", "Jm"],
            _ => &["c1", "c2"],
        };
        Ok(with_rest(energy, material, &[own, &["k", "pressure_model"]].concat()))
    })
}

/// Elements of FEBio with the terms of Ogden's law.
const TERMS: [&str; 12] = ["c1", "m1", "c2", "m2", "c3", "m3", "c4", "m4", "c5", "m5", "c6", "m6"];

/// A law together with the elements of its material that are neither used nor the density, and the load curves of the used ones.
fn with_rest(energy: Energy, material: Node, used: &[&str]) -> Imported {
    let of = |n: Node| {
        let name = n.tag_name().name();
        match n.attribute("lc") {
            _ if name == "density" => None,
            _ if !used.contains(&name) => Some(format!("<{name}>")),
            curve => curve.map(|_| format!("the load curve of <{name}>")),
        }
    };
    let passed_over = material.children().filter(Node::is_element).filter_map(of).collect();
    Imported { passed_over, ..energy.into() }
}

/// Reads the first component of SOFA with a `materialName`.
pub fn read_sofa(text: &str, scale: f64) -> Result<Energy, KeywordError> {
    let program = Program::Sofa;
    let refuse = |what: String| KeywordError::Unreadable { program, what };
    with_document(program, text, |document| {
        let found =
            document.descendants().find_map(|n| Some((n.attribute("materialName")?, n.attribute("ParameterSet")?)));
        let (name, set) = found.ok_or_else(|| refuse("no component with materialName and ParameterSet".into()))?;
        let values = numbers(program, &set.split_whitespace().collect::<Vec<_>>())?;
        let split = Some(VolumetricKind::Logarithmic);
        match (name, &values[..]) {
            ("NeoHookean", [mu, lambda]) => {
                let given: Values =
                    [("mu".to_string(), mu * scale), ("lambda".to_string(), lambda * scale)].into_iter().collect();
                let hooke = Moduli::from_map(&given).map_err(|e: LawSpecError| e)?;
                Ok(Energy { law: COUPLED.into(), constants: vec![hooke.mu], kappa: hooke.kappa, volumetric: None })
            }
            ("MooneyRivlin", [c10, c01, kappa]) => Ok(Energy {
                law: "mooney_rivlin".into(),
                constants: vec![c10 * scale, c01 * scale],
                kappa: kappa * scale,
                volumetric: split,
            }),
            ("Ogden", [mu, alpha, kappa]) => Ok(Energy {
                law: OGDEN.into(),
                constants: vec![mu * scale, *alpha],
                kappa: kappa * scale,
                volumetric: split,
            }),
            _ => Err(refuse(format!(
                "materialName \"{name}\" with {} constants is no law that Durometer reads",
                values.len()
            ))),
        }
    })
}
