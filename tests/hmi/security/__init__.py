"""Who somebody is, and what reaches the console."""
