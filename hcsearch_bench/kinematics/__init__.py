"""The bench `kinematics`: path methods, branches, descents, cost of closure, extreme scenes."""
