"""Tests of a simulation as a function of PyTorch and JAX, run by tests/fast/python.rs."""

import sys
import unittest

import numpy as np

import softpuffer as sp
from package import crossed, scene

PRESSURE, CROSSED = "chamber.cavity.pressure", "chamber.below.cavity.pressure"


class Torch(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        import torch

        cls.torch, cls.scene = torch, scene()
        cls.pressure = torch.tensor(20e3, dtype=torch.float64, requires_grad=True)

    def test_gradcheck_passes(self):
        torch, body, one = self.torch, self.scene, self.torch.ones((), dtype=self.torch.float64)
        at = torch.tensor(body.vertices)

        def moved(x, pressure, c1):
            numbers = {PRESSURE: 20e3 * pressure, "material.body.c1": 55e3 * c1}
            # of order one, and not all of them
            return 1e5 * sp.torch.simulate(body, at + 1e-3 * x, numbers)[::9]

        inputs = [torch.zeros_like(at), one, one.clone()]
        [x.requires_grad_() for x in inputs]
        self.assertTrue(torch.autograd.gradcheck(moved, inputs, eps=1e-5, atol=1e-4, rtol=1e-4))

    def test_a_batch_is_its_cases(self):
        pressures = self.torch.tensor([5e3, 10e3, 20e3], dtype=self.torch.float64)
        together = sp.torch.simulate_batch(self.scene, None, {PRESSURE: pressures})
        for pressure, found in zip(pressures, together):
            alone = sp.torch.simulate(self.scene, None, {PRESSURE: pressure})
            self.assertTrue(self.torch.equal(alone, found))

    def test_a_batch_of_several_lengths_is_refused(self):
        vertices = self.torch.tensor(np.stack([self.scene.vertices] * 2))
        for words, inputs in [
            ("3 of chamber.cavity.pressure, 2 of vertices", (vertices, {PRESSURE: [1e3, 2e3, 3e3]})),
            ("3 of chamber.cavity.pressure, 1 of material.body.c1", (None, {PRESSURE: [1e3] * 3, "material.body.c1": [5e4]})),
            ("0 of chamber.cavity.pressure", (None, {PRESSURE: []})),
        ]:
            with self.assertRaises(sp.InputError, msg=words) as caught:
                sp.torch.simulate_batch(self.scene, *inputs)
            self.assertIn(words, str(caught.exception))

    def test_integers_are_numbers(self):
        wanted = sp.torch.simulate(self.scene, None, {PRESSURE: 20e3})
        for value in (20000, self.torch.tensor(20000), self.torch.tensor([20000])):
            found = sp.torch.simulate(self.scene, None, {PRESSURE: value})
            self.assertTrue(found.is_floating_point() and self.torch.equal(found, wanted))
        with self.assertRaises(sp.InputError) as caught:
            sp.torch.simulate(self.scene, None, {PRESSURE: self.torch.tensor(1j)})
        self.assertIn("needed real numbers", str(caught.exception))
        with self.assertRaises(sp.InputError) as caught:
            sp.torch.simulate(self.scene, None, {PRESSURE: self.torch.tensor([1.0, 2.0])})
        self.assertIn("an array of shape [2], needed one number", str(caught.exception))

    def test_second_derivatives_are_refused(self):
        # of a sum, too, whose own second derivative is zero
        total = lambda pressure: sp.torch.simulate(self.scene, None, {PRESSURE: pressure}).sum()
        for loss in (total, lambda pressure: total(pressure) ** 2):
            with self.assertRaises(sp.InputError) as caught:
                self.torch.autograd.functional.hessian(loss, self.pressure.detach())
            self.assertIn("no second derivatives", str(caught.exception))
        (first,) = self.torch.autograd.grad(total(self.pressure), self.pressure, create_graph=True)
        with self.assertRaises(sp.InputError):
            first.backward()

    def test_a_run_that_must_not_be_used_is_refused(self):
        bad = crossed()
        with self.assertRaises(sp.UnusableRun):
            sp.torch.simulate(bad, None, {CROSSED: bad[CROSSED]})
        found = sp.torch.simulate(bad, None, {CROSSED: bad[CROSSED]}, unusable="return")
        self.assertGreater(float(found.abs().max()), 0)
        with self.assertRaises(sp.NoEquilibrium):
            sp.torch.simulate(self.scene, None, {PRESSURE: 3e6})


class Jax(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        import jax

        jax.config.update("jax_enable_x64", True)
        cls.jax, cls.scene = jax, scene()

    def loss(self, x, pressure):
        u = sp.jax.simulate(self.scene, self.scene.vertices + x, {PRESSURE: pressure})
        return (u**2).sum() * 1e6

    def test_gradients_are_central_differences(self):
        still, pressure, loss = np.zeros_like(self.scene.vertices), 20e3, self.loss
        by_x, by_pressure = self.jax.grad(loss, argnums=(0, 1))(still, pressure)
        direction = np.random.default_rng(2).uniform(-1, 1, still.shape) * 1e-6
        central = (loss(direction, pressure) - loss(-direction, pressure)) / 2
        self.assertAlmostEqual(float(np.vdot(by_x, direction) / central), 1, 5)
        central = (loss(still, pressure + 10) - loss(still, pressure - 10)) / 20
        self.assertAlmostEqual(float(by_pressure / central), 1, 5)
        self.assertEqual(float(self.jax.jit(loss)(still, pressure)), float(loss(still, pressure)))

    def test_a_batch_is_its_cases(self):
        pressures = np.array([5e3, 10e3, 20e3])
        for of in (lambda p: self.loss(0.0, p), self.jax.grad(lambda p: self.loss(0.0, p))):
            alone = [float(of(pressure)) for pressure in pressures]
            np.testing.assert_array_equal(self.jax.vmap(of)(pressures), alone)
            np.testing.assert_allclose(self.jax.jit(self.jax.vmap(of))(pressures), alone, rtol=1e-12)

    def test_an_array_of_one_value_is_a_number(self):
        wanted = self.jax.grad(lambda p: self.loss(0.0, p))(20e3)
        found = self.jax.grad(lambda p: self.loss(0.0, p))(np.array([20e3]))
        self.assertEqual(found.shape, (1,))
        self.assertEqual(float(found[0]), float(wanted))
        with self.assertRaises(sp.InputError) as caught:
            self.loss(0.0, np.array([1e3, 2e3]))
        self.assertIn("an array of shape [2], needed one number", str(caught.exception))

    def test_exceptions_are_those_of_the_package(self):
        for raised, pressure in [(sp.NoEquilibrium, 3e6), (sp.InputError, float("nan"))]:
            for of in (self.loss, self.jax.grad(self.loss, argnums=1)):
                with self.assertRaises(raised):
                    of(0.0, pressure)
            with self.assertRaises(raised):
                self.jax.vmap(self.loss, (None, 0))(0.0, np.array([1e3, pressure]))
            with self.assertRaises(raised), sp.jax.exceptions():
                self.jax.jit(self.loss)(0.0, pressure).block_until_ready()
        bad = crossed()
        with self.assertRaises(sp.UnusableRun):
            sp.jax.simulate(bad, None, {CROSSED: bad[CROSSED]})

    def test_second_derivatives_are_refused(self):
        with self.assertRaises(sp.InputError) as caught:
            self.jax.grad(self.jax.grad(lambda p: sp.jax.simulate(self.scene, None, {PRESSURE: p}).sum()))(20e3)
        self.assertIn("no second derivatives", str(caught.exception))


if __name__ == "__main__":
    sys.exit(not unittest.main(exit=False, verbosity=2).result.wasSuccessful())
