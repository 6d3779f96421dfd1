"""Parameter study: what torque, speed, temperature, roughness, offset and misalignment do to the efficiency."""
