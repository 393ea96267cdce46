"""Single-DoF units: copies of one element that overlap in panels and hinges, searched for and proved."""
