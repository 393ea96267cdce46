"""Compiled dynamics of trees of rigid bodies with closed loops: recursions in linear time, hinge laws, stops, steps."""
