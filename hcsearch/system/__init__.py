"""What the program asks of the system it runs on: files read and written, cores, Ctrl-C, imports on demand."""
