"""Synthesis of machine settings: from a blank, a cutter and contact targets."""
