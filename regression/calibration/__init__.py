"""Calibration: oil and surface parameters of the contact solver fitted to measured friction.

measured table + setup ─> bounded, robust least squares on the solver ─> intervals, parameters held ─> oil card
"""
