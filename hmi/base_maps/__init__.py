"""Pictures that lie under the farm's map: reading tile archives, and making them from aerial photos."""
