"""Controllers in Python: a function at every point of the time grid."""

import types
from collections.abc import Callable

import durometer
import numpy
import pytest
from conftest import BEAM

SCENE = """
[mesh]
grid = { kind = "box", size = ["60 mm", "10 mm", "10 mm"], divisions = [12, 2, 2] }

[laws.silicone]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45

[[effect]]
kind = "elastic"
region = "body"
law = "silicone"

[[constraint]]
kind = "fixed"
region = "xmin"

[[constraint]]
kind = "cable"
guides = [["5 mm", "5 mm", "2.5 mm"], ["30 mm", "5 mm", "2.5 mm"], ["55 mm", "5 mm", "2.5 mm"]]
pull_point = ["-10 mm", "5 mm", "2.5 mm"]
guide_radius = "2 mm"
drive = { kind = "length", signal = { kind = "controlled", initial = "0 mm" } }

[[stage]]
integrator = "static"
duration = "4 s"
dt = "0.25 s"

[[probe]]
kind = "bending_angle"
root = "xmin"
tip = "xmax"
"""


@pytest.fixture
def bent() -> durometer.Scene:
    return durometer.Scene.from_toml(SCENE)


def test_the_loop_reaches_its_target(bent: durometer.Scene) -> None:
    [signal] = bent.controlled
    seen = []

    def integrating(now: durometer.Observation) -> float:
        seen.append((now.t, now.next, now["bending_angle_deg"]))
        return now.signals[signal] + 1e-4 * (5.0 - now["bending_angle_deg"])

    run = bent.run(controller=integrating)
    assert abs(run["bending_angle_deg"][-1] - 5.0) < 0.1
    assert [row[2] for row in seen] == list(run["bending_angle_deg"][: len(seen)])
    assert [row[1] for row in seen[:-1]] == [row[0] for row in seen[1:]]
    by_name = bent.run(controller=lambda now: {signal: integrating(now)})
    assert by_name.values.tobytes() == run.values.tobytes()


def test_none_keeps_the_signal_and_stop_ends_the_run(bent: durometer.Scene) -> None:
    run = bent.run(controller=lambda now: now.stop() if now.t >= 1.0 else None)
    assert run.times[-1] == 1.0 and numpy.abs(run["bending_angle_deg"]).max() < 1e-3


@pytest.mark.parametrize(
    "controller, error, words",
    [
        (lambda now: 1 / 0, ZeroDivisionError, "division"),
        (lambda now: {"no_such": 1.0}, KeyError, "no signal no_such is controlled"),
        (lambda now: "12 mm", TypeError, "return numbers in SI units"),
        (lambda now: True, TypeError, "sets a signal to a bool; return numbers in SI units"),
        (lambda now: now.t < numpy.float64(1.0), TypeError, "sets a signal to a bool"),
        (lambda now: now["no_such"], KeyError, "no column no_such"),
    ],
    ids=["raises", "name", "type", "truth", "truth of numpy", "column"],
)
def test_wrong_answers_end_the_run(bent: durometer.Scene, controller, error, words: str) -> None:
    with pytest.raises(error, match=words):
        bent.run(controller=controller)


def test_a_scene_and_its_controller_belong_together(bent: durometer.Scene, beam: durometer.Scene) -> None:
    with pytest.raises(durometer.InputError, match="waits for a controller"):
        bent.run()
    with pytest.raises(durometer.InputError, match="leaves no signal to a controller"):
        beam.run(controller=lambda now: None)
    with pytest.raises(durometer.InputError, match="cannot be called"):
        bent.run(controller=3)


def test_an_answer_is_any_mapping_or_number_of_numpy(bent: durometer.Scene) -> None:
    [signal] = bent.controlled
    expected = bent.run(controller=lambda now: 1e-4).values.tobytes()
    for answer in (types.MappingProxyType({signal: 1e-4}), {signal: numpy.float64(1e-4)}, numpy.float64(1e-4)):
        assert bent.run(controller=lambda now: answer).values.tobytes() == expected


@pytest.mark.parametrize("answer, words", [(float("nan"), "is NaN at t"), (0.1, "its `range` is from 0 to 0.005")], ids=["nan", "range"])
def test_a_bad_answer_leaves_the_rows_so_far(bent: durometer.Scene, answer: float, words: str) -> None:
    ranged = bent.set("constraint.cable.drive.signal", {"kind": "controlled", "initial": "0 mm", "range": ["0 mm", "5 mm"]})
    control = lambda now: answer if now.t >= 0.5 else None  # noqa: E731
    with pytest.raises(durometer.RunError, match=words) as caught:
        ranged.run(controller=control)
    partial = caught.value.result
    assert partial.times[-1] == 0.5 and not partial.converged and partial.status == caught.value.status == "Interrupted"
    unchecked = ranged.run(controller=control, check=False)
    assert len(unchecked) == len(partial) and unchecked.fact == caught.value.fact and unchecked.remedy == caught.value.remedy
    assert "formula" not in unchecked.remedy


@pytest.mark.parametrize("kind", [ZeroDivisionError, KeyboardInterrupt])
def test_an_exception_has_the_rows_so_far(bent: durometer.Scene, kind: type[BaseException]) -> None:
    def control(now: durometer.Observation) -> None:
        if now.t >= 0.5:
            raise kind("of the user")

    with pytest.raises(kind, match="of the user") as caught:
        bent.run(controller=control, check=False)
    partial = caught.value.result
    assert isinstance(partial, durometer.Run) and partial.times[-1] == 0.5 and partial.status == "Interrupted"


def test_a_run_that_is_stopped_ends_the_line_of_its_bar(bent: durometer.Scene, capsys: pytest.CaptureFixture) -> None:
    def stopping(now: durometer.Observation) -> None:
        if now.t >= 0.5:
            now.stop()

    assert bent.run(controller=stopping, progress=True).converged
    drawn = capsys.readouterr().err
    assert drawn.count("\n") == 1 and drawn.endswith("s\n")


def test_the_result_of_an_exception_is_that_of_the_call_that_raised_it(bent: durometer.Scene) -> None:
    kept = ValueError("one object for all runs")
    failing = durometer.Scene.from_toml(BEAM).set("constraint.0.components", "y")

    def raising(end: float, inner: bool) -> Callable[[durometer.Observation], None]:
        def control(now: durometer.Observation) -> None:
            if now.t >= end:
                if inner:
                    failing.run()
                raise kept

        return control

    for inner, kind in [(False, ValueError), (True, durometer.RunError)]:
        for end in (0.5, 1.0):
            with pytest.raises(kind) as raised:
                bent.run(controller=raising(end, inner))
            assert raised.value.result.columns == bent.columns and raised.value.result.times[-1] == end
