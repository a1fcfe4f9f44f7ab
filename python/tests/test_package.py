"""The package itself: its version, its extras, its types and its documentation."""

import doctest
import inspect
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import durometer
import pytest

ROOT = Path(__file__).resolve().parents[2]


def test_extras_have_the_versions_of_the_mesher() -> None:
    project = tomllib.loads((ROOT / "python/pyproject.toml").read_text())
    pinned = (ROOT / "meshes/meshgen/requirements.txt").read_text().split()
    assert sorted(project["project"]["optional-dependencies"]["mesh"]) == sorted(pinned)


def test_the_version_is_that_of_the_workspace() -> None:
    workspace = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]
    assert durometer.__version__ == workspace["version"]


def test_a_library_of_another_version_is_refused() -> None:
    code = """
import sys, types
version = types.ModuleType("durometer._version")
version.VERSION = "0.0.0"
sys.modules["durometer._version"] = version
import durometer
"""
    told = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, timeout=60)
    assert told.returncode == 1 and "pip install --force-reinstall durometer" in told.stderr


def test_importing_the_package_takes_neither_numpy_nor_pandas() -> None:
    # numpy starts threads, which Ctrl-C would end together with the process: the program must be alone when it says what Ctrl-C means
    code = "import durometer.__main__, sys; raise SystemExit(len({'numpy', 'pandas'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-P", "-c", code], timeout=60).returncode == 0


def members() -> list[tuple[str, object]]:
    """Public classes and functions with their public members."""
    found: list[tuple[str, object]] = []
    for name in durometer.__all__:
        item = getattr(durometer, name)
        found.append((name, item))
        if inspect.isclass(item):
            own = [(k, v) for k, v in sorted(vars(item).items()) if not k.startswith("_")]
            found += [(f"{name}.{k}", getattr(item, k)) for k, v in own if callable(v) or inspect.isdatadescriptor(v)]
    return found


@pytest.mark.parametrize("name, item", members(), ids=[name for name, _ in members()])
def test_everything_public_is_documented_and_its_examples_hold(name: str, item: object) -> None:
    text = inspect.getdoc(item)
    assert text and len(text) > 5, f"{name} has no documentation"
    assert "\\[" not in text, "help() shows what rustdoc takes"
    examples = doctest.DocTestParser().get_doctest(text, {"durometer": durometer}, name, None, 0)
    told: list[str] = []
    doctest.DocTestRunner(verbose=False).run(examples, out=told.append)
    assert not told, "".join(told)


def test_stubs_name_what_there_is() -> None:
    stub = (Path(durometer.__file__).parent / "_native.pyi").read_text()
    native = durometer._native
    for name in [n for n in dir(native) if not n.startswith("__")]:
        item = getattr(native, name)
        assert re.search(rf"^(class|def) {name}\b", stub, re.MULTILINE), f"{name} is not in the stubs"
        if inspect.isclass(item):
            [body] = re.findall(rf"^class {name}:\n((?:    .*\n|\n)*)", stub, re.MULTILINE)
            known = set(re.findall(r"def (\w+)|^    (\w+):", body, re.MULTILINE))
            named = {a or b for a, b in known}
            missing = {k for k in vars(item) if not k.startswith("_")} - named
            assert not missing, f"{name}: {missing} are not in the stubs"
            wrong = {k for k in named if not k.startswith("_") and not hasattr(item, k)}
            assert not wrong, f"{name} has no {wrong}"


def test_the_reference_names_everything_public() -> None:
    text = (ROOT / "docs/reference/python.md").read_text()
    missing = [name for name, _ in members() if not re.search(rf"\b{name.split('.')[-1]}\b", text)]
    assert not missing, f"docs/reference/python.md does not name {missing}"
