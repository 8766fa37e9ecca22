"""Domain values to the words and numbers of a screen; pure."""
