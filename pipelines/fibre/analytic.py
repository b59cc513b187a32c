"""The bending of a half-round actuator over its pressure, by the balance of moments of Polygerinos et al. 2015.

The sheet in the floor does not stretch, the thread keeps the section, and the actuator bends to a circle: the
stretch along it is λ = 1 + κ z at the height z above the sheet, 1 around it, and 1/λ across its wall. The nominal
stress along it is 2 W′(I₁) (λ − λ⁻³), I₁ = λ² + 1 + λ⁻². Its moment about the sheet, over the silicone, is that of
the pressure p on the end. The law is Yeoh's, W = c₁ (I₁ − 3) + c₂ (I₁ − 3)².

There are two bounds. In the paper, the pressure acts on the end of the chamber. A thread that carries all of the
load around the tube leaves the wall within it under the pressure p across: what lengthens the tube is then the
pressure on all of the section within the thread.

With the closed end held at its height, a bar with the moment M of the pressure along the chamber, of length a, presses
there with F, L from the held end: M a (L − a/2) = F L³/3, whatever its stiffness, as long as it bends little.

python3 pipelines/fibre/analytic.py > analytic.csv
"""

from math import degrees, pi, sqrt

# sizes as in model.geo, heights above the lower side of the core [m]
LONG, FLOOR, SHEET, CAP = 80e-3, 2e-3, 0.0, 6e-3
# the law of Elastosil M4601 in the library [Pa]
C1, C2 = 110e3, 20e3
# sections: half-rounds on the floor's upper side, on rectangles. Radius and lower side [m]
CHAMBER, CORE, BODY = (8e-3, FLOOR), (10e-3, 0.0), (11e-3, -1e-3)
STRIPS = 1000


def width(section, height):
    """How wide a section is at a height [m]."""
    radius, low = section
    if height < low:
        return 0.0
    return 2 * sqrt(max(radius**2 - max(height - FLOOR, 0.0) ** 2, 0.0))


def moment(density, across):
    """∫ density(z) z dA about the sheet, of a section as wide as `across` at a height."""
    low, high = BODY[1], FLOOR + BODY[0]
    step = (high - low) / STRIPS
    heights = [low + (i + 0.5) * step for i in range(STRIPS)]
    return sum(density(h - SHEET) * (h - SHEET) * across(h) * step for h in heights)


def stress(stretch):
    """The nominal stress along the tube [Pa]."""
    invariant = stretch**2 + 1 + stretch**-2
    return 2 * (C1 + 2 * C2 * (invariant - 3)) * (stretch - stretch**-3)


def angles(pressure):
    """Angles by which it bends at a pressure [Pa] that acts within the thread, or on the chamber alone [°]."""
    bound = []
    for section in (CORE, CHAMBER):
        bends = pressure * moment(lambda _: 1.0, lambda h: width(section, h))
        low, high = 0.0, 2 * pi
        while high - low > 1e-5:
            middle = (low + high) / 2
            resists = moment(lambda z: stress(1 + middle / LONG * z), silicone)
            low, high = (middle, high) if resists < bends else (low, middle)
        bound.append(degrees(low))
    return bound


def forces(pressure):
    """Forces on a held tip at a pressure [Pa] that acts within the thread, or on the chamber alone [N]."""
    reach = LONG + CAP
    moments = (pressure * moment(lambda _: 1.0, lambda h: width(section, h)) for section in (CORE, CHAMBER))
    return [3 * bends * LONG * (reach - LONG / 2) / reach**3 for bends in moments]


def silicone(height):
    """How wide the silicone is at a height [m]."""
    return width(BODY, height) - width(CHAMBER, height)


if __name__ == "__main__":
    print("pressure [Pa],within the thread [°],on the chamber [°],within the thread [N],on the chamber [N]")
    for pressure in range(0, 120001, 10000):
        numbers = [f"{angle:.2f}" for angle in angles(pressure)] + [f"{force:.3f}" for force in forces(pressure)]
        print(pressure, *numbers, sep=",")
