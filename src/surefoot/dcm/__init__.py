"""THE PENDULUM ON PAPER: pure functions of the DCM, of steps and of pushes."""
