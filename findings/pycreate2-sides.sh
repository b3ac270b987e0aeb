#!/usr/bin/env bash
# The Create 2 library of PyPI says left where the robot said right.
#
# Version: pycreate2 0.8.0 (PyPI), Python 3.11.
# Behaviour: `get_sensors()` fills the fields of bumps and wheel drops in the order right, left, right, left, but names them
# left, right, left, right: a bump on the robot's right (bit 0 of packet 7, Open Interface Specification) is `bump_left`, a
# dropped right wheel (bit 2) is `wheeldrop_left`. The overcurrent of the right wheel (bit 3 of packet 14) is said to be the
# left wheel's, because its bits are counted without the gap that the specification leaves at bit 1.
# What follows: a program that turns away from a bump turns into it; whoever tests a robot with this library must swap the sides.
#
# Output seen on 2026-11-30:
#   bump right: bump_left=True bump_right=False
#   bump left: bump_left=False bump_right=True
#   drop right: wheeldrop_left=True wheeldrop_right=False
#   drop left: wheeldrop_left=False wheeldrop_right=True
#   overcurrent right wheel: left=True right=False
set -euo pipefail
folder="$(mktemp -d)"
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check pycreate2==0.8.0
cat >look.py <<'PYTHON'
from pycreate2.packets import SensorPacketDecoder


def group_100(bumps=0, overcurrents=0):
    """The 80 bytes of group 100: packet 7 is the first, packet 14 the eighth."""
    data = bytearray(80)
    data[0], data[7] = bumps, overcurrents
    return SensorPacketDecoder(bytes(data))


wrong = False
for name, found, expected in [
    ("bump right", group_100(bumps=1).bumps_wheeldrops, "bump_left=True bump_right=False"),
    ("bump left", group_100(bumps=2).bumps_wheeldrops, "bump_left=False bump_right=True"),
    ("drop right", group_100(bumps=4).bumps_wheeldrops, "wheeldrop_left=True wheeldrop_right=False"),
    ("drop left", group_100(bumps=8).bumps_wheeldrops, "wheeldrop_left=False wheeldrop_right=True"),
]:
    fields = [word.split("=")[0] for word in expected.split()]
    said = " ".join(f"{field}={getattr(found, field)}" for field in fields)
    print(f"{name}: {said}")
    wrong |= said != expected
wheels = group_100(overcurrents=8).overcurrents
said = f"left={wheels.left_wheel_overcurrent} right={wheels.right_wheel_overcurrent}"
print(f"overcurrent right wheel: {said}")
wrong |= said != "left=True right=False"
raise SystemExit("it behaves otherwise now" if wrong else 0)
PYTHON
env/bin/python look.py
