"""The media process: the 3D twin, beside the console so that a heavy scene or a native crash disturbs nobody."""
