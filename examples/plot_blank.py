"""
A blank from main dimensions
============================

Contact ratios and the tooth numbers of the virtual gears, after ISO 23509.
"""

import efficiency

blank = efficiency.blank("iso23509_f2")
table = blank.to_dict()
answer = table["gear"]["teeth"] / table["pinion"]["teeth"]
print(blank)
