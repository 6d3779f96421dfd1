"""Friction models: conditions, published formulas, fitted formulas and their files."""

from __future__ import annotations
