"""Tests of the Python package on a small body, run by tests/fast/python.rs.

A box of two cells per edge with a cubic hole: its wall is the tag `cavity`, its underside `seat`.
"""

import contextlib
import io
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import unittest

import numpy as np

import softpuffer as sp

# As at a terminal, also where SIGINT was ignored from the start, as in the background of a shell: Python then leaves it so.
signal.signal(signal.SIGINT, signal.default_int_handler)

SILICONE = {"kind": "mooney-rivlin-quadratic", "c1": 55e3, "c2": 5e3, "c3": 1.7e3, "d1": 1e6}
EDGE = 0.01
TRIANGLE = """solid wall
facet normal 0 0 1
outer loop
vertex 0 0 -1
vertex 1 0 -1
vertex 0 1 -1
endloop
endfacet
endsolid wall
"""


def box(cells=3):
    """A cube with a hole of a cell in the middle: vertices, tetrahedra and tags."""
    n = cells + 1
    grid = np.array([[x, y, z] for x in range(n) for y in range(n) for z in range(n)], dtype=float)
    number = lambda x, y, z: (x * n + y) * n + z
    # six tetrahedra of a cube around its diagonal
    paths = [(0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)]
    tets, middle = [], cells // 2
    for cell in np.ndindex(cells, cells, cells):
        if cell == (middle,) * 3:
            continue
        for path in paths:
            corner, tet = list(cell), [number(*cell)]
            for axis in path:
                corner[axis] += 1
                tet.append(number(*corner))
            tets.append(tet)
    tets = np.array(tets)
    used = np.unique(tets)
    place = np.full(len(grid), -1)
    place[used] = np.arange(len(used))
    vertices, tets = grid[used] * EDGE / cells, place[tets]
    facets = np.sort(np.concatenate([tets[:, [a, b, c]] for a, b, c in ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))]))
    facets, counts = np.unique(np.sort(facets, axis=1), axis=0, return_counts=True)
    skin = facets[counts == 1]
    at = vertices[skin]
    inside = np.all((at > 1e-9) & (at < EDGE - 1e-9), axis=(1, 2))
    seat = np.all(at[:, :, 2] < 1e-9, axis=1)
    top = np.all(at[:, :, 2] > EDGE - 1e-9, axis=1)
    return vertices, tets, {"seat": skin[seat], "cavity": skin[inside], "top": skin[top]}


def scene(**more):
    """The box, blown up."""
    tables = dict(
        material=SILICONE,
        fixed=["seat"],
        chambers={"cavity": 20e3},
        probes={"height": {"kind": "displacement", "on": "top", "axis": [0, 0, 1]}},
        degree=1,
        solver={"relative_tolerance": 1e-12},
    )
    return sp.Scene(sp.Body(*box()), **(tables | more))


def crossed():
    """Two boxes, of which one is pushed into the other without contact."""
    below, above = sp.Body(*box()), sp.Body(box()[0] + [0, 0, 1.2 * EDGE], *box()[1:])
    pushed = {"on": "above.top", "displacement": [0, 0, "-5e-3*t"]}
    return sp.Scene(
        {"below": below, "above": above},
        material=SILICONE,
        fixed=["below.seat", pushed],
        chambers={"below.cavity": 1e3, "above.cavity": 1e3},
        probes={"height": {"kind": "displacement", "on": "above.seat", "axis": [0, 0, 1]}},
        degree=1,
    )


def moving_scene():
    """The box, blown up in three time steps."""
    return scene(
        time={"method": "bdf2", "end": 0.02, "steps": 3},
        chambers={"cavity": "1e6*t"},
        material=SILICONE | {"density": 1070},
        uncertainty={"numbers": {"material.body.c1": 1e3}},
    )


