"""How much of a body is simulated: proxies, and the planner that chooses one."""
