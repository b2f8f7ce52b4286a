"""What moves the world: simulators, rollouts, batches."""
