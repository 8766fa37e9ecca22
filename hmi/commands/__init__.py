"""Everything that asks a robot to do something."""
