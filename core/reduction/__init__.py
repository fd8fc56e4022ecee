"""How many vertices of a body are simulated: proxies, what they cost, and the planner that chooses one."""
