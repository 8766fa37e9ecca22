"""The open format of planners over HTTP, and its client; see docs/protocols/planner.md."""
