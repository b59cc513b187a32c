"""A bending actuator in MuJoCo: a chain of hinges from a table of `solver map --tip TAG`.

    python mujoco_chain.py map.csv --base 0 0 0 -o chain.xml
    python mujoco_chain.py map.csv --base 0 0 0 -o chain.xml --check       # needs: pip install mujoco

The table has one number, the pressure, from 0 on. One tendon pulls all hinges and a slide alike; its control is the pressure
in Pa. The stiffness of a hinge comes from the compliance of the tip at rest, where the hinges are from the derivatives there,
and the gain from all rows: the angle is a straight line through them. SI units.
"""

import argparse
import csv

import numpy as np

LINKS = 10
POSE = ["x", "y", "z", "rx", "ry", "rz"]


def read(path):
    """The rows of a table with an equilibrium: pressures, poses, slopes of the first row, its compliance."""
    with open(path, newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["status"] == "ok"]
    number = next(iter(rows[0]))
    pressure = np.array([float(row[number]) for row in rows])
    pose = np.array([[float(row[f"tip.{axis}"]) for axis in POSE] for row in rows])
    slope = np.array([float(rows[0][f"d tip.{axis}/d {number}"]) for axis in POSE])
    stiffness = np.zeros((6, 6))
    for i, a in enumerate(POSE):
        for j, b in enumerate(POSE[i:], i):
            stiffness[i, j] = stiffness[j, i] = float(rows[0][f"k.{a}.{b}"])
    if pressure[0] != 0:
        raise SystemExit(f"{path}: the first row has {number} = {pressure[0]}; expected 0")
    return pressure, pose, slope, np.linalg.inv(stiffness)


def chain(pressure, pose, slope, compliance, base):
    """The model as text."""
    along = pose[0, :3] - base
    length = np.linalg.norm(along)
    along /= length
    turn = slope[3:]                                    # [rad/Pa]
    axis = turn - along * (along @ turn)
    axis /= np.linalg.norm(axis)
    side = np.cross(axis, along)
    # it bends around a place this far before the tip, and evenly about there
    arm = np.clip((side @ slope[:3]) / (axis @ turn), 0.0, length)
    active = 2 * min(arm, length - arm)
    hinges = length - arm + active * ((np.arange(LINKS) + 0.5) / LINKS - 0.5)
    stiffness = LINKS / (axis @ compliance[3:, 3:] @ axis)
    angle = pose[:, 3:] @ axis
    gain = stiffness / LINKS * (angle @ pressure) / (pressure @ pressure)
    # a slide for the change of length
    stretching = 1 / (along @ compliance[:3, :3] @ along)
    stretch = (along @ slope[:3]) * stretching / gain
    lines = [
        '<mujoco model="actuator">',
        '  <option gravity="0 0 0" integrator="implicitfast" timestep="0.001"/>',
        "  <worldbody>",
        f'    <body pos="{text(base)}">',
        f'      <joint name="slide" type="slide" axis="{text(along)}" stiffness="{stretching:.9g}" '
        f'damping="{0.05 * stretching:.9g}"/>',
    ]
    ends = [*hinges, length]
    lines.append(f'      <geom type="capsule" size="0.002" mass="0.001" fromto="0 0 0 {text(along * ends[0])}"/>')
    start = 0.0
    for i in range(LINKS):
        step = ends[i + 1] - ends[i]
        lines += [
            f'      <body pos="{text(along * (ends[i] - start))}">',
            f'      <joint name="hinge{i}" type="hinge" axis="{text(axis)}" stiffness="{stiffness:.9g}" '
            f'damping="{0.05 * stiffness:.9g}"/>',
            f'      <geom type="capsule" size="0.002" mass="0.001" fromto="0 0 0 {text(along * step)}"/>',
        ]
        start = ends[i]
    lines.append(f'      <site name="tip" pos="{text(along * (length - start))}"/>')
    lines += ["      </body>"] * LINKS + ["    </body>", "  </worldbody>", "  <tendon>", '    <fixed name="air">']
    lines.append(f'      <joint joint="slide" coef="{stretch:.9g}"/>')
    lines += [f'      <joint joint="hinge{i}" coef="1"/>' for i in range(LINKS)]
    lines += ["    </fixed>", "  </tendon>", "  <actuator>"]
    lines.append(
        f'    <general name="pressure" tendon="air" gainprm="{gain:.9g}" ctrllimited="true" '
        f'ctrlrange="0 {pressure.max():.9g}"/>'
    )
    return "\n".join([*lines, "  </actuator>", "</mujoco>", ""])


def text(vector):
    return " ".join(f"{value:.9g}" for value in vector)


def check(model, pressure, pose):
    """Compares the tip at rest under each pressure with the table."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(model)
    print("pressure [Pa]  moved [mm]  off [mm]  angle [deg]  off [deg]")
    for p, (x, y, z, *turn) in zip(pressure, pose):
        data = mujoco.MjData(model)
        data.ctrl[0] = p
        for _ in range(5000):
            mujoco.mj_step(model, data)
        found = data.site("tip").xpos
        moved = np.linalg.norm([x, y, z] - pose[0, :3])
        matrix, quaternion, rotation = data.site("tip").xmat, np.zeros(4), np.zeros(3)
        mujoco.mju_mat2Quat(quaternion, matrix)
        mujoco.mju_quat2Vel(rotation, quaternion, 1.0)
        off = np.linalg.norm(found - [x, y, z])
        angle, turned = np.degrees(np.linalg.norm(turn)), np.degrees(np.linalg.norm(rotation - turn))
        print(f"{p:13.0f} {1e3 * moved:11.2f} {1e3 * off:9.2f} {angle:12.2f} {turned:10.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", help="CSV of solver map --tip TAG")
    parser.add_argument("--base", type=float, nargs=3, required=True, help="where the actuator is held [m]")
    parser.add_argument("-o", "--output", required=True, help="the model (MJCF)")
    parser.add_argument("--check", action="store_true", help="compare MuJoCo's equilibria with the table")
    arguments = parser.parse_args()
    pressure, pose, slope, compliance = read(arguments.table)
    model = chain(pressure, pose, slope, compliance, np.array(arguments.base))
    with open(arguments.output, "w") as file:
        file.write(model)
    if arguments.check:
        check(model, pressure, pose)


if __name__ == "__main__":
    main()
