"""Tables, figures and pages of one contact."""
