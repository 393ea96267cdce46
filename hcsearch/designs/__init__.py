"""What a design is: grids, arrays, circuits, foldings and their twist."""
