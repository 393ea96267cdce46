"""From path to machine: driven hinges, a time law, torques, and the motion simulated under position control."""
