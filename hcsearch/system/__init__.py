"""Services of the operating system and the interpreter: input and output files, cores, Ctrl-C, imports on demand."""
