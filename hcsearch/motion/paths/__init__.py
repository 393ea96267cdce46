"""Motions of linkages followed from state to state: predictors, branches, singular states, descents."""
