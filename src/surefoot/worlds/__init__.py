"""WHAT MOVES: a point mass on two feet, and a body in physics."""
