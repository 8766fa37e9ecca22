"""What the console knows: live state in memory, everything worth keeping in SQL."""
