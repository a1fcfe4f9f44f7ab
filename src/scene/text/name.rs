//! Names that a scene gives to its parts: they begin the names of columns, and occur in names of files.

/// The remedy for a name that is refused.
pub(crate) const REMEDY: &str = "use letters, digits, \"-\", \"_\" and \".\", with a letter, a digit or \"_\" first";

/// Whether a name can begin the name of a column, which must fit one cell of a table and not be taken for a formula, and can be part of a file name.
pub(crate) fn is_name(name: &str) -> bool {
    let first = |c: char| c.is_alphanumeric() || c == '_';
    name.starts_with(first) && name.chars().all(|c| first(c) || "-.".contains(c))
}

/// Whether a column can have this name, which may begin with the name of a region of a mesh file: it must be a single line that is not taken for a formula.
pub(in crate::scene) fn is_column(name: &str) -> bool {
    !name.starts_with(['=', '+', '-', '@']) && !name.chars().any(char::is_control)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_one_word_that_is_no_formula() {
        for name in ["tip", "Größe-2", "_PickedSet4", "arm.tendon", "2nd", "先端"] {
            assert!(is_name(name) && is_column(name), "{name}");
        }
        for name in ["", "x\ny", "=cmd|calc", "a b", "a,b", "a/b", "..", "-x", "\"q\"", "a\t"] {
            assert!(!is_name(name), "{name:?}");
        }
        assert!(is_column("top face_x_m") && !is_column("=cmd|calc_x_m") && !is_column("x\ny_1_x_m"));
    }
}
