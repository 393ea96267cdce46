"""Identification of springs and dampers from measurements: moment-angle data, free vibration, films of a deployment."""
