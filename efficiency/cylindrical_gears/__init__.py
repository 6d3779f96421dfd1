"""Cylindrical gear pairs, spur and helical: the bridge to measured gear friction."""
