"""Transient rough mixed EHL of a line contact."""
