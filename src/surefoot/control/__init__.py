"""What decides: one file per published method, all with the same interface."""
