"""What stands in a field and measures: quantities, freshness, limits and what they mean for treatment."""
