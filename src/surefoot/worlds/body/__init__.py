"""A body in physics: its plant, its sensors, its estimator, and what walks it."""
