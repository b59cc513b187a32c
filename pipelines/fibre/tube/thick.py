"""What the angle of fibres does to a long closed tube under pressure, without finite elements.

The wall keeps its volume. A point at the radius ρ at rest comes to r, r² = A² + (ρ² − a²)/λ, the tube is longer by
λ, and turns by τ along a length at rest. With μ = r/ρ there

I₁ = 1/(λμ)² + μ² + λ² + (rτ)²        I₄ = (λ cos α)² + (μ sin α + rτ cos α)²

for fibres at an angle α to the axis, positive for a right-handed screw. Of all A, λ and τ, those come that have the
least energy per length at rest, ∫ 2πρ (W(I₁) + ½ k₁ Σ max(I₄ − 1, 0)²) dρ − p π A² λ. Fibres are in the outer layer.

python3 pipelines/fibre/tube/thick.py
"""

from math import cos, degrees, pi, radians, sin, sqrt

# radii of chamber, layer and outside, length [m]; as in model.geo
INNER, LAYER, OUTER, LONG = 6e-3, 7e-3, 8e-3, 60e-3
# law of Elastosil M4601 in the library, fibres and pressure [Pa]; as in sim.toml
C1, C2, K1, PRESSURE = 110e3, 20e3, 10e6, 40e3
RINGS = 20


def energy(state, angles, pressure):
    """Energy per length at rest [J/m], of A/a − 1, λ − 1 and τ a."""
    wider, longer, turn = 1 + state[0], 1 + state[1], state[2] / INNER
    total = -pressure * pi * (wider * INNER) ** 2 * longer
    for low, high, fibres in ((INNER, LAYER, ()), (LAYER, OUTER, angles)):
        for i in range(RINGS):
            rho = low + (i + 0.5) * (high - low) / RINGS
            r = sqrt((wider * INNER) ** 2 + (rho**2 - INNER**2) / longer)
            mu = r / rho
            i1 = 1 / (longer * mu) ** 2 + mu**2 + longer**2 + (r * turn) ** 2
            density = C1 * (i1 - 3) + C2 * (i1 - 3) ** 2
            for angle in fibres:
                i4 = (longer * cos(angle)) ** 2 + (mu * sin(angle) + r * turn * cos(angle)) ** 2
                density += K1 / 2 * max(i4 - 1, 0) ** 2
            total += 2 * pi * rho * density * (high - low) / RINGS
    return total


def solve(a, b):
    """x of a x = b, by elimination."""
    n = len(b)
    rows = [[*row, value] for row, value in zip(a, b)]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(n):
            if i != k:
                factor = rows[i][k] / rows[k][k]
                rows[i] = [x - factor * y for x, y in zip(rows[i], rows[k])]
    return [rows[k][n] / rows[k][k] for k in range(n)]


def equilibrium(angles, pressure, steps=20):
    """A/a − 1, λ − 1 and τ a at a pressure, by Newton's method with differences."""
    state, by = [0.0] * 3, 1e-5
    for load in range(1, steps + 1):
        p = pressure * load / steps

        def at(*moves):
            moved = list(state)
            for index, step in moves:
                moved[index] += step
            return energy(moved, angles, p)

        for _ in range(40):
            slope = [(at((i, by)) - at((i, -by))) / (2 * by) for i in range(3)]
            curve = [
                [
                    (at((i, by), (j, by)) - at((i, by), (j, -by)) - at((i, -by), (j, by)) + at((i, -by), (j, -by)))
                    / (4 * by * by)
                    for j in range(3)
                ]
                for i in range(3)
            ]
            change = solve(curve, slope)
            most = max(map(abs, change))
            part = min(1.0, 0.02 / most) if most > 0 else 1.0
            state = [x - part * c for x, c in zip(state, change)]
            if most < 1e-8:
                break
    return state


if __name__ == "__main__":
    print("angle [°],longer by one [mm],twist by one [°],wider by one [%],longer by two [mm],wider by two [%]")
    for angle in (5, 15, 30, 45, 54.74, 60, 65, 75, 85, 90):
        a = radians(angle)
        one, two = equilibrium([a], PRESSURE), equilibrium([a, -a], PRESSURE)
        row = [1e3 * LONG * one[1], degrees(one[2] / INNER * LONG), 100 * one[0], 1e3 * LONG * two[1], 100 * two[0]]
        print(angle, *(f"{x:.3f}" for x in row), sep=",")
