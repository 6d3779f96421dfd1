"""Rough surfaces: generated and measured height profiles."""

from __future__ import annotations
