"""Known mechanisms: the assemblies of the thesis, and the search for units made of copies of one element."""
