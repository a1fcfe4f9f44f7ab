//! Checks which cells of the body resist a deformation, and by which effect.

use super::builder::Builder;
use crate::mesh::error::point;
use crate::scene::error::SceneError;
use crate::scene::parts::effects::EffectSpec;
use std::collections::{BTreeMap, BTreeSet};

/// Checks that every cell that is not rigid has exactly one elastic effect, or more only if the file says that they add up.
pub(super) fn check_cover(builder: &mut Builder, specs: &[EffectSpec]) -> Result<(), SceneError> {
    let mesh = &builder.body.clone().mesh;
    // For each cell: the effects that resist its deformation, and whether another one does so in addition
    let (mut own, mut added) = (vec![vec![]; mesh.cell_count()], vec![false; mesh.cell_count()]);
    for (k, spec) in specs.iter().enumerate() {
        let Some((region, adds)) = spec.resists() else { continue };
        for &c in builder.cells(&format!("effect {}", k + 1), region)? {
            if adds {
                added[c as usize] = true;
            } else {
                own[c as usize].push(k);
            }
        }
    }
    let rigid: BTreeSet<u32> = builder.rigid_cells.iter().copied().collect();
    let is_rigid = |c: usize| rigid.contains(&(c as u32));
    let at = |c: usize| point(&mesh.position(c, [0.25; 3]));
    let bare: Vec<usize> = (0..own.len()).filter(|&c| own[c].is_empty() && !is_rigid(c)).collect();
    if let Some(&c) = bare.first() {
        let fact = format!("{} of {} cells have no elastic effect, one of them at {}", bare.len(), own.len(), at(c));
        let lone = bare.iter().filter(|&&c| added[c]).count();
        if lone > 0 {
            let fact = format!("{fact}; in {lone} of them an effect with overlap = \"add\" has nothing to add to");
            return Err(builder.content("effect", fact, "remove `overlap` where no other effect is elastic"));
        }
        let remedy =
            "give every cell a law: regions cover the body together (kind = \"complement\" is the rest of a region)";
        return Err(builder.content("effect", fact, remedy));
    }
    let mut shared: BTreeMap<&[usize], Vec<usize>> = BTreeMap::new();
    for (c, effects) in own.iter().enumerate().filter(|(_, effects)| effects.len() > 1) {
        shared.entry(effects).or_default().push(c);
    }
    if !shared.is_empty() {
        let list = shared.iter().map(|(effects, cells)| {
            let names: Vec<String> = effects.iter().map(|&k| format!("{} ({})", k + 1, specs[k].words())).collect();
            format!(
                "{} cells have the elastic effects {}, one of them at {}",
                cells.len(),
                names.join(" and "),
                at(cells[0])
            )
        });
        let remedy = "take regions that do not overlap (kind = \"complement\", \"difference\"), or write overlap = \"add\" in the \
                      effect whose stiffness is to be added to that of the other";
        return Err(builder.content("effect", list.collect::<Vec<_>>().join("; "), remedy));
    }
    let twice = added.iter().filter(|added| **added).count();
    if twice > 0 {
        builder
            .notes
            .push(format!("the stiffnesses of two elastic effects add up in {twice} cells (overlap = \"add\")"));
    }
    Ok(())
}
