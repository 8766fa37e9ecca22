"""Live values to the browsers over one raw websocket each."""
