"""What is: the robot, its gait limits, the pendulum, feet, pushes, and the seam."""
