"""Units, checks of inputs, shipped data, files and errors."""

from __future__ import annotations
