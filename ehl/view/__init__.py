"""Tables, figures and pages of one contact."""

from __future__ import annotations
