"""The farm's side of the cloud: what goes up, what waits on disk while it cannot, and how the link is."""
