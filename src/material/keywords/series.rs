//! A law together with its relaxation: `*VISCOELASTIC` of Abaqus.
//!
//! Every line has g_i, k_i and τ_i: shares of the instantaneous shear and bulk modulus, and the time. `MODULI` of the law says which moduli its
//! constants give, by default the long-term ones (*Abaqus Keywords Reference Guide*, `*VISCOELASTIC` and `*HYPERELASTIC`). The shares are those of
//! the effect `viscoelastic`, which does not relax the bulk modulus: k_i has to be zero. Instantaneous constants are converted to long-term ones by
//! the factor 1 − Σ g_i.

use super::cards::{Card, options};
use super::energy::{Energy, FOAM};
use super::error::KeywordError;
use super::program::Program;

/// The content of an input file.
#[derive(Clone, PartialEq, Debug)]
pub struct Imported {
    /// The law, with long-term constants if it relaxes
    pub energy: Energy,
    /// Share g \[–\] of the instantaneous shear modulus and relaxation time τ \[s\] of each term
    pub series: Vec<(f64, f64)>,
    /// Keywords, commands or elements of the material that change its response and were not read
    pub passed_over: Vec<String>,
}

impl From<Energy> for Imported {
    fn from(energy: Energy) -> Self {
        Self { energy, series: vec![], passed_over: vec![] }
    }
}

/// The law at this index of the keywords of its material, together with the relaxation among them.
pub fn with_relaxation(
    energy: Energy,
    material: &[Card],
    law: usize,
    program: Program,
) -> Result<Imported, KeywordError> {
    let refuse = |what: String| Err(KeywordError::Unreadable { program, what });
    let head = material[law].head.as_str();
    let moduli = options(head).get("MODULI").map(|m| m.to_uppercase());
    let instantaneous = match moduli.as_deref() {
        None | Some("LONG TERM") => false,
        Some("INSTANTANEOUS") => true,
        Some(other) => return refuse(format!("MODULI={other} is neither INSTANTANEOUS nor LONG TERM")),
    };
    let Some(card) = material.iter().find(|c| c.is("*VISCOELASTIC")) else {
        if instantaneous {
            return refuse(format!(
                "\"{head}\" has the constants of the instantaneous response, and the material has no *VISCOELASTIC: add it, or leave out \
                 MODULI where the material does not relax"
            ));
        }
        return Ok(energy.into());
    };
    if energy.law == FOAM {
        return refuse(
            "the foam relaxes (*VISCOELASTIC), and the effect viscoelastic has no foams: leave the keyword out, and give the long-term constants".into(),
        );
    }
    let series = terms(card, program)?;
    let long = 1.0 - series.iter().map(|t| t.0).sum::<f64>();
    if long <= 0.0 {
        return refuse(format!(
            "the shares g of \"{}\" add up to {}: nothing is left in the long run",
            card.head,
            1.0 - long
        ));
    }
    let energy = if instantaneous { energy.scaled(long)? } else { energy };
    Ok(Imported { series, ..energy.into() })
}

/// Shares and times of `*VISCOELASTIC`.
fn terms(card: &Card, program: Program) -> Result<Vec<(f64, f64)>, KeywordError> {
    let refuse = |what: String| Err(KeywordError::Unreadable { program, what });
    let given = options(&card.head);
    if !["TIME", "FREQUENCY"].iter().any(|o| given.get(*o).is_some_and(|v| v.eq_ignore_ascii_case("PRONY"))) {
        return refuse(format!(
            "\"{}\" is no Prony series, which has TIME=PRONY: fit the data of the test by durometer prony, and leave the keyword out",
            card.head
        ));
    }
    let rows = card.rows(program)?;
    if rows.is_empty() {
        return refuse(format!("no numbers below \"{}\"", card.head));
    }
    let mut found = vec![];
    for row in rows {
        let &[g, k, tau] = &row[..] else {
            return refuse(format!("{} numbers in a line below \"{}\", g, k and tau are needed", row.len(), card.head));
        };
        if k != 0.0 {
            return refuse(format!(
                "the bulk modulus relaxes (k = {k} below \"{}\"), which no effect of Durometer has: where the material is nearly incompressible, set k to 0",
                card.head
            ));
        }
        if !(g > 0.0 && g < 1.0 && tau > 0.0) {
            return refuse(format!(
                "g = {g} with tau = {tau} below \"{}\": a share lies between 0 and 1, a time above 0",
                card.head
            ));
        }
        found.push((g, tau));
    }
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    Ok(found)
}
