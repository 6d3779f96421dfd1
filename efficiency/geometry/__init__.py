"""Geometry of a pair, and its misalignment study."""
