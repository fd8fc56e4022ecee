"""The number of vertices that are simulated: proxies, their cost, and the rule that chooses one."""
