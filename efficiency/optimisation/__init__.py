"""Search for the ease-off of a pair that loses less, within limits of pressure, noise, edge load and root stress."""
