"""WHAT HAPPENED: a walk, its outcome, its measures and its files."""
