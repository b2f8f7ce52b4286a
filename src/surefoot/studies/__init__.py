"""Experiments over many rollouts."""
