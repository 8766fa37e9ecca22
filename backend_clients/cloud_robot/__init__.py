"""What a console and a robot's cloud agent say to each other through a context broker; see docs/protocols/cloud.md."""
