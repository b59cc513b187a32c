"""Tests of what becomes of a run: whether it may be used, copies, other processes and Ctrl-C; run by tests/fast/python.rs."""

import concurrent.futures
import copy
import multiprocessing
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings

import numpy as np

import softpuffer as sp
from package import SILICONE, box, crossed, moving_scene, scene


class Judged(unittest.TestCase):
    """Runs that `solver simulate` would refuse, or warn of."""

    def test_a_run_that_must_not_be_used_raises(self):
        bad = crossed()
        with self.assertRaises(sp.UnusableRun) as caught:
            bad.simulate()
        self.assertIn("run through each other at the end", str(caught.exception))
        self.assertEqual((caught.exception.run.usable, caught.exception.run.status), (False, "surfaces_crossed"))
        with self.assertWarns(sp.RunWarning):
            run = crossed().simulate(unusable="return")
        self.assertEqual(run.warnings[0], run.refusal)
        self.assertIn("surfaces_crossed", repr(run))
        with self.assertRaises(sp.UnusableRun):
            sp.simulate_all([scene(), bad])
        with self.assertRaises(sp.InputError):
            bad.simulate(unusable="ignore")

    def test_the_program_says_the_same(self):
        solver = os.path.join(os.environ["PUFFER_BIN"], "solver")
        path = "chamber.below.cavity.pressure"
        with tempfile.TemporaryDirectory() as folder:
            file, table = crossed().write(folder), os.path.join(folder, "map.csv")
            simulated = subprocess.run([solver, "simulate", file, "-o", folder], capture_output=True, text=True)
            mapped = subprocess.run([solver, "map", file, "--grid", f"{path}=0,1e3", "-o", table])
            rows = pathlib.Path(table).read_text().splitlines()
        self.assertEqual((simulated.returncode, mapped.returncode), (1, 1))
        self.assertIn(crossed().simulate(unusable="return").refusal, simulated.stderr)
        self.assertEqual([row.split(",")[1] for row in rows], ["status", "surfaces_crossed", "surfaces_crossed"])

    def test_a_response_marks_such_rows(self):
        bad, path = crossed(), "chamber.below.cavity.pressure"
        table = sp.response(bad, {path: [0.0, 1e3]})
        self.assertEqual(table.status, ["surfaces_crossed"] * 2)
        self.assertTrue(np.isnan(table["height"]).all())
        self.assertFalse(np.isnan(sp.response(bad, {path: [1e3]}, unusable="return")["height"]).any())

    def test_locking_is_said_once_of_a_scene(self):
        first = scene()
        with self.assertWarns(sp.RunWarning) as caught:
            run = first.simulate()
        self.assertIn("degree = 1", str(caught.warning))
        self.assertEqual(pathlib.Path(caught.filename).name, "runs.py")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            again = first.copy()
            again["chamber.cavity.pressure"] = 15e3
            self.assertTrue(any("degree = 1" in text for text in again.simulate().warnings))
            scene(solver={"locking": "never"}).simulate()
        self.assertTrue(run.usable and run.status == "ok")

    def test_a_run_has_its_own_scene(self):
        changed = scene()

        def change(*_):
            changed["chamber.cavity.pressure"] = 1e3

        run = changed.simulate(progress=change)
        self.assertEqual(run.scene["chamber.cavity.pressure"], 20e3)
        self.assertEqual(run.chambers["cavity"]["pressure"], 20e3)


def displaced(of):
    """Simulates in another process."""
    return of.simulate(progress=False).displacement


