"""Loaded tooth contact analysis (LTCA): tooth bending, local deformation (Weber, Hertz), load distribution.

Results are mesh stiffness, load sharing between tooth pairs and edge contact. Imports `contact`.
"""
