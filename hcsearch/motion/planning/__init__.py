"""Motion planning: certified paths of a folding from its packed to its flat state."""