class Bodies(unittest.TestCase):
    def test_a_body_comes_back_from_its_file(self):
        body = sp.Body(*box())
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "body.msh"
            body.write(path)
            again = sp.Body.read(path)
        np.testing.assert_array_equal(again.vertices, body.vertices)
        np.testing.assert_array_equal(again.tets, body.tets)
        self.assertEqual(list(again.tags), list(body.tags))
        for tag, facets in body.tags.items():
            np.testing.assert_array_equal(again.tags[tag], facets)

    def test_bad_arrays_are_refused_in_words(self):
        vertices, tets, tags = box()
        nan = vertices.copy()
        nan[3, 1] = np.nan
        for words, arrays in [
            ("vertices: an array of shape [64, 2], needed (n, 3)", (vertices[:, :2], tets, tags)),
            ("vertices: not an array of numbers", ("no numbers", tets, tags)),
            ("tets: an array of float64, needed integers", (vertices, tets + 0.5, tags)),
            ("index -1, needed 0 or more", (vertices, np.where(tets == 0, -1, tets), tags)),
            ("not finite", (nan, tets, tags)),
            ("which is not among", (vertices, tets + 40, tags)),
            ("are no facet of a tetrahedron", (vertices, tets, {"seat": [[0, 1, 63]]})),
            ("are no corner of a tetrahedron", (np.vstack([vertices, [[1, 1, 1]]]), tets, tags)),
        ]:
            with self.assertRaises(sp.InputError, msg=words) as caught:
                sp.Body(*arrays)
            self.assertIn(words, str(caught.exception))


