"""What the console itself watches: rules that look at a robot and say what is wrong now."""
