"""What one controller survives, in every direction and phase of a step."""