class Scenes(unittest.TestCase):
    def test_a_scene_says_itself_as_toml(self):
        first = scene()
        first.set("chamber.cavity.pressure", 12e3)
        first.set("material.body.c1", 60e3)
        with tempfile.TemporaryDirectory() as folder:
            again = sp.load(first.write(folder))
        self.assertEqual(again.numbers, first.numbers)
        self.assertEqual(again.get("chamber.cavity.pressure"), 12e3)
        self.assertEqual(again.unit("material.body.c1"), "Pa")
        np.testing.assert_array_equal(again.simulate().displacement, first.simulate().displacement)

    def test_bad_input_has_the_words_of_the_programs(self):
        for words, more in [
            ('unknown tag "sea"', {"fixed": ["sea"]}),
            ("did you mean `pressure`?", {"chambers": {"cavity": {"presure": 1}}}),
            ("did you mean `gravity`?", {"gravty": [0, 0, -9.81]}),
            ("nothing moves the body", {"chambers": {}}),
            ('[[chamber]] on "cavity": unknown field `presure`', {"chambers": {"cavity": {"presure": 1}}}),
            ('unknown tag "lid"', {"probes": {"height": {"kind": "displacement", "on": "lid", "axis": [0, 0, 1]}}}),
            ("the scene has no such number", {"uncertainty": {"numbers": {"material.body.c9": 1}}}),
        ]:
            # where it is made, and without lines of a file that nobody wrote
            with self.assertRaises(sp.InputError, msg=words) as caught:
                scene(**more)
            self.assertIn(words, str(caught.exception))
            self.assertNotRegex(str(caught.exception), r"line \d|\^\^|:\d+:\d+")
        with self.assertRaises(sp.InputError) as caught:
            scene().set("material.body.c9", 1)
        self.assertIn("the scene has no such number; did you mean", str(caught.exception))
        with self.assertRaises(sp.InputError):
            scene().set("material.body.c1", float("nan"))
        other = scene()
        with self.assertRaises(sp.InputError) as caught:
            other.vertices = other.vertices[:-1]
        self.assertIn("63 vertices, but the scene has 64", str(caught.exception))
        flat = other.vertices
        flat[:, 2] = 0
        with self.assertRaises(sp.InputError):
            other.vertices = flat

    def test_values_of_numpy_tuples_and_paths_are_values(self):
        up = {"kind": "displacement", "on": "top", "axis": [0, 0, 1]}
        wall, heavy = {"name": "wall", "surface": "wall.stl"}, SILICONE | {"density": 1070}
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "wall.stl").write_text(TRIANGLE)
            plain, other = (
                scene(folder=folder, contact={}, **more)
                for more in [
                    {"gravity": [0, 0, -9.5], "obstacle": [wall], "material": heavy},
                    {
                        "gravity": (0, 0.0, np.float32(-9.5)),
                        "degree": np.int64(1),
                        "obstacle": [wall | {"surface": pathlib.Path("wall.stl")}],
                        "probes": {"height": up | {"on": np.str_("top"), "axis": np.array([0, 0, 1])}},
                        "material": heavy | {"c1": np.float64(55e3), "c2": np.array(5e3)},
                        "puffer": "0.1",
                    },
                ]
            )
            self.assertEqual(other.to_toml(), plain.to_toml())
        endless = {}
        endless["in"] = endless
        for words, more in [
            ("chamber 1 pressure: nan: must be finite", {"chambers": {"cavity": float("nan")}}),
            ("gravity 3: inf: must be finite", {"gravity": np.array([0, 0, np.inf])}),
            ("chamber 1 pressure: 1e-31: numbers are 0, or from", {"chambers": {"cavity": 1e-31}}),
            ("fixed 1 components: None: a scene has numbers", {"fixed": [{"on": "seat", "components": None}]}),
            ("material c1: <object", {"material": SILICONE | {"c1": object()}}),
            ("time: 32 lists and tables in each other", {"time": endless}),
            ("unknown field `include`", {"include": "other.toml"}),
        ]:
            with self.assertRaises(sp.InputError, msg=words) as caught:
                scene(**more)
            self.assertIn(words, str(caught.exception))

    def test_without_an_equilibrium_there_is_a_diagnosis(self):
        with self.assertRaises(sp.NoEquilibrium) as caught:
            scene(chambers={"cavity": 3e6}).simulate()
        self.assertIn("no equilibrium", str(caught.exception))

    def test_threads_may_share_a_scene(self):
        shared = scene()
        found = {}

        def work(k):
            found[k] = shared.simulate().displacement

        threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        self.assertEqual(len(found), 4)
        for k in range(1, 4):
            np.testing.assert_array_equal(found[k], found[0])

    def test_ctrl_c_ends_newton(self):
        calls = []

        def press(*said):
            calls.append(said)
            if len(calls) == 2:
                signal.raise_signal(signal.SIGINT)

        with self.assertRaises(KeyboardInterrupt):
            scene().simulate(progress=press)
        self.assertLess(len(calls), 5)

    def test_what_a_progress_raises_comes_back(self):
        def fail(*_):
            raise ZeroDivisionError("mine")

        with self.assertRaises(ZeroDivisionError):
            scene().simulate(progress=fail)


    def test_numbers_are_items_and_several_are_set_or_none(self):
        one = scene()
        one["chamber.cavity.pressure"] = 5e3
        self.assertEqual(one["chamber.cavity.pressure"], 5e3)
        one.set({"chamber.cavity.pressure": 6e3, "material.body.c1": 50e3})
        self.assertEqual((one["chamber.cavity.pressure"], one["material.body.c1"]), (6e3, 50e3))
        for bad in ({"material.body.c9": 1}, {"material.body.c1": -1e9}, {"material.body.c1": "soft"}):
            with self.assertRaises(sp.InputError):
                one.set({"chamber.cavity.pressure": 7e3, **bad})
        self.assertEqual((one["chamber.cavity.pressure"], one["material.body.c1"]), (6e3, 50e3))

    def test_the_law_of_the_docstring_is_one(self):
        law = sp.Scene.__doc__.split('{"kind"')[1].split("}")[0]
        self.assertEqual(scene(material=json.loads('{"kind"' + law + "}"), fixed="seat").probes, ["height"])

    def test_reprs_have_units(self):
        self.assertIn("chamber.cavity.pressure = 20000 Pa", repr(scene()))
        self.assertIn("10 × 10 × 10 mm, tags seat, cavity, top", repr(scene().body))


