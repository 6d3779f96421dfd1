"""Calibration of oil and surface parameters of the contact solver to measured friction.

Bounded, robust least squares on the solver give parameters with intervals and an oil card.
"""
