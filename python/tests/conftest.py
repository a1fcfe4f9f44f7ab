"""Scenes that the tests share."""

import subprocess
import sys

import durometer
import pytest

#: A beam of 16 boxes under its own weight
BEAM = """
[mesh]
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [4, 2, 2] }

[laws.silicone]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45

[[effect]]
kind = "elastic"
region = "body"
law = "silicone"

[[effect]]
kind = "gravity"
region = "body"
density = "1070 kg/m^3"
direction = [0, 0, -1]
acceleration = "9.81 m/s^2"

[[constraint]]
kind = "fixed"
region = "xmin"

[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"

[[probe]]
kind = "position"
region = "xmax"

[[probe]]
kind = "reaction"
region = "xmin"

[[probe]]
kind = "energy"
"""

#: The same beam, pulled at its end by a signal
PULLED = BEAM + """
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = { kind = "ramp", from = "0 mm", to = "2 mm", end = "1 s" }
"""

#: A longer beam of a nearly incompressible material, for which four-node elements are too stiff
LOCKED = BEAM.replace("nu = 0.45", "nu = 0.4995").replace("divisions = [4, 2, 2]", "divisions = [6, 2, 2]").replace('"20 mm", "10 mm", "10 mm"', '"60 mm", "10 mm", "10 mm"')

#: A finger on a mesh that comes with the package; its error is above the tolerance, and there is no other mesh
REFINED = """
[mesh]
body = "finger"
cells = 1150
refine = { quantity = "tip_z_m", tolerance = "0.01 %", meshes = 1 }

[laws.silicone]
law = "neo_hookean"
E = "1 MPa"
nu = 0.45

[[effect]]
kind = "elastic"
region = "body"
law = "silicone"

[[effect]]
kind = "gravity"
region = "body"
density = "1070 kg/m^3"
direction = [0, 0, -1]
acceleration = "9.81 m/s^2"

[[constraint]]
kind = "fixed"
region = "root"

[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"

[[probe]]
kind = "position"
region = "tip"
"""


@pytest.fixture
def beam() -> durometer.Scene:
    return durometer.Scene.from_toml(BEAM)


@pytest.fixture
def pulled() -> durometer.Scene:
    return durometer.Scene.from_toml(PULLED)


def program(*arguments: object, **options: object) -> subprocess.CompletedProcess:
    """The command line in a process of its own."""
    command = [sys.executable, "-P", "-m", "durometer", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, **options)
