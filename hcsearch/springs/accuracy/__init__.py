"""How accurate a deployment is: error against run time, error bars, what was left out, and numerical stability."""
