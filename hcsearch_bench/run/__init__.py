"""The frame of all benches: clocks, processes, the machine, tables and plots."""
