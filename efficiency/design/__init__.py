"""Design files of gear pairs."""

from __future__ import annotations
