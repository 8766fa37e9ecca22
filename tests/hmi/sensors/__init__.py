"""Field sensors in the console."""