class Runs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = scene()
        cls.found = cls.scene.simulate()

    def test_a_run_knows_what_was_measured(self):
        run = self.found
        height = run.probe("height")
        self.assertGreater(height, 5e-6)
        top = np.unique(self.scene.body.tags["top"])
        self.assertLess(run.displacement[top, 2].min(), height)
        self.assertGreater(run.displacement[top, 2].max(), height)
        self.assertEqual(run.times[-1], 1)
        self.assertEqual(run.chambers["cavity"]["pressure"], 20e3)
        self.assertGreater(run.chambers["cavity"]["volume"], run.chambers["cavity"]["volume_rest"])
        self.assertEqual(run.stress(cells=True).shape, (len(self.scene.body.tets),))
        self.assertEqual(run.stress("cauchy_stress", cells=True).shape[1], 9)
        self.assertIn("kPa", run._repr_html_())
        self.assertIn("pressure of cavity 20 kPa", repr(run))
        self.assertEqual((run.unit("height"), run.scene.unit("chamber.cavity.pressure")), ("m", "Pa"))
        np.testing.assert_array_equal(run.elements, self.scene.body.tets)
        # in an order that has their outer side in front
        np.testing.assert_array_equal(np.sort(run.facets("top")), np.sort(self.scene.body.tags["top"]))
        self.assertEqual(scene(degree=2).simulate().facets("top").shape[1], 6)
        with self.assertRaises(sp.InputError):
            run.probe("hight")
        with self.assertRaises(sp.InputError):
            run.displacement_at(99)

    def test_a_run_is_saved(self):
        # the test in Rust compares with what the program makes of the scene in the folder
        asked = {"follow": "arc-length", "locking": "always", "relative_tolerance": 1e-12}
        path = scene(solver=asked, limit={}).simulate()
        for name, run in {"still": self.found, "moving": moving_scene().simulate(), "path": path}.items():
            folder = pathlib.Path(os.environ["PUFFER_SAVED"]) / name
            run.save(folder)
            np.testing.assert_array_equal(np.load(folder / "displacement.npy"), run.displacement)
            bars = run.error_bars
            self.assertEqual(bars, json.loads((folder / "report.json").read_text()).get("error_bars"))
            self.assertEqual(bars is None, name != "moving")

    def slope(self, change, value, derivative, step):
        """The order in which the remainder of a value falls: 2 where the derivative is right."""
        remainders = []
        for part in (1, 0.5):
            other = self.scene.copy()
            change(other, part * step)
            remainders.append(abs(value(other.simulate()) - self.value - part * step * derivative))
        return np.log2(remainders[0] / remainders[1])

    def test_gradients_pass_the_taylor_test(self):
        top = np.unique(self.scene.body.tags["top"])
        objective = lambda u: ((u[top, 2] - 1e-3) ** 2).sum() * 1e6
        value = lambda run: objective(run.displacement)
        names = ["shape", *(p for p in self.scene.numbers if not p.startswith("wall"))]
        self.value, by = self.found.gradient(objective, names)
        self.assertAlmostEqual(self.value, value(self.found), 12)
        direction = np.random.default_rng(1).uniform(-1, 1, by["shape"].shape) * 1e-4
        move = lambda other, part: setattr(other, "vertices", other.vertices + part * direction)
        self.assertAlmostEqual(self.slope(move, value, np.vdot(by["shape"], direction), 1.0), 2, delta=0.1)
        tested = 0
        for path in names[1:]:
            at = self.scene.get(path)
            change = lambda other, step: other.set(path, at + step)
            slope = self.slope(change, value, by[path], 0.05 * at)
            self.assertAlmostEqual(slope, 2, delta=0.1, msg=path)
            tested += 1
        self.assertGreaterEqual(tested, 5)

    def test_a_response_has_values_and_slopes(self):
        body = scene(traction=[{"on": "top", "traction": [0, 0, 0]}])
        path, push = "chamber.cavity.pressure", "traction.top.z"
        table = sp.response(body, {path: [10e3, 10.001e3, 9e9]}, by=[push])
        self.assertEqual(table.columns, [path, "height", f"d height/d {path}", f"d height/d {push}"])
        self.assertEqual(table.units, ["Pa", "m", "m/(Pa)", "m/(Pa)"])
        self.assertEqual(table.status, ["ok", "ok", "no equilibrium"])
        self.assertIn("3 rows, 2 of them usable: chamber.cavity.pressure [Pa], height [m]", repr(table))
        self.assertTrue(np.all(np.isnan(table.rows[2, 1:])))
        slope = (table["height"][1] - table["height"][0]) / 1.0
        self.assertAlmostEqual(table[f"d height/d {path}"][0] / slope, 1, 3)
        pushed = body.copy()
        pushed.set(path, 10e3)
        pushed.set(push, 1.0)
        rise = pushed.simulate().probe("height") - table["height"][0]
        self.assertAlmostEqual(table[f"d height/d {push}"][0] / rise, 1, 3)

    def test_the_gradient_of_a_probe_is_that_of_its_function(self):
        value, by = self.found.gradient("height", ["chamber.cavity.pressure", "wall.top"])
        self.assertEqual(self.found.gradient("height", "wall.top")[1], {"wall.top": by["wall.top"]})
        self.assertAlmostEqual(value, self.found.probe("height"), 15)
        self.value = value
        change = lambda other, step: other.set("chamber.cavity.pressure", 20e3 + step)
        measure = lambda run: run.probe("height")
        self.assertAlmostEqual(self.slope(change, measure, by["chamber.cavity.pressure"], 500), 2, delta=0.1)

    def test_a_derivative_of_ones_own(self):
        ones = np.zeros_like(self.found.displacement)
        ones[5, 2] = 1
        value, by = self.found.gradient(lambda u: u[5, 2], ["chamber.cavity.pressure"], derivative=lambda u: ones)
        _, same = self.found.gradient(lambda u: u[5, 2], ["chamber.cavity.pressure"])
        self.assertEqual(by, same)
        with self.assertRaises(sp.InputError):
            self.found.gradient(lambda u: 0.0, derivative=lambda u: ones[:-1])

    def test_through_time(self):
        moving = moving_scene()
        run = moving.simulate()
        self.assertEqual(len(run.times), 3)
        value, by = run.gradient(lambda u: (u[:, 5, 2] ** 2).sum() * 1e6, ["material.body.c1"], through_time=True)
        other = moving.copy()
        remainders = []
        for step in (2e3, 1e3):
            other.set("material.body.c1", 55e3 + step)
            found = other.simulate()
            u = np.stack([found.displacement_at(k) for k in range(3)])
            remainders.append(abs((u[:, 5, 2] ** 2).sum() * 1e6 - value - step * by["material.body.c1"]))
        self.assertAlmostEqual(np.log2(remainders[0] / remainders[1]), 2, delta=0.1)


