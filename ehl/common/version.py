"""Version of the program, and of the solver that stored results name."""

__version__ = "0.1.0"
# goes up where the numbers of a contact change by more than rounding
SOLVER = f"ehl {__version__}, engine 5"
