"""Invalid requests: exit code 2, a message that names the place, a remedy."""

import json

from .common import Case, defaults


class Requests(Case):
    def test_not_json(self):
        code, answer = self.send("{body: finger")
        self.assertEqual((code, "not JSON" in answer["error"]), (2, True))
        self.assertEqual(self.send("[]")[0], 2)
        self.assertEqual(self.send(json.dumps({"body": ["finger"]}))[0], 2)

    def test_unknown_names(self):
        self.refused(2, "did you mean finger?", "fingr", {}, size={"length": 0.01})
        self.refused(2, "did you mean length?", "finger", size={"lenght": 0.01})
        self.refused(2, "did you mean tip_radius?", "finger", defaults("finger", tip_radus=0.1), size={"length": 0.01})
        self.refused(2, "unknown", "finger", size={"length": 0.01}, generator="netgen")
        self.refused(2, "did you mean optimise?", "finger", size={"length": 0.01}, optimize=True)
        self.refused(2, "did you mean facet_size?", "finger", size={"length": 0.01}, generator="cgal", cgal={"facet_sise": 1})

    def test_sizes(self):
        self.refused(2, "no size", "finger")
        self.refused(2, "both", "finger", size={"length": 0.01, "cells": 100})
        self.refused(2, "positive", "finger", size={"length": 0})
        self.refused(2, "at least 1", "finger", size={"cells": 0})
        self.refused(2, "order", "finger", size={"length": 0.01}, order=3)
        self.refused(2, "grading", "finger", size={"length": 0.01}, grading={"feature": "tip"})
        self.refused(2, "version", "finger", size={"length": 0.01}, version=2)
        self.refused(2, "only order 1", "finger", size={"length": 0.01}, generator="cgal", order=2)
        self.refused(2, "generator is gmsh", "finger", size={"length": 0.01}, cgal={"odt": True})
        self.refused(3, "not reached", "block", size={"cells": 3, "tolerance": 0.001})
        for cells in (3, 29):
            self.refused(3, "ask for cells = 24", "block", size={"cells": cells, "tolerance": 0.001})
        self.assertEqual(self.made("block", size={"cells": 24, "tolerance": 0.001})["cells"], 24)

    def test_size_fields(self):
        size, points = {"length": 0.01}, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        field = {"points": points, "cells": [[0, 1, 2, 3]], "sizes": [1, 1, 1, 1]}
        self.refused(2, "not positive", "block", size=size, field=field | {"sizes": [1, 1, 1, 0]})
        self.refused(2, "one size for each point", "block", size=size, field=field | {"sizes": [1, 1]})
        self.refused(2, "one size for each point", "block", size=size, field=field | {"cells": [[0, 1, 2, 4]]})
        self.refused(2, "not complete", "block", size=size, field={"points": points})
        self.refused(2, "only order 1", "block", size=size, field=field, generator="cgal")

    def test_impossible_parameters(self):
        size = {"length": 0.01}
        for body, changes, words in [
            ("finger", {"notch_depth": 0.025}, "notch_depth must be smaller than height"),
            ("finger", {"notch_fillet": 0.005}, "half of notch_width"),
            ("finger", {"tip_radius": 0.011}, "tip_radius"),
            ("finger", {"notch_width": 0.04}, "leave no room"),
            ("finger", {"phalanges": 2.5}, "whole number"),
            ("finger", {"length": -1}, "must be positive"),
            ("finger", {"length": 0}, "parameter length = 0 must be positive"),
            ("block", {"lx": 0.0}, "parameter lx = 0 must be positive"),
            ("finger", {"width": "20 mm"}, "not a number"),
            ("finger", {"cable_height": 0.03}, "cable_height"),
            ("dumbbell", {"grip_distance": 0.12}, "smaller than length"),
            ("dumbbell", {"grip_width": 0.005}, "radii"),
            ("thick_sphere", {"inner_radius": 0.03}, "inner_radius"),
        ]:
            self.refused(2, words, body, defaults(body) | changes, size=size)
        missing = defaults("finger")
        del missing["width"]
        self.refused(2, "missing parameters width", "finger", missing, size=size)

    def test_output(self):
        self.refused(2, "must end in", "block", name="mesh.vtk", size={"length": 0.05})
        self.refused(3, "cannot write", "block", name="../../dev/null/x/mesh.msh", size={"length": 0.05})
