"""Design files: every input of a gear pair, and the flanks and tooth bodies that follow from it.

Imports `blanks`, `cutting`, `contact` and `ltca`, which do not depend on design files.
"""
