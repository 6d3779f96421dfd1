"""Rough contacts of the tests (`tests/twins/rough_scenes.py`) for the scripts on the rough solver."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from twins.rough_scenes import Scene, eyring_oil, gaussian_pair, line, speed_of_film_ratio

__all__ = ["Scene", "eyring_oil", "gaussian_pair", "line", "speed_of_film_ratio"]
