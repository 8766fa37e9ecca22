"""The STOP process: nothing but STOP."""
