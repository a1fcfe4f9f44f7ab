//! The regions of a scene that are shown one by one. If there are many, numbered faces of an import are shown only if the scene names them.

use durometer::mesh::Region;
use durometer::scene::Scene;

/// Number of regions from which on only faces that the scene names are shown.
const MANY: usize = 12;

/// Returns the number of a face that was named by an import, also within a part: 12 for `face_12` and `lower.face_12`.
pub fn number_of_face(name: &str) -> Option<u32> {
    name.rsplit('.').next()?.strip_prefix("face_")?.parse().ok()
}

/// Whether a region is the whole body or skin, also of a part.
pub fn is_whole(name: &str) -> bool {
    name.rsplit('.').next().is_some_and(|end| ["body", "skin"].contains(&end))
}

/// Returns the named regions that are shown, and those that are left out.
pub fn shown(scene: &Scene) -> [Vec<(&String, &Region)>; 2] {
    let is_named = |name: &str| scene.text.contains(&format!("\"{name}\""));
    let all = scene.regions.iter();
    let few = scene.regions.keys().filter(|name| !is_whole(name)).count() <= MANY;
    let (shown, left_out) = all.partition(|(name, _)| few || number_of_face(name).is_none() || is_named(name));
    [shown, left_out]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_of_parts_have_numbers() {
        let found = ["face_12", "lower.face_3", "a.b.face_4", "surface", "face_top", "lower.face_"].map(number_of_face);
        assert_eq!(found, [Some(12), Some(3), Some(4), None, None, None]);
    }
}