class Starts(unittest.TestCase):
    """Runs that begin at another one."""

    @classmethod
    def setUpClass(cls):
        cls.scene = scene(solver={"relative_tolerance": 1e-10, "first_load_step": 0.25})
        cls.before = cls.scene.simulate()

    def test_a_neighbour_is_found_in_one_step_and_is_the_same(self):
        other = self.scene.copy()
        other.set("chamber.cavity.pressure", 22e3)
        other.vertices = other.vertices * 1.01
        anew, near = other.simulate(), other.simulate(start=self.before)
        self.assertEqual(len(near.times), 1)
        self.assertLess(near.newton_iterations, anew.newton_iterations)
        size = np.abs(anew.displacement).max()
        # equal to the tolerance of the forces, and moved by far more than that from the start
        self.assertLess(np.abs(near.displacement - anew.displacement).max(), 1e-7 * size)
        self.assertGreater(np.abs(near.displacement - self.before.displacement).max(), 1e-2 * size)
        slopes = [run.gradient("height", ["chamber.cavity.pressure"])[1] for run in (anew, near)]
        self.assertAlmostEqual(slopes[1]["chamber.cavity.pressure"] / slopes[0]["chamber.cavity.pressure"], 1, 6)

    def test_what_is_not_near_is_sought_from_rest(self):
        turned = self.scene.copy()
        turned.vertices = turned.vertices[:, ::-1] * [1, 1, -1]
        anew, near = turned.simulate(), turned.simulate(start=self.before)
        size = np.abs(anew.displacement).max()
        self.assertLess(np.abs(near.displacement - anew.displacement).max(), 1e-7 * size)

    def test_a_start_that_does_not_fit_is_refused(self):
        for words, other in [
            ("on another mesh: 156 tetrahedra of degree 1, and the scene has 156 tetrahedra of degree 2", scene(degree=2)),
            ("the scene goes through time", moving_scene()),
            ("depends on the way to it", scene(contact={"friction": 0.3})),
        ]:
            with self.assertRaises(sp.InputError, msg=words) as caught:
                other.simulate(start=self.before)
            self.assertIn(words, str(caught.exception))

    def test_ctrl_c_ends_it(self):
        calls = []

        def press(*said):
            calls.append(said)
            signal.raise_signal(signal.SIGINT)

        other = self.scene.copy()
        other.set("chamber.cavity.pressure", 15e3)
        with self.assertRaises(KeyboardInterrupt):
            other.simulate(progress=press, start=self.before)
        self.assertEqual(len(calls), 1)


