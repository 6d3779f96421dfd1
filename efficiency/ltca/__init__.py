"""Loaded tooth contact analysis (LTCA): compliance, equilibrium, load distribution."""
