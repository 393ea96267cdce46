"""Springs and dampers from measurements: moment-angle data, free vibration."""
