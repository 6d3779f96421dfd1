"""What a sweep varies: axes, constraints, sampling, points, operating range of gears."""

from __future__ import annotations
