"""Machine settings from a blank, a cutter and contact targets."""
