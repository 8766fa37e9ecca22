"""Map files of other programs: reading them without trusting them, and writing the farm map for them."""
