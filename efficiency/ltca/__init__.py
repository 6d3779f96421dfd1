"""Loaded tooth contact analysis (LTCA): tooth bending, local deformation (Weber, Hertz), load distribution.

Mesh stiffness, load sharing between tooth pairs and the contact of tooth edges follow from it. Imports `contact`.
"""
