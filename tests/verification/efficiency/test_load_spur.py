"""A spur pair without profile shift: load sharing and stiffness have a textbook answer."""

import math

import pytest

import efficiency


def test_load_sharing_and_single_tooth_stiffness() -> None:
    """One pair alone carries all; in double contact the stiffest place takes more, each between 1/4 and 3/4.

    Stiffness: ISO 6336-1, theoretical single stiffness of a pair of solid gears, x = 0 (series unverified). The
    standard multiplies it by 0.8 to meet measurements; ours lies in between.
    """
    # 20 and 40 teeth of 3 mm and 20 deg: radii of pitch and base circle of the pinion
    torque, width, pitch, angle = 200.0, 20e-3, 0.03, math.radians(20.0)
    sine, base = math.sin(angle), pitch * math.cos(angle)
    given = {"torque": torque, "speed": 150.0, "temperature": 353.15, "oil": "75w90", "load_share": "elastic"}
    pair = efficiency.cylindrical((20, 40), "3 mm", "20 mm", **given)
    positions = pair.mesh(positions=24, points_per_line=15).load().grids.fine.positions
    shares = [list(p.share.values()) for p in positions]
    assert [sum(each) for each in shares] == pytest.approx([1.0] * 24, rel=1e-12)
    double = [each for each in shares if len(each) == 2]
    assert all(0.25 < share < 0.75 for each in double for share in each)
    path = [math.sqrt((r + 3e-3) ** 2 - (r / pitch * base) ** 2) - r * sine for r in (pitch, 2.0 * pitch)]
    assert len(double) / 24 == pytest.approx(sum(path) / (math.pi * base / 10) - 1.0, abs=1.5 / 24)
    singles = [p for p in positions if len(p.share) == 1]
    even = torque / base / width
    assert singles[0].load_per_length.mean() == pytest.approx(even, rel=1e-12)
    flexibility = 0.04723 + 0.15551 / 20 + 0.25791 / 40  # mm um/N
    stiffest = max(1e-9 * even / (p.approach * base) for p in singles)
    assert 0.8 / flexibility < stiffest < 1.0 / flexibility
