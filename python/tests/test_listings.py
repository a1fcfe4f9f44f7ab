"""The listings of the guide and the notebooks run."""

import re
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

ROOT = Path(__file__).resolve().parents[2]
GUIDE = ROOT / "docs/how-to/use-from-python.md"
NOTEBOOKS = sorted((ROOT / "python/notebooks").glob("*.ipynb"))


def test_the_listings_of_the_guide_run_one_after_the_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.chdir(tmp_path)
    listings = re.findall(r"^```python\n(.*?)^```", GUIDE.read_text(), re.MULTILINE | re.DOTALL)
    assert len(listings) > 5
    names: dict[str, object] = {}
    for listing in listings:
        exec(compile(listing, str(GUIDE), "exec"), names)
        # A listing that prints nothing has not reached its print call
        assert capsys.readouterr().out or "print(" not in listing, listing


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_a_notebook_runs(file: Path, tmp_path: Path) -> None:
    notebook = nbformat.read(file, as_version=4)
    outputs = [cell for cell in notebook.cells if cell.cell_type == "code" and cell.outputs]
    assert not outputs, "notebooks are stored without outputs"
    NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()


def test_there_are_notebooks_of_every_kind() -> None:
    assert [file.stem for file in NOTEBOOKS] == ["calibration", "controller-loop", "convergence", "design-by-gradient", "design-sweep"]
