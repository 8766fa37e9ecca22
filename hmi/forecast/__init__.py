"""The weather forecast of the farm: asked of a service now and then, kept while it may be relied on."""
