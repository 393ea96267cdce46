"""Identification of springs and dampers from measurements: moment-angle data and free vibration."""
