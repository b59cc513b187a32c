"""A scene of pipelines/ by FEniCSx with MUMPS: prints a line of JSON.

Run by `run.py` beside, with the Python of the system, which has dolfinx. The mesh, the law and the degree are those of `solver simulate`, and quadrature is exact
to the same degree. Newton's method is plain, so that the load comes in steps.
"""

import json
import sys
import time
import tomllib
from pathlib import Path

import dolfinx
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc
from dolfinx.mesh import create_mesh, exterior_facet_indices, meshtags
from mpi4py import MPI
from petsc4py import PETSc

# Largest number of iterations of a load step, and the residual relative to that at its start that ends one.
ITERATIONS = 15
RELATIVE = 1e-9
# First part of the load.
FIRST = 0.125


def read_mesh(path):
    """Points, tetrahedra, triangles and their names from a Gmsh file of version 2.2."""
    lines = iter(path.read_text().splitlines())
    names, points, tets, triangles, tags = {}, None, [], [], []
    for line in lines:
        if line == "$PhysicalNames":
            for _ in range(int(next(lines))):
                dimension, number, name = next(lines).split(maxsplit=2)
                if dimension == "2":
                    names[name.strip('"')] = int(number)
        elif line == "$Nodes":
            count = int(next(lines))
            points = np.array([next(lines).split()[1:] for _ in range(count)], dtype=float)
        elif line == "$Elements":
            for _ in range(int(next(lines))):
                fields = [int(field) for field in next(lines).split()]
                nodes = [node - 1 for node in fields[3 + fields[2] :]]
                if fields[1] == 4:
                    tets.append(nodes)
                elif fields[1] == 2:
                    triangles.append(sorted(nodes))
                    tags.append(fields[3])
    return names, points, np.array(tets), triangles, tags


def tag_facets(mesh, triangles, tags):
    """The facets of the boundary with the tags of triangles."""
    mesh.topology.create_connectivity(2, 3)
    facets = np.array(exterior_facet_indices(mesh.topology), dtype=np.int32)
    original = np.array(mesh.geometry.input_global_indices)
    nodes = dolfinx.cpp.mesh.entities_to_geometry(mesh._mesh, 2, facets, False)
    of = {tuple(triangle): tag for triangle, tag in zip(triangles, tags)}
    values = np.array([of.get(tuple(sorted(original[n])), 0) for n in nodes], dtype=np.int32)
    return meshtags(mesh, 2, facets, values)


def energy_density(law, gradient):
    """The three-parameter Mooney-Rivlin law with d1 ln^2 J."""
    f = ufl.variable(gradient)
    c, j = f.T * f, ufl.det(f)
    i1 = j ** (-2 / 3) * ufl.tr(c) - 3
    i2 = j ** (-4 / 3) * (ufl.tr(c) ** 2 - ufl.tr(c * c)) / 2 - 3
    psi = law["c1"] * i1 + law["c2"] * i2 + law["c3"] * i1 * i2 + law["d1"] * ufl.ln(j) ** 2
    return f, psi


class Newton:
    """Newton's method with a direct solver, and what its iterations took [s]."""

    def __init__(self, residual, tangent, u, bcs):
        self.residual, self.tangent = fem.form(residual), fem.form(tangent)
        self.u, self.bcs = u, bcs
        self.matrix = petsc.create_matrix(self.tangent)
        self.vector = petsc.create_vector(self.residual)
        self.step = fem.Function(u.function_space)
        self.solver = PETSc.KSP().create(MPI.COMM_SELF)
        self.solver.setType("preonly")
        self.solver.getPC().setType("lu")
        self.solver.getPC().setFactorSolverType("mumps")
        self.solver.setOperators(self.matrix)
        self.wall, self.processor = [], []

    def norm(self):
        """The residual's norm where nothing is fixed."""
        with self.vector.localForm() as local:
            local.set(0)
        petsc.assemble_vector(self.vector, self.residual)
        fem.set_bc(self.vector, self.bcs, scale=0.0)
        return self.vector.norm()

    def solve(self):
        """Whether the load step has an equilibrium; `u` is then that."""
        norm = start = self.norm()
        for _ in range(ITERATIONS):
            wall, processor = time.perf_counter(), time.process_time()
            self.matrix.zeroEntries()
            petsc.assemble_matrix(self.matrix, self.tangent, self.bcs)
            self.matrix.assemble()
            self.solver.solve(self.vector, self.step.vector)
            self.u.x.array[:] -= self.step.x.array
            norm = self.norm()
            self.wall.append(time.perf_counter() - wall)
            self.processor.append(time.process_time() - processor)
            if not np.isfinite(norm) or norm > 1e6 * start:
                return False
            if norm < RELATIVE * start:
                return True
        return False


def main():
    """Solves the scene and prints what it took."""
    path = Path(sys.argv[1])
    scene = tomllib.loads(path.read_text())
    names, points, tets, triangles, tags = read_mesh((path.parent / scene["mesh"]).resolve())
    cell = ufl.Mesh(ufl.VectorElement("Lagrange", ufl.tetrahedron, 1))
    began = time.perf_counter()
    mesh = create_mesh(MPI.COMM_SELF, tets, points, cell)
    facets = tag_facets(mesh, triangles, tags)
    space = fem.VectorFunctionSpace(mesh, ("Lagrange", scene["degree"]))
    u, test = fem.Function(space), ufl.TestFunction(space)
    held = facets.find(names[scene["fixed"][0]["on"]])
    dofs = fem.locate_dofs_topological(space, 2, held)
    bcs = [fem.dirichletbc(np.zeros(3), dofs, space)]
    f, psi = energy_density(scene["material"], ufl.Identity(3) + ufl.grad(u))
    chamber = scene["chamber"][0]
    pressure = fem.Constant(mesh, 0.0)
    volume = ufl.dx(metadata={"quadrature_degree": 5})
    wall = ufl.ds(subdomain_data=facets, metadata={"quadrature_degree": 5})(names[chamber["on"]])
    pushed = pressure * ufl.det(f) * ufl.inv(f).T * ufl.FacetNormal(mesh)
    residual = ufl.inner(ufl.diff(psi, f), ufl.grad(test)) * volume + ufl.inner(pushed, test) * wall
    newton = Newton(residual, ufl.derivative(residual, u), u, bcs)
    load, part, steps = 0.0, FIRST, 0
    while load < 1:
        part = min(part, 1 - load)
        before = u.x.array.copy()
        pressure.value = (load + part) * chamber["pressure"]
        if newton.solve():
            load, part, steps = load + part, 1.5 * part, steps + 1
        else:
            u.x.array[:] = before
            part /= 2
            if part < 1e-3:
                sys.exit(f"no equilibrium beyond {load:.3f} of the load")
    result = {
        "dofs": 3 * space.dofmap.index_map.size_global,
        "iterations": len(newton.wall),
        "load_steps": steps,
        "wall_s": time.perf_counter() - began,
        "iteration_wall_s": float(np.median(newton.wall)),
        "iteration_processor_s": float(np.median(newton.processor)),
        "largest": float(np.linalg.norm(u.x.array.reshape(-1, 3), axis=1).max()),
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main()