class Scenarios(unittest.TestCase):
    def test_a_scenario_is_the_scene_with_its_changes(self):
        drawn = scene()
        thin = drawn.scenario(name="thin", modulus=0.9, pressure=500, wall={"top": -0.2e-3}, weights={"bends": 2})
        self.assertAlmostEqual(thin.get("material.body.c1"), 0.9 * 55e3, 6)
        self.assertEqual(thin.get("chamber.cavity.pressure"), 20.5e3)
        top = np.unique(drawn.body.tags["top"])
        self.assertAlmostEqual(drawn.vertices[top, 2].min() - thin.vertices[top, 2].min(), 0.2e-3, 6)
        self.assertEqual(drawn.get("material.body.c1"), 55e3)
        # it says itself as TOML with all of that
        with tempfile.TemporaryDirectory() as folder:
            again = sp.load(thin.write(folder))
        self.assertEqual(again.numbers, thin.numbers)
        np.testing.assert_array_equal(again.vertices, thin.vertices)
        alone = drawn.scenario(numbers={"material.body.c1": 60e3})
        self.assertEqual(alone.get("material.body.c1"), 60e3)

    def test_scenes_run_beside_each_other(self):
        drawn = scene()
        cases = [drawn, drawn.scenario(modulus=0.8), drawn.scenario(pressure=2e3)]
        runs = sp.simulate_all(cases)
        for case, run in zip(cases, runs):
            np.testing.assert_array_equal(run.displacement, case.simulate().displacement)
        rises = [run.probe("height") for run in runs]
        self.assertTrue(rises[0] < rises[1] and rises[0] < rises[2])
        near = sp.simulate_all(cases, start=runs[0])
        np.testing.assert_allclose([run.probe("height") for run in near], rises, rtol=1e-8)

    def test_bad_scenarios_have_the_words_of_the_programs(self):
        for words, changes in [
            ("did you mean `wall`?", {"wal": 1e-3}),
            ("modulus = -1: must be positive", {"modulus": -1}),
            ("friction: there is none in [contact] of the scene", {"friction": 0.5}),
            ("no such number", {"numbers": {"material.body.c9": 1}}),
            ("turn an element over", {"wall": {"top": -9e-3}}),
        ]:
            with self.assertRaises(sp.InputError, msg=words) as caught:
                scene().scenario(**changes)
            self.assertIn(words, str(caught.exception))


class Programs(unittest.TestCase):
    """The programs lie in the folder that PUFFER_BIN names, not in the package."""

    def setUp(self):
        from softpuffer import programs

        before = programs.BIN
        programs.BIN = pathlib.Path(os.environ["PUFFER_BIN"])
        self.addCleanup(setattr, programs, "BIN", before)

    def test_what_fails_says_why(self):
        with tempfile.TemporaryDirectory() as folder:
            bad = pathlib.Path(folder) / "bad.msh"
            bad.write_text("no mesh")
            with self.assertRaises(sp.ProgramError) as caught:
                sp.fab.plan(bad)
            self.assertEqual(str(caught.exception), f'fab: {bad}: not a Gmsh file: it begins with "no", not "$MeshFormat"')
            self.assertEqual((caught.exception.program, caught.exception.returncode), ("fab", 2))
            with self.assertRaises(sp.ProgramError) as caught:
                sp.new(pathlib.Path(folder) / "mine", like="zebra")
            self.assertIn("there is no zebra", str(caught.exception))
            sp.new(pathlib.Path(folder) / "mine", like="beam")
            with self.assertRaises(sp.ProgramError) as caught:
                sp.new(pathlib.Path(folder) / "mine")
            self.assertIn("is there already; give another name", str(caught.exception))


def chapter():
    """The pieces of Python of the book's chapter."""
    page = (pathlib.Path(__file__).parents[2] / "pipelines/book/python.md").read_text()
    return [part.split("```")[0] for part in page.split("```python\n")[1:]]


