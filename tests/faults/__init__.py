"""What breaks in the field, done to the running parts."""
