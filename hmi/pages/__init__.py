"""One module per screen: lays out, subscribes, submits."""
