"""WHO WALKS: the robot's file, its mechanism, its legs."""
