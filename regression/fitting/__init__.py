"""Fitting a friction formula and measuring its error on unseen contacts."""

from __future__ import annotations
