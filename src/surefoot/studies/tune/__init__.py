"""Weights and gains for a robot, by push survival and gentleness."""
