"""The whole axle: mesh, bearings, seals, churning, and the oil temperature that they share."""
