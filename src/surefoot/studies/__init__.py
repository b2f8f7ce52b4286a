"""Experiments over many walks: one folder each."""
