//! The programs for which laws are written and from which they are read.

use std::str::FromStr;

/// A program whose input can hold a law.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Program {
    Abaqus,
    Calculix,
    Ansys,
    Febio,
    Sofa,
}

impl Program {
    pub const ALL: [Self; 5] = [Self::Abaqus, Self::Calculix, Self::Ansys, Self::Febio, Self::Sofa];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Abaqus => "abaqus",
            Self::Calculix => "calculix",
            Self::Ansys => "ansys",
            Self::Febio => "febio",
            Self::Sofa => "sofa",
        }
    }

    /// A comment line in the syntax of the program.
    pub fn comment(self, text: &str) -> String {
        match self {
            Self::Abaqus | Self::Calculix => format!("** {text}\n"),
            Self::Ansys => format!("! {text}\n"),
            Self::Febio | Self::Sofa => format!("<!-- {} -->\n", text.replace("--", "- -")),
        }
    }
}

impl FromStr for Program {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|p| p.name() == word)
            .ok_or_else(|| format!("\"{word}\" is not a program; known: {}", Self::ALL.map(Self::name).join(", ")))
    }
}
