"""
A blank from main dimensions
============================

Cones and tooth depths of both members, after ISO 23509.
"""

import efficiency

blank = efficiency.blank("iso23509_f2")
table = blank.to_dict()
answer = table["gear"]["teeth"] / table["pinion"]["teeth"]
print(f"ratio {answer:.4f}")
axes = blank.plot()
