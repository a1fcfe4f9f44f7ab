"""Recognition of keywords and options of Abaqus input: blanks and case do not count, and both may be abbreviated.

An abbreviation must be long enough to distinguish a word from others that begin in the same way (Abaqus 6.6, Analysis User's Manual, 1.2.1 "Input syntax rules").
The names are those of the Keywords Reference Manual of that version, and some of later versions."""

# Keyword that is read -> its options
OPTIONS = {
    "node": ("input", "nset", "system"),
    "nset": ("elset", "generate", "input", "instance", "internal", "nset", "unsorted"),
    "element": ("elset", "file", "input", "offset", "solid element numbering", "type"),
    "elset": ("elset", "generate", "input", "instance", "internal", "unsorted"),
    "surface": (
        "combine", "crop", "definition", "fillet radius", "input", "internal", "max ratio", "name", "no offset", "no thick", "property", "region type",
        "scale thick", "trim", "type",
    ),
    "part": ("name",), "end part": (), "assembly": ("name",), "end assembly": (), "instance": ("instance", "library", "name", "part"), "end instance": (),
    "system": (), "include": ("input", "password"),
}  # fmt: skip
# Keywords for which an unknown option could change nodes and cells
STRICT = ("node", "nset", "element", "elset")
# Keywords that generate nodes and elements from others
GENERATORS = ("ncopy", "ngen", "nfill", "nmap", "elcopy", "elgen")
# Other keywords that begin like these
OTHERS = (
    "amplitude", "el file", "el print", "elastic", "electrical conductivity", "electromagnetic", "element matrix output",
    "element operator output", "element output", "element property", "element recovery matrix", "element response", "end load case", "end step",
    "energy file", "energy output", "energy print", "enrichment", "enrichment activation", "imperfection", "incident wave", "incrementation output",
    "inelastic heat fraction", "inertia relief", "initial conditions", "integrated output", "integrated output section", "interface", "network stiffness",
    "no compression", "no tension", "nodal energy rate", "nodal thickness", "node file", "node output", "node print", "node response",
    "nonlinear bh", "nonstructural mass", "normal", "parameter", "parameter dependence", "parameter shape variation", "particle generator",
    "plastic", "step", "surface behavior", "surface flaw", "surface interaction", "surface property", "surface property assignment", "surface section",
    "surface smoothing", "symmetric model generation", "symmetric results transfer",
)  # fmt: skip


class Unclear(ValueError):
    """An ambiguous abbreviation; the message lists the words that begin with it."""


def keyword(word: str) -> str:
    """The keyword that is meant, in lower case; an unknown keyword is returned without blanks."""
    return meant(word, (*OPTIONS, *GENERATORS), OTHERS) or squeezed(word)


def option(word: str, of: str) -> str | None:
    """The option of a keyword that is meant; None if the keyword has no such option, and the word itself for keywords that are not read."""
    return meant(word, OPTIONS[of]) if of in OPTIONS else squeezed(word)


def meant(word: str, read: tuple, others: tuple = ()) -> str | None:
    """The only known word that begins with `word`, or the one that is a prefix of all that do; None if there is none."""
    short = squeezed(word)
    found = sorted((known for known in (*read, *others) if short and squeezed(known).startswith(short)), key=len)
    if not found or all(squeezed(known).startswith(squeezed(found[0])) for known in found):
        return found[0] if found else None
    if any(known in read for known in found):
        raise Unclear(", ".join(known.upper() for known in found))
    return found[0]


def squeezed(word: str) -> str:
    """A word in lower case without blanks."""
    return "".join(word.lower().split())
