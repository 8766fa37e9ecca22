"""The process keeper: starts, watches and restarts the processes of one installation."""
