"""The point mass: its plant, its sensors, and many of it at once."""