class SciPy(unittest.TestCase):
    def test_the_design_of_the_chapter_is_found(self):
        piece = next(piece for piece in chapter() if "scipy" in piece)
        names = {"sp": sp, "scene": scene(material="dragon-skin-10-medium", chambers={"cavity": 10e3})}
        with contextlib.redirect_stdout(io.StringIO()):
            exec(compile(piece.replace('"rise"', '"height"'), "python.md", "exec"), names)
        start, end = names["objective"]([1, 1])[0], names["found"].fun
        self.assertLess(end, 0.5 * start)


class Meshio(unittest.TestCase):
    def test_a_body_comes_from_a_mesh_of_meshio(self):
        import meshio

        vertices, tets, tags = box()
        body = sp.Body(vertices, tets, tags, {"core": np.arange(10)})
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "body.msh"
            body.write(path)
            read = meshio.read(path)
        facets = np.concatenate(list(tags.values()))
        begins = np.cumsum([0, *map(len, tags.values())])
        # in millimetres, with a point that nothing uses, and sets in place of groups
        sets = {name: [np.arange(a, b), None] for name, a, b in zip(tags, begins, begins[1:])}
        sets["core"] = [None, np.arange(10)]
        cells = [("triangle", facets + 1), ("tetra", tets + 1)]
        other = meshio.Mesh(np.vstack([[[9, 9, 9]], 1e3 * vertices]), cells, cell_sets=sets)
        for found in (sp.Body.from_meshio(read), sp.Body.from_meshio(other, scale=1e-3)):
            np.testing.assert_allclose(found.vertices, vertices, rtol=1e-15)
            np.testing.assert_array_equal(found.tets, body.tets)
            self.assertEqual({name: len(of) for name, of in found.tags.items()}, {name: len(of) for name, of in tags.items()})
            np.testing.assert_array_equal(found.volumes["core"], np.arange(10))
        with self.assertRaises(sp.InputError) as caught:
            sp.Body.from_meshio(meshio.Mesh(vertices, [("triangle", facets)]))
        self.assertIn("no tetrahedra of four nodes; it has: triangle", str(caught.exception))


class PyVista(unittest.TestCase):
    def test_bodies_scenes_and_runs_are_shown(self):
        one = scene()
        for blocks in (one.body.to_pyvista(), one.to_pyvista()):
            self.assertEqual(blocks.keys(), ["body", "tag seat", "tag cavity", "tag top"])
            self.assertEqual(blocks["body"].n_cells, len(one.body.tets))
            self.assertAlmostEqual(blocks["tag top"].area, EDGE**2, 12)
        run = one.simulate()
        np.testing.assert_allclose(run.to_pyvista().points, run.nodes + run.displacement, atol=1e-12)


class Keys(unittest.TestCase):
    def test_typed_keys_are_those_of_the_programs(self):
        from softpuffer.tables import Changes, Tables

        def properties(kind):
            command = [os.path.join(os.environ["PUFFER_BIN"], "solver"), "schema", kind]
            return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)

        known = set(properties("sim")["properties"]) - {"puffer", "include"}
        own = {"mesh", "body", "material", "fixed", "chamber", "probe", "degree"}
        self.assertEqual(known - own, set(Tables.__annotations__))
        schema = properties("design")
        of_scenario = schema["definitions"]["ScenarioConfig"]["properties"]
        self.assertEqual(set(of_scenario), set(Changes.__annotations__))


class Book(unittest.TestCase):
    def test_the_pieces_of_the_chapter_run(self):
        pieces = chapter()
        self.assertEqual(len(pieces), 9)
        before = os.getcwd()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            try:
                sp.Body(*box()).write("tagged.msh")
                names = {}
                for piece in pieces:
                    if "scipy" in piece:
                        continue
                    with contextlib.redirect_stdout(io.StringIO()):
                        exec(compile(piece, "python.md", "exec"), names)
                self.assertTrue(os.path.exists("saved/report.json") and os.path.exists("state.vtu"))
            finally:
                os.chdir(before)
        self.assertTrue(0 < names["curve"][0] < names["curve"][1] < names["curve"][2])


if __name__ == "__main__":
    sys.exit(not unittest.main(exit=False, verbosity=2).result.wasSuccessful())
