"""Keywords of Abaqus input and their options by what a file has of them: blanks and capital letters do not count, and both may be abbreviated.

As many letters are wanted as tell a word from the others that begin in the same way (Abaqus 6.6, Analysis User's Manual, 1.2.1 "Input syntax rules").
Names are those of the Keywords Reference Manual of that version, and some of later ones."""

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
# Keywords of which another option could change the nodes and cells that are meant
STRICT = ("node", "nset", "element", "elset")
# Keywords that make nodes and elements of others
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
    """A word that several others begin with, which are in its text."""


def keyword(word: str) -> str:
    """The keyword that is meant, in small letters; one that is not known is returned without blanks."""
    return meant(word, (*OPTIONS, *GENERATORS), OTHERS) or squeezed(word)


def option(word: str, of: str) -> str | None:
    """The option of a keyword that is meant; none where it has no such option, and the word itself of keywords that are not read."""
    return meant(word, OPTIONS[of]) if of in OPTIONS else squeezed(word)


def meant(word: str, read: tuple, others: tuple = ()) -> str | None:
    """The one of some words that begins with `word`, or the one with which all that do begin; none where none does."""
    short = squeezed(word)
    found = sorted((known for known in (*read, *others) if short and squeezed(known).startswith(short)), key=len)
    if not found or all(squeezed(known).startswith(squeezed(found[0])) for known in found):
        return found[0] if found else None
    if any(known in read for known in found):
        raise Unclear(", ".join(known.upper() for known in found))
    return found[0]


def squeezed(word: str) -> str:
    """A word in small letters without blanks."""
    return "".join(word.lower().split())
