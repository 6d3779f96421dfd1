"""Parameter study and the demonstration."""
