"""The bench `flight`: designs that pass a standard with springs chosen for it, and frequencies against MuJoCo."""
