"""Tables, figures and pages of sweeps and fits."""

from __future__ import annotations
