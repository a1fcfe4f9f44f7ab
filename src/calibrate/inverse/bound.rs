//! The bound of a constant that holds it at the end of a search.

use serde::{Deserialize, Serialize};

/// The bound at which a constant is held; files store it as a number: −1 for the lower bound, 1 for the upper one, 0 if it is free.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "i8", try_from = "i8")]
pub enum Bound {
    Free,
    Lower,
    Upper,
}

impl Bound {
    pub fn is_free(self) -> bool {
        self == Self::Free
    }
}

impl From<Bound> for i8 {
    fn from(bound: Bound) -> Self {
        match bound {
            Bound::Lower => -1,
            Bound::Free => 0,
            Bound::Upper => 1,
        }
    }
}

impl TryFrom<i8> for Bound {
    type Error = String;
    fn try_from(number: i8) -> Result<Self, String> {
        match number {
            -1 => Ok(Self::Lower),
            0 => Ok(Self::Free),
            1 => Ok(Self::Upper),
            other => Err(format!("{other} is no bound of a constant; -1 is the lower one, 1 the upper one, 0 none")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_have_a_number() {
        let all = [Bound::Lower, Bound::Free, Bound::Upper];
        assert_eq!(serde_json::to_string(&all).expect("numbers"), "[-1,0,1]");
        assert_eq!(serde_json::from_str::<[Bound; 3]>("[-1, 0, 1]").expect("the same"), all);
        let refused = serde_json::from_str::<Bound>("2").expect_err("no bound").to_string();
        assert!(refused.contains("2 is no bound"), "{refused}");
    }
}
