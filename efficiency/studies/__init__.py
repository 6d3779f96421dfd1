"""Studies with gear pairs: the parameter study and the demonstration."""
