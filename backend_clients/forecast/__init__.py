"""The open format of weather forecasts over HTTP, and its client; see docs/protocols/forecast.md."""
