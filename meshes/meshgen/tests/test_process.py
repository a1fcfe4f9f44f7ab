"""The command as the Rust side calls it: stdin, stdout, stderr, exit code."""

import json
import os
import subprocess
import sys

from .common import Case, defaults

from meshgen import bodies


class Process(Case):
    def call(self, text: str = "", *arguments: str):
        environment = os.environ | {"PYTHONPATH": str(bodies.HOME)}
        command = [sys.executable, "-m", "meshgen", *arguments]
        return subprocess.run(command, input=text, env=environment, capture_output=True, text=True, timeout=120)

    def test_request(self):
        request = {"body": "beam", "parameters": defaults("beam"), "size": {"length": 0.005}, "output": self.path("a.msh")}
        for generator in ("gmsh", "cgal"):
            done = self.call(json.dumps(request | {"generator": generator}))
            self.assertEqual((done.returncode, len(done.stdout.splitlines())), (0, 1), done.stderr)
            self.assertIn("cells", json.loads(done.stdout))
            self.assertIn("meshgen:", done.stderr)

    def test_refusal(self):
        done = self.call("{}")
        self.assertEqual((done.returncode, set(json.loads(done.stdout))), (2, {"error", "hint"}))

    def test_doctor(self):
        done = self.call("", "--doctor")
        answer = json.loads(done.stdout)
        self.assertTrue(answer["ok"])
        self.assertEqual(set(answer["versions"]), {"gmsh", "cgal", "meshio", "numpy"})
