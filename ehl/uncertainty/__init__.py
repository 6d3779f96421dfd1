"""How well inputs are known, and the interval they leave of a result."""
