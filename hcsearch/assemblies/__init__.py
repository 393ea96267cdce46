"""Named assemblies of the thesis, and the general operations that make them."""
