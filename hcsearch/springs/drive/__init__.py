"""Drives along certified paths: driven hinges, a time law, torques, and the motion under position control."""
