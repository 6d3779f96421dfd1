"""Spiral bevel and hypoid gear pairs: geometry, contact, load, friction, power loss, efficiency."""

from __future__ import annotations

__version__ = "0.1.0"
