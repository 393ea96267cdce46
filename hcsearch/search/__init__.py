"""Many designs: circuits are listed, taken through the stages, ranked and stored."""
