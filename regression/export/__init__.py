"""A fitted formula as a program text: Python, C, Fortran, MATLAB."""
