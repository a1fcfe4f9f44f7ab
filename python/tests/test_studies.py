"""Studies: their cases, their run with progress, and the report that it leaves."""

import threading
from pathlib import Path

import durometer
import pytest
from conftest import BEAM

STUDY = """
kind = "convergence"
scene = "scene.toml"
question = "How far does the tip sink?"
expectation = "Less on fewer cells."
tolerance = "5 %"

[[variant]]
name = "weight"
label = "own weight"
quantity = [{ name = "xmax_z_m", label = "height of the tip", symbol = "z", unit = "m" }]

[[family]]
name = "sizes"
role = "sizes"
[family.members]
c2 = { "mesh.grid.divisions" = [2, 1, 1] }
c4 = { "mesh.grid.divisions" = [4, 2, 2] }
c8 = { "mesh.grid.divisions" = [8, 4, 4] }
"""

#: A reduced model, which is the result of its study
REDUCTION = """
kind = "reduction"
scene = "scene.toml"
question = "How far does the beam sink under any gravity?"
expectation = "Two modes are enough."
tolerance = "1 %"
training = 8
held_back = 12
modes = [2]

[[input]]
name = "gravity"
key = "effect.gravity.acceleration"
range = ["0 m/s^2", "10 m/s^2"]

[[quantity]]
name = "xmax_z_m"
label = "height"
symbol = "z"
unit = "m"
"""


@pytest.fixture
def study(tmp_path: Path) -> durometer.Study:
    folder = tmp_path / "a study"
    folder.mkdir()
    (folder / "scene.toml").write_text(BEAM)
    (folder / "study.toml").write_text(STUDY)
    return durometer.Study.load(folder)


def test_a_study_runs_and_reports(study: durometer.Study, tmp_path: Path) -> None:
    told: list[tuple[float, float]] = []
    report = study.run(tmp_path / "out", progress=lambda done, end: told.append((done, end)))
    assert told[-1] == (3.0, 3.0) and told == sorted(told)
    assert report.path.is_file() and report.summary["study"] == study.name == "a study"
    assert len(report.summary["cases"]) == len(study.cases) == 3
    assert report.verdict and report.tables and report.figures
    name = report.tables[0]
    assert len(report.table(name)) == len(report.rows(name))
    (report.folder / "tables" / "names.csv").write_text("member,value\nNA,–\nNone,2.5\n", encoding="utf-8")
    table = report.table("names")
    assert list(table["member"]) == ["NA", "None"] and table["value"].isna().tolist() == [True, False]
    twice = "case,t [s],z [m],t [s],t [s]\na,1,2,3,4\n\nb,5,6,7,8\n"
    (report.folder / "tables" / "twice.csv").write_text(twice, encoding="utf-8")
    rows = report.rows("twice")
    assert rows[1] == {"case": "b", "t [s]": "5", "z [m]": "6", "t [s].1": "7", "t [s].2": "8"} and len(rows) == 2
    assert list(report.table("twice").columns) == list(rows[0])
    with pytest.raises(durometer.InputError, match="no table no_such"):
        report.rows("no_such")
    again = durometer.Report.write(report.folder)
    assert again.summary == report.summary and again.verdict in again._repr_html_() or "&" in again._repr_html_()


