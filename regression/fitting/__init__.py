"""Fitting a friction formula and measuring its error on unseen contacts."""
