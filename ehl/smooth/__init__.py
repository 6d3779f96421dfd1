"""Smooth, steady line contact: tracked exit, graded mesh, full Newton, values with a grid error."""