def test_a_study_and_its_report_keep_their_folders(study: durometer.Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    loaded = durometer.Study.load("a study")
    report = loaded.run("out", only="c2")
    monkeypatch.chdir("elsewhere")
    assert loaded.file == study.file and report.path == tmp_path / "out" / "index.html"
    assert report.tables and report.figures and report.path.is_file() and report.rows(report.tables[0])
    assert loaded.run(tmp_path / "again", only="c2").summary["cases"]


def test_a_change_by_an_unknown_key_is_refused_when_the_study_is_loaded(study: durometer.Study) -> None:
    with pytest.raises(durometer.InputError, match="law `neo_hookean` has no parameter `Q`"):
        durometer.Study.load(study.file, {"laws.silicone.Q": 3})


def test_the_cases_are_the_same_in_processes_and_in_threads(study: durometer.Study, tmp_path: Path) -> None:
    reports = [study.run(tmp_path / kind, isolation=kind, only="c2") for kind in ["processes", "threads"]]
    probes = [[case["probes"] for case in report.summary["cases"]] for report in reports]
    assert probes[0] and probes[0] == probes[1]


def test_a_case_that_does_not_complete_is_an_exception_with_its_report(study: durometer.Study, tmp_path: Path) -> None:
    loose = durometer.Study.load(study.file, {"constraint.0.components": "y"})
    with pytest.raises(durometer.RunError, match="not complete: ") as caught:
        loose.run(tmp_path / "out", only="c2")
    assert caught.value.status == "Singular" and isinstance(caught.value.result, durometer.Report)
    report = loose.run(tmp_path / "out", only="c2", check=False)
    assert report.summary["cases"][0]["status"] == "Singular"


def test_a_law_in_python_runs_in_threads_and_its_exception_ends_the_study(tmp_path: Path) -> None:
    from test_laws import PythonNeoHookean

    class InStudy(PythonNeoHookean):
        name = "python_in_study"

        def stress(self, F):
            raise ZeroDivisionError("in the study")

    durometer.register_law(InStudy)
    (tmp_path / "scene.toml").write_text(BEAM.replace("neo_hookean", "python_in_study"))
    (tmp_path / "study.toml").write_text(STUDY)
    study = durometer.Study.load(tmp_path)
    with pytest.raises(ZeroDivisionError, match="in the study"):
        study.run(tmp_path / "out", only="c2", isolation="threads")


def test_an_exception_of_a_law_ends_its_own_study_only(tmp_path: Path) -> None:
    from test_laws import PythonNeoHookean

    begun, armed = threading.Event(), threading.Event()
    threads: list[int] = []

    class Buggy(PythonNeoHookean):
        name = "python_buggy"

        def __init__(self, **constants):
            super().__init__(**constants)
            self.fails = armed.is_set()
            if threading.current_thread() is threading.main_thread():
                return
            # The study looks at its cases in one thread, and computes them in another: the other study begins within the first case
            if threading.get_ident() not in threads:
                threads.append(threading.get_ident())
                if len(threads) == 2:
                    begun.clear()
                    other.start()
                    assert begun.wait(60)
                    armed.set()

        def stress(self, F):
            if self.fails:
                raise ZeroDivisionError("of its own study")
            return super().stress(F)

    class Fine(PythonNeoHookean):
        name = "python_fine"

        def stress(self, F):
            begun.set()
            return super().stress(F)

    studies = []
    for law in (Buggy, Fine):
        durometer.register_law(law)
        folder = tmp_path / law.name
        folder.mkdir()
        (folder / "scene.toml").write_text(BEAM.replace("neo_hookean", law.name))
        (folder / "study.toml").write_text(STUDY.replace("[8, 4, 4]", "[4, 1, 1]").replace("[4, 2, 2]", "[3, 1, 1]"))
        studies.append(durometer.Study.load(folder))
    ends: dict[str, str] = {}

    def work(study: durometer.Study) -> None:
        try:
            report = study.run(tmp_path / f"{study.name}-out", isolation="threads", jobs=1)
            ends[study.name] = " ".join(case["status"] for case in report.summary["cases"])
        except BaseException as error:
            ends[study.name] = type(error).__name__

    other = threading.Thread(target=work, args=(studies[1],))
    work(studies[0])
    other.join()
    assert ends == {"python_buggy": "ZeroDivisionError", "python_fine": "Converged Converged Converged"}


def test_results_of_a_law_in_python_are_computed_again(tmp_path: Path) -> None:
    from test_laws import PythonNeoHookean

    def softer(by: float) -> type[durometer.Law]:
        class Edited(PythonNeoHookean):
            name = "python_edited"

            def energy(self, F):
                return by * super().energy(F)

            def stress(self, F):
                return by * super().stress(F)

            def tangent(self, F):
                return by * super().tangent(F)

        return Edited

    (tmp_path / "scene.toml").write_text(BEAM.replace("neo_hookean", "python_edited"))
    (tmp_path / "study.toml").write_text(STUDY)
    heights = []
    for by in (1.0, 0.5):
        durometer.register_law(softer(by))
        report = durometer.Study.load(tmp_path).run(tmp_path / "out", only="c2", isolation="threads")
        heights.append(report.summary["cases"][0]["probes"]["xmax_z_m"]["final"])
        own = durometer.Scene.from_toml(tmp_path / "scene.toml").set("mesh.grid.divisions", [2, 1, 1]).run()
        assert heights[-1] == pytest.approx(own["xmax_z_m"][-1], abs=1e-9)
    assert heights[1] < heights[0] - 1e-5


def test_a_law_in_python_is_not_known_in_other_processes(tmp_path: Path) -> None:
    from test_laws import PythonNeoHookean

    class InThisProcess(PythonNeoHookean):
        name = "python_in_this_process"

    durometer.register_law(InThisProcess)
    (tmp_path / "scene.toml").write_text(BEAM.replace("neo_hookean", "python_in_this_process"))
    (tmp_path / "study.toml").write_text(STUDY)
    study = durometer.Study.load(tmp_path)
    with pytest.raises(durometer.InputError, match="no law `python_in_this_process`"):
        study.run(tmp_path / "out", only="c2", isolation="processes")


def test_shipped_studies_are_known_by_name() -> None:
    study = durometer.Study.load("finger-convergence")
    assert study.kind == "convergence" and study.question and len(study.cases) > 10


def test_a_study_that_is_ended_leaves_its_records(study: durometer.Study, tmp_path: Path) -> None:
    def told(done: float, end: float) -> None:
        if done >= 1.0:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught:
        study.run(tmp_path / "out", jobs=1, progress=told)
    records = caught.value.result
    assert 1 <= len(records) < 3 and all(record["id"] == case for case, record in records.items())
    assert all(record["status"] == "Converged" for record in records.values())


def test_a_run_replaces_no_results_of_others(study: durometer.Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    report = study.run(only="c2", isolation="threads")
    before = {file: file.read_bytes() for file in report.folder.rglob("*") if file.is_file()}
    for name, out, words in [("a study", None, "has the same name"), ("another", report.folder, "would replace")]:
        folder = tmp_path / "elsewhere" / name
        folder.mkdir(parents=True)
        (folder / "scene.toml").write_text(BEAM.replace('"100 kPa"', '"70 kPa"'))
        (folder / "study.toml").write_text(STUDY)
        with pytest.raises(durometer.InputError, match=words) as refused:
            durometer.Study.load(folder).run(out, only="c2", isolation="threads")
        assert "as `out`" in refused.value.remedy
    assert {file: file.read_bytes() for file in report.folder.rglob("*") if file.is_file()} == before
    pulls = "".join(f"{1 + k / 20},{40 * (1 + k / 20 - (1 + k / 20) ** -2)}\n" for k in range(1, 12))
    (tmp_path / "pull.csv").write_text("stretch,stress_kPa\n" + pulls)
    fitted = ["fit", "pull.csv", "--law", "neo_hookean", "--mode", "uniaxial", "--nu", "0.45", "--out", "fitted"]
    assert durometer.main(fitted) == 0
    with pytest.raises(durometer.InputError, match="holds results of fit"):
        study.run("fitted", only="c2", isolation="threads")


def test_a_run_keeps_the_meshes_that_were_added(study: durometer.Study, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    (out / "extension.toml").write_text('[family.sizes]\nc6 = { "mesh.grid.divisions" = [6, 3, 3] }\n')
    for _ in range(2):
        report = study.run(out, isolation="threads")
        assert len(report.summary["cases"]) == len(study.cases) + 1
    assert any("c6" in case["id"] for case in report.summary["cases"])


def test_a_study_without_a_result_is_not_complete(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(BEAM)
    (tmp_path / "study.toml").write_text(REDUCTION)
    out = tmp_path / "out"
    out.mkdir()
    (out / "models").write_text("a file instead of the folder")
    with pytest.raises(durometer.RunError, match="not complete: ") as caught:
        durometer.Study.load(tmp_path).run(out, isolation="threads")
    assert caught.value.result.summary["without_result"] in caught.value.fact
