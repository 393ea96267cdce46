"""The bench `identification`: springs and damping from measurements with noise."""
