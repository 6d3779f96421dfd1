"""Friction models: conditions, published formulas, fitted formulas and their files."""
