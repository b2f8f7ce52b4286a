"""WHAT DECIDES: one file per published method, all with the same interface."""
