"""Loaded contact: compliance, equilibrium, load distribution."""
