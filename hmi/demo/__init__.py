"""The demo farm: two real sites, three simulated robots, missions ready to send and a short history."""
