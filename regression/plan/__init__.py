"""What a sweep varies: axes, constraints, sampling, points, operating range of gears."""
