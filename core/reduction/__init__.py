"""How many vertices of a body are simulated: proxies (cells, proxy), what they cost and how near they are (benchmark),
and the planner that chooses one.
"""
