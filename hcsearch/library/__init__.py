"""Known mechanisms: the assemblies of the thesis, and units made of copies of one element."""
