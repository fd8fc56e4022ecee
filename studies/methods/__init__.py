"""Time-stepping methods that do not ship: what the charts compare the method of the product with.

Implicit ones share implicit (the loop), newton, tangent (the linear system), penalty (contact with an energy) and
cached (what is made once a model).
"""
