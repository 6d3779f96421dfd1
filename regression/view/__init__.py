"""Tables, figures and pages of sweeps and fits."""
