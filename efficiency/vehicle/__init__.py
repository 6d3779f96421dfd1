"""Vehicle formats: losses of an axle, VECTO and 40 CFR 1037.560."""
