"""Tables, figures, pages and animations of one contact."""

from __future__ import annotations
