"""From contact solutions to a friction formula: plan, sweep, dataset, fit, formula file."""

from __future__ import annotations

__version__ = "0.1.0"
