"""The report of a study in the folder of its results."""

import csv
import html
import json
import os
from pathlib import Path
from typing import Any

from . import _native
from ._extras import extra
from .errors import InputError


class Report:
    """The report that the run of a study has written into a folder: `summary.json`, tables, figures and the page `index.html`."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        # The current folder of the session may change
        self.folder = Path(folder).absolute()
        file = self.folder / "summary.json"
        try:
            self.summary: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        except FileNotFoundError as missing:
            raise InputError(f"{file}: there is no report", "run the study, or name the folder of its results") from missing
        except ValueError as damaged:
            raise InputError(f"{file}: it is damaged ({damaged})", "write it anew: Report.write(folder)") from damaged

    @staticmethod
    def write(folder: str | os.PathLike[str]) -> "Report":
        """Analyses the stored results of a folder again and rewrites its report; nothing is solved."""
        _native.write_report(folder)
        return Report(folder)

    @property
    def path(self) -> Path:
        """Path of the page to open in a browser."""
        return self.folder / "index.html"

    @property
    def verdict(self) -> str:
        """The answer to the question of the study, or why the data support none."""
        return self.summary["verdict"]

    @property
    def warnings(self) -> list[str]:
        """Limits on the use of the numbers."""
        return self.summary["warnings"]

    @property
    def tables(self) -> list[str]:
        """Names of the tables."""
        return sorted(file.stem for file in (self.folder / "tables").glob("*.csv"))

    @property
    def figures(self) -> list[Path]:
        """Paths of the figures as PNG; SVG and PDF are next to them."""
        return sorted((self.folder / "figures").glob("*.png"))

    def rows(self, table: str) -> list[dict[str, str]]:
        """Returns the rows of a table, as text by column; a repeated heading gets a number, as in `table`: `at [s]`, `at [s].1`."""
        with self._table(table).open(encoding="utf-8", newline="") as file:
            lines = csv.reader(file)
            headings = different(next(lines, []))
            return [dict(zip(headings, line)) for line in lines if line]

    def table(self, table: str) -> Any:
        """Returns a table as a pandas table; a dash or an empty cell is a missing value, any other text is a value."""
        return extra("pandas", "pandas").read_csv(self._table(table), keep_default_na=False, na_values=["–", ""])

    def _table(self, name: str) -> Path:
        if name not in self.tables:
            remedy = f"known: {', '.join(self.tables)}" if self.tables else "it has no tables"
            raise InputError(f"the report has no table {name}", remedy)
        return self.folder / "tables" / f"{name}.csv"

    def __repr__(self) -> str:
        return f"<Report {self.summary['study']}: {self.verdict}>"

    def _repr_html_(self) -> str:
        verdict, path = html.escape(self.verdict), html.escape(str(self.path))
        return f"<p><b>{html.escape(self.summary['study'])}</b>: {verdict}</p><p><a href=\"{path}\">{path}</a></p>"


def different(headings: list[str]) -> list[str]:
    """Returns the headings, with the next free number appended to each repeated one."""
    found: list[str] = []
    for heading in headings:
        name, number = heading, 0
        while name in found:
            number += 1
            name = f"{heading}.{number}"
        found.append(name)
    return found