class Kept(unittest.TestCase):
    """Copies, and what goes to other processes."""

    def test_bodies_and_scenes_come_back(self):
        vertices, tets, tags = box()
        body = sp.Body(vertices, tets, tags, {"core": np.arange(10)})
        again = pickle.loads(pickle.dumps(body))
        np.testing.assert_array_equal(again.vertices, body.vertices)
        np.testing.assert_array_equal(again.tets, body.tets)
        for name in ("tags", "volumes"):
            own, other = getattr(body, name), getattr(again, name)
            self.assertEqual(list(own), list(other))
            [np.testing.assert_array_equal(own[key], other[key]) for key in own]
        self.assertIs(copy.deepcopy(body), body)
        first = scene()
        first.set({"wall.top": 0.1e-3, "material.body.c1": 50e3})
        for other in (pickle.loads(pickle.dumps(first)), copy.copy(first), copy.deepcopy(first)):
            self.assertEqual(other["material.body.c1"], 50e3)
            np.testing.assert_array_equal(displaced(other), displaced(first))
            other["material.body.c1"] = 60e3
        self.assertEqual(first["material.body.c1"], 50e3)

    def test_runs_come_back_with_their_derivatives(self):
        arch = scene(solver={"relative_tolerance": 1e-12, "follow": "arc-length"}, degree=1)
        for of in (scene(), moving_scene(), arch):
            run = of.simulate()
            again = pickle.loads(pickle.dumps(run))
            np.testing.assert_array_equal(again.displacement, run.displacement)
            np.testing.assert_array_equal(again.times, run.times)
            [np.testing.assert_array_equal(again.probes[name], run.probes[name]) for name in run.probes]
            self.assertEqual(again.scene.numbers, run.scene.numbers)
            wrt = ["shape", "material.body.c1"]
            (value, by), (same, other) = run.gradient("height", wrt), again.gradient("height", wrt)
            self.assertEqual(value, same)
            np.testing.assert_allclose(other["shape"], by["shape"], rtol=1e-9, atol=1e-12 * np.abs(by["shape"]).max())
            self.assertIs(copy.copy(run), run)
            self.assertIs(copy.deepcopy(run), run)
        with self.assertRaises(sp.InputError):
            run.scene._native.run_of_bytes(b"none")

    def test_a_forked_process_says_what_to_do(self):
        one = scene()
        context = multiprocessing.get_context("fork")
        with concurrent.futures.ProcessPoolExecutor(1, mp_context=context) as pool:
            with self.assertRaises(RuntimeError) as caught:
                pool.submit(displaced, one).result(timeout=60)
        self.assertIn('get_context("spawn")', str(caught.exception))
        # workers whose input cannot be read would be begun again and again
        run = one.simulate()
        with context.Pool(1) as pool:
            for work, of in ((displaced, one), (repr, run), (repr, one.body)):
                with self.assertRaises(RuntimeError) as caught:
                    pool.map_async(work, [of]).get(60)
                self.assertIn('get_context("spawn")', str(caught.exception))

    def test_a_spawned_process_simulates(self):
        one = scene()
        with concurrent.futures.ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
            found = pool.submit(displaced, one).result(timeout=120)
        np.testing.assert_array_equal(found, displaced(one))

    def test_ctrl_c_ends_an_adjoint(self):
        moving = scene(
            time={"method": "bdf2", "end": 0.02, "steps": 150},
            chambers={"cavity": "1e6*t"},
            material=SILICONE | {"density": 1070},
            degree=2,
        )
        run = moving.simulate()
        for of in ("height", lambda u: (u**2).sum()):
            work = lambda: run.gradient(of, "shape")
            whole = min(seconds(work) for _ in range(3))
            threading.Timer(whole / 8, os.kill, [os.getpid(), signal.SIGINT]).start()
            with self.assertRaises(KeyboardInterrupt):
                seconds(work, self)
                # where it was too fast for the signal
                time.sleep(60)
            # after an eighth of the time, and one step of the adjoint
            self.assertLess(self.took, whole / 2)
            # and the next one is as before
            self.assertEqual(list(work()[1]), ["shape"])


def seconds(work, to=None):
    """How long something takes, also where it is interrupted."""
    begin = time.monotonic()
    try:
        work()
    finally:
        took = time.monotonic() - begin
        if to is not None:
            to.took = took
    return took


if __name__ == "__main__":
    sys.exit(not unittest.main(exit=False, verbosity=2).result.wasSuccessful())
