"""One lubricated line contact: lubricant, elasticity, Reynolds equation, heat, asperities, friction."""

from __future__ import annotations

__version__ = "0.1.0"
