"""Parameter study and demonstration."""
