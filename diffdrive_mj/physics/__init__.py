"""MuJoCo: the robot's model, the engine that steps it, and `simulate`."""
