"""Version of the program, and version of the solver in stored results."""

__version__ = "0.1.0"
# increased if the results of a contact change by more than rounding
SOLVER = f"ehl {__version__}, engine 11"
