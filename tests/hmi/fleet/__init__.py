"""The fleet as a whole: group orders, groups, duty, wall screens, today's figures."""
